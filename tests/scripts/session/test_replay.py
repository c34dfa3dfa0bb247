from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tolman.agent import Agent
from tolman.agent.errors import RecordingError
from tolman.agent.recording.reader import read_recording
from tolman.agent.recording.recorder import Recorder
from tolman.plugins.testing import ScriptedRobot, percept
from tolman.scripts.cli.program import execute
from tolman.scripts.session.replay import replay
from tolman.scripts.session.requests import GoRequest, MapRequest
from tolman.scripts.session.simulation import go_to, map_world

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> MapRequest:
    """A recorded mapping of env1: global, then a local map at the first of two nodes."""
    folder = tmp_path_factory.mktemp("run")
    request = MapRequest(
        world="env1",
        output=folder / "m.tolman",
        global_only=True,
        engine="kinematic",
        record=folder / "m.mcap",
    )
    assert map_world(request).loop_closed
    return request


def saved(run: MapRequest) -> Path:
    """The map file of a run."""
    assert run.output is not None
    return run.output


def test_a_recorded_mapping_replays_to_the_bit(run: MapRequest) -> None:
    assert run.record is not None
    report = replay(run.record)
    assert (report.kind, report.identical, report.difference) == ("map", True, None)
    assert report.ticks == len(read_recording(run.record).ticks)


def test_so_does_one_in_a_world_of_another_scale(run: MapRequest, tmp_path: Path) -> None:
    maze = tmp_path / "maze.txt"
    maze.write_text("+---+---+\n|S      |\n+---+---+\n")
    map_world(replace(run, world=str(maze), output=tmp_path / "m", record=tmp_path / "r", scale=1.5))
    assert replay(tmp_path / "r").identical


@pytest.mark.slow
def test_so_does_one_with_a_local_map(run: MapRequest, tmp_path: Path) -> None:
    request = replace(
        run, output=tmp_path / "m", record=tmp_path / "r", global_only=False, max_nodes=1, side="left"
    )
    map_world(request)
    assert replay(tmp_path / "r").identical
    assert any(tick.images for tick in read_recording(tmp_path / "r").ticks)


def test_so_does_one_that_was_resumed(run: MapRequest, tmp_path: Path) -> None:
    begun = replace(run, output=tmp_path / "m", record=None, max_nodes=3)
    assert map_world(begun).nodes == 3
    map_world(replace(begun, max_nodes=None, resume=True, record=tmp_path / "r"))
    assert (tmp_path / "m").read_bytes() == saved(run).read_bytes()
    (tmp_path / "m").unlink()
    report = replay(tmp_path / "r")
    assert (report.identical, report.difference) == (True, None)
    assert 0 < report.ticks < replay_length(run)


def replay_length(run: MapRequest) -> int:
    assert run.record is not None
    return len(read_recording(run.record).ticks)


def test_recording_changes_nothing(run: MapRequest, tmp_path: Path) -> None:
    map_world(replace(run, output=tmp_path / "m", record=None))
    assert (tmp_path / "m").read_bytes() == saved(run).read_bytes()


def test_another_configuration_is_noticed_at_its_first_effect(run: MapRequest, tmp_path: Path) -> None:
    settings = tmp_path / "settings.yaml"
    settings.write_text("behaviors: {wall-following: {speed: 200.0}}")
    request = replace(run, output=tmp_path / "m", record=tmp_path / "r", config=settings)
    map_world(request)
    assert replay(tmp_path / "r").identical  # the settings are in the recording
    header = dict(read_recording(tmp_path / "r").header)
    assert header["settings"] == {"behaviors": {"wall-following": {"speed": 200.0}}}


@pytest.mark.parametrize("start", [{}, {"lost": True}])
def test_a_recorded_trip_replays_to_the_bit(run: MapRequest, tmp_path: Path, start: dict[str, bool]) -> None:
    record = tmp_path / "r"
    request = GoRequest(map=saved(run), to=4, engine="kinematic", record=record, **start)  # type: ignore[arg-type]
    assert go_to(request).reached
    report = replay(record)
    assert (report.identical, report.difference) == (True, None)
    assert read_recording(record).ticks[-1].command is not None


