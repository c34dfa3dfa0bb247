"""What a request's settings do: the file of settings, noise, behaviors."""

from __future__ import annotations

from pathlib import Path

import pytest
from tolman.agent.errors import ConfigError
from tolman.plugins.errors import PluginError
from tolman.scripts.session import map_world
from tolman.scripts.session.assembly import CONFIG_LIMIT, load_settings
from tolman.scripts.session.requests import MapRequest, SessionError


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
        ("behaviours: {}", "unknown section 'behaviours'; known: behaviors, mapping, mediator, noise"),
        ("- 1\n- 2", "expected sections such as `behaviors:`, found a list"),
        ("behaviors: [", "not YAML"),
        ("!!python/object/apply:os.system ['true']", "not YAML"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(SessionError) as raised:
        load_settings(written(tmp_path, text))
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_huge_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SessionError, match="too large for settings"):
        load_settings(written(tmp_path, "#" * (CONFIG_LIMIT + 1)))


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
