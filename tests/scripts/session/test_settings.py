"""What a request's settings do: the file of settings, noise, behaviors."""

from __future__ import annotations

from pathlib import Path

import pytest
from tolman.agent.boundary.trace import ClosingConfig
from tolman.agent.errors import ConfigError
from tolman.plugins.errors import PluginError
from tolman.scripts.session.profiles import Profile, find_profile
from tolman.scripts.session.requests import MapRequest, SessionError
from tolman.scripts.session.settings import (
    LIMIT,
    configured,
    load_settings,
    mediator_of,
    parse_settings,
    recorded_settings,
)
from tolman.scripts.session.simulation import map_world


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "settings.yaml"
    path.write_text(text)
    return path


def mapped(tmp_path: Path, text: str, name: str = "map.tolman") -> Path:
    output = tmp_path / name
    config = written(tmp_path, text)
    map_world(
        MapRequest(
            world="env1", output=output, global_only=True, engine="kinematic", max_nodes=2, config=config
        )
    )
    return output


def test_no_file_and_an_empty_file_are_no_settings(tmp_path: Path) -> None:
    assert load_settings(None) == {}
    assert load_settings(written(tmp_path, "")) == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("behaviours: {}", "s.yaml:1: behaviours: unknown key; did you mean 'behaviors'?"),
        ("- 1\n- 2", "s.yaml:1: expected a mapping of keys, found a list"),
        ("behaviors: [", "s.yaml:2: not valid YAML"),
        ("!!python/object/apply:os.system ['true']", "s.yaml:1: tags"),
        ("behaviors: [1]", "s.yaml:1: behaviors: expected a mapping of keys, found a list"),
        ("behaviors:\n  wall-following: 3", "s.yaml:2: behaviors.wall-following: expected a mapping"),
        ("behaviors: {x: {speed: .nan}}", "s.yaml:1: behaviors.x.speed: expected a finite number"),
        ("behaviors: {}\nbehaviors: {}", "s.yaml:2: behaviors: this key appears twice"),
        ("mapping: 3", "s.yaml:1: mapping: expected a mapping"),
        ("mediator: [blend]", "s.yaml:1: mediator: give a mediator's name"),
        ("mediator: {reflex: 40}", "s.yaml:1: mediator: the key 'name' is missing"),
        ("noise: 3", "s.yaml:1: noise: expected a mapping"),
        ("noise: {encodr: 1}", "s.yaml:1: noise.encodr: unknown key; did you mean 'encoder"),
        ("noise: {preset: none, slip: much}", "s.yaml:1: noise.slip"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(SessionError) as raised:
        parse_settings(text, "s.yaml")
    assert str(raised.value).startswith(message)
    assert str(raised.value).isprintable()


def test_a_huge_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SessionError, match="larger than the limit"):
        load_settings(written(tmp_path, "#" * (LIMIT + 1)))


def test_a_mediator_has_a_name_and_may_have_options() -> None:
    assert mediator_of({}) == ("priority", {})
    assert mediator_of(parse_settings("mediator: blend", "s.yaml")) == ("blend", {})
    asked = parse_settings("mediator: {name: blend, reflex: 40}", "s.yaml")
    assert mediator_of(asked) == ("blend", {"reflex": 40})


def test_what_a_recording_holds_is_checked_as_a_file_is() -> None:
    settings = parse_settings("behaviors: {a: {b: 1.0e-05, c: 'é'}}\nnoise: {preset: none}", "s.yaml")
    assert recorded_settings(settings, "r") == settings
    with pytest.raises(SessionError, match="r: its settings:1: behaviors"):
        recorded_settings({"behaviors": [1]}, "r")


def test_a_behavior_s_setting_changes_the_drive(tmp_path: Path) -> None:
    slow = mapped(tmp_path, "behaviors: {wall-following: {speed: 200.0}}", "slow.tolman")
    usual = mapped(tmp_path, "", "usual.tolman")
    assert slow.read_bytes() != usual.read_bytes()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("behaviors: {wall-following: {spede: 200.0}}", "did you mean 'speed'"),
        ("behaviors: {wall-following: {speed: fast}}", "speed must be a finite number, not 'fast'"),
        ("behaviors: {wall-folowing: {speed: 1.0}}", "wall-folowing"),
    ],
)
def test_a_wrong_setting_is_refused_before_the_run(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises((ConfigError, PluginError), match=message):
        mapped(tmp_path, text)


def asked(text: str, profile: str = "default") -> Profile:
    return configured(find_profile(profile), parse_settings(text, "s.yaml"))


def test_the_section_mapping_sets_the_profile_s_mapper() -> None:
    assert asked("behaviors: {}") == find_profile("default")
    found = asked("mapping: {wall_distance: 1, come_back: false, closing: {confirmations: 3}}")
    assert found.mapping["wall_distance"] == 1.0
    assert found.mapping["come_back"] is False
    assert found.mapping["closing"] == ClosingConfig(confirmations=3)
    kept = asked("mapping: {closing: {gate: 0.05}}", "default without square rooms")
    assert kept.mapping["closing"] == ClosingConfig(square_limit=0.0, gate=0.05)
    thesis = asked("mapping: {closing: null, angle: 0.5}", "thesis")
    assert (thesis.closing, thesis.mapping) == (None, {"angle": 0.5})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "mapping: {wall_distanc: 1}",
            "mapping: unknown setting 'wall_distanc'; did you mean 'wall_distance'?",
        ),
        ("mapping: {side: left}", "mapping: unknown setting 'side'"),
        ("mapping: {come_back: 1}", "mapping.come_back: expected true or false, found 1"),
        ("mapping: {wall_distance: [1]}", "mapping.wall_distance: expected a number, found"),
        ("mapping: {closing: 3}", "mapping.closing: expected settings by name, found 3"),
        ("mapping: {closing: {gat: 3}}", "mapping.closing: unknown setting 'gat'; did you mean 'gate'?"),
        (
            "mapping: {closing: {confirmations: 1.5}}",
            "mapping.closing.confirmations: expected a whole number",
        ),
        ("mapping: {angle: 1}", "mapping: unknown setting 'angle'"),
    ],
)
def test_a_wrong_setting_of_the_mapper_is_refused(text: str, message: str) -> None:
    with pytest.raises(SessionError) as raised:
        asked(text)
    assert str(raised.value).startswith(message)


def test_a_setting_of_the_mapper_reaches_it(tmp_path: Path) -> None:
    config = written(tmp_path, "mapping: {most_rounds: 0.1}")
    request = MapRequest(
        world="env1", output=tmp_path / "m", global_only=True, engine="kinematic", config=config, max_nodes=4
    )
    assert "rounds without recognizing a corner" in map_world(request).reason
    with pytest.raises(SessionError, match="unknown setting 'sid'"):
        mapped(tmp_path, "mapping: {sid: left}", "third.tolman")