def test_the_commands_say_the_same(run: MapRequest, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["replay", str(run.record), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["identical"] is True
    assert execute(["explain", str(run.record)]) == 0
    told = capsys.readouterr().out
    assert "control: nobody -> wall-following" in told
    assert "LoopClosed(" in told
    assert "wall-following drove" in told
    assert execute(["explain", str(run.record), "--control"]) == 0
    assert "LoopClosed(" not in capsys.readouterr().out


def test_a_file_that_is_no_recording_is_bad_input(
    run: MapRequest, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(["explain", str(run.output)]) == 2
    assert "not a recording: it is no MCAP file" in capsys.readouterr().err
    assert execute(["replay", "nowhere.mcap"]) == 2
    assert "nowhere.mcap: there is no such file" in capsys.readouterr().err


def test_a_recording_of_another_world_of_that_name_is_refused(
    run: MapRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tolman.world.arenas.catalog import find_world

    other = find_world("env2")
    monkeypatch.setattr("tolman.scripts.session.replay.find_world", lambda name, scale: other)
    assert run.record is not None
    with pytest.raises(RecordingError, match="recorded in another env1"):
        replay(run.record)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("request", None),
        ("request", []),
        ("request", {}),
        ("request", {"world": "env1", "scale": "much"}),
        ("request", {"world": "env1", "profile": 5, "global_only": []}),
        ("request", {"world": "env1", "plugins": 5}),
        ("request", {"world": "env1", "seed": {}}),
        ("kind", {}),
        ("kind", "mission"),
        ("settings", 5),
        ("geometry", "tank"),
        ("world_digest", 3),
        ("robots", "many"),
        ("seed", "x"),
    ],
)
def test_a_header_that_holds_anything_is_one_line(
    run: MapRequest, tmp_path: Path, name: str, value: object, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run.record is not None
    recording = read_recording(run.record)
    header = dict(recording.header) | {name: value}
    agent = Agent(ScriptedRobot([percept()]), [])
    recorder = Recorder(tmp_path / "r.mcap", agent, header)
    recorder.start()
    agent.tick()
    recorder.close()
    assert execute(["replay", str(tmp_path / "r.mcap")]) in (1, 2)
    told = capsys.readouterr()
    assert len((told.err + told.out).strip().splitlines()) == 1


PLUGIN = """
from enum import Enum
from tolman.agent import Behavior
class Loud(Behavior):
    '''Says that it was imported.'''
    class States(Enum):
        ON = "on"
    name = "loud"
    initial = States.ON
    def on(self, percept, context):
        return None
"""


def test_code_runs_only_where_it_is_as_it_was_recorded_or_trusted(
    run: MapRequest, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "plugins"
    folder.mkdir()
    (folder / "loud.py").write_text(PLUGIN)
    record = tmp_path / "r.mcap"
    map_world(replace(run, output=tmp_path / "m", record=record, max_nodes=2, plugins=(folder,)))
    assert execute(["replay", str(record)]) == 0
    assert f"replay runs the plugins in {folder} (here as recorded)" in capsys.readouterr().err
    (folder / "loud.py").write_text(PLUGIN + f"open({str(tmp_path / 'proof')!r}, 'w').close()")
    assert execute(["replay", str(record)]) == 2
    assert f"would run the plugins in {folder} (not here as recorded)" in capsys.readouterr().err
    assert not (tmp_path / "proof").exists()
    assert execute(["replay", str(record), "--trust"]) == 0
    assert (tmp_path / "proof").exists()


def test_a_recording_that_is_cut_off_is_replayed_as_far_as_it_goes(
    run: MapRequest, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run.record is not None
    data = run.record.read_bytes()
    (tmp_path / "r").write_bytes(data[: len(data) // 2])
    assert execute(["replay", str(tmp_path / "r")]) == 0
    assert "the recording is cut off here" in capsys.readouterr().out
