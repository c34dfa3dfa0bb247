from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import cast

import pytest
from tolman.agent.errors import MissionError
from tolman.agent.missions.dry_run import dry_run
from tolman.agent.missions.mission import Mission
from tolman.agent.recording.explain import timeline
from tolman.agent.recording.reader import read_recording
from tolman.agent.recording.replay import ReplayEnded, ReplayWorld
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.storage.map_file import read_truth
from tolman.scripts.cli.program import execute
from tolman.scripts.session.mission import MissionJob, MissionReport
from tolman.scripts.session.replay import replay
from tolman.scripts.session.requests import MissionRequest
from tolman.scripts.session.simulation import run_mission
from tolman.scripts.session.site import sites_of
from tolman.scripts.session.stage import Stage
from tolman.world import World
from tolman.world.robot import Pose

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""

EXAMPLES = Path(__file__).parents[3] / "scripts" / "missions"


@pytest.fixture(scope="module")
def mapped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map of env1, made by a mission."""
    folder = tmp_path_factory.mktemp("mapped")
    mission = folder / "map.yaml"
    mission.write_text(f"steps: [explore, save: {folder}/env1.tolman]")
    assert request(mission, world="env1").status == "done"
    return folder / "env1.tolman"


def request(mission: Path, **options: object) -> MissionReport:
    settings = {"engine": "kinematic", "global_only": True, "noise": "encoder"} | options
    return run_mission(MissionRequest(mission=mission, **settings))  # type: ignore[arg-type]


def write(folder: Path, text: str, name: str = "mission.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_map_and_return(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report = request(EXAMPLES / "map_and_return.yaml", world="env1")
    assert (report.status, report.reason) == ("done", "")
    assert HybridMap.load(tmp_path / "returned.tolman").meta.current_node == 0


def test_a_patrol_visits_every_node_of_a_saved_map_twice(mapped: Path) -> None:
    report = request(EXAMPLES / "patrol.py", map=mapped)
    assert report.status == "done"
    assert report.steps_done == 2 * len(HybridMap.load(mapped).nodes()) + 5


def test_a_mission_with_a_failing_step_does_what_it_says(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [on_failure: {do: {go_to: 77}, otherwise: {go_to: 3}}]")
    assert request(path, map=mapped).status == "done"
    path = write(tmp_path, f"steps: [go_to: 77, save: {tmp_path}/never.tolman]")
    report = request(path, map=mapped)
    assert report.status == "failed"
    assert "77" in report.reason
    assert not (tmp_path / "never.tolman").exists()


def test_a_mission_without_a_map_cannot_go_anywhere(tmp_path: Path) -> None:
    report = request(write(tmp_path, "steps: [go_to: 1]"), world="env1")
    assert "there is no map yet: explore, or load one" in report.reason


@pytest.mark.parametrize("seconds", [0.1, 1, 4, 9, 14, 21])
def test_after_a_cancelled_trip_the_robot_finds_its_way_from_where_it_is(
    mapped: Path, tmp_path: Path, seconds: float
) -> None:
    path = write(tmp_path, f"steps: [race: [go_to: 5, wait: {seconds}], go_to: 5, save: {tmp_path}/m.tolman]")
    report = request(path, map=mapped, record=tmp_path / "run")
    assert (report.status, report.reason, report.collisions) == ("done", "", 0)
    truth = read_truth(tmp_path / "m.tolman")
    there = Pose(*truth.run["pose"])
    assert there.distance_to(Pose(*truth.nodes[5]["pose"])) < 0.02
    assert replay(tmp_path / "run").identical


def test_so_it_does_after_something_else_has_driven_it_away(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [go_to: 3, race: [do: wander, wait: 8], go_to: 3]")
    report = request(path, map=mapped, record=tmp_path / "run")
    assert (report.status, report.reason) == ("done", "")
    assert any("Localized(" in line for line in timeline(read_recording(tmp_path / "run")))


def test_a_mission_cancelled_on_the_way_goes_on_after_a_restart(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [race: [go_to: 5, wait: 6], say: stopped, wait: 1, go_to: 5]")
    cut = MissionRequest(
        mission=path, map=mapped, engine="kinematic", noise="encoder", journal=tmp_path / "j", max_time=6.5
    )
    assert run_mission(cut).status == "cancelled"
    report = run_mission(replace(cut, max_time=None, resume=True))
    assert (report.status, report.reason) == ("done", "")


def test_the_published_method_stops_too_but_cannot_find_out_where_it_is(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [race: [go_to: 5, wait: 5], wait: 2, go_to: 5]")
    report = request(path, map=mapped, profile="thesis", record=tmp_path / "run")
    assert "its profile has no way to find out" in report.reason
    still = [tick.driver for tick in read_recording(tmp_path / "run").ticks if 5.1 < tick.percept.time < 6.9]
    assert set(still) == {None}


def test_who_maps_cannot_go_anywhere_until_that_has_ended(tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [explore: {wait: false}, wait: 1, go_to: 0]")
    assert "the mapping is still under way" in request(path, world="env1").reason
    path = write(tmp_path, "steps: [explore: {wait: false}, until: LoopClosed, go_to: 3]")
    assert request(path, world="env1").status == "done"


def test_time_that_is_over_cancels_a_mission(mapped: Path, tmp_path: Path) -> None:
    report = request(write(tmp_path, "steps: [wait: 100]"), map=mapped, max_time=2.0)
    assert (report.status, report.reason) == ("cancelled", "not done within 2 s")
    assert report.sim_time_s == pytest.approx(2.0, abs=0.1)


def test_a_mission_goes_on_after_a_restart_where_it_was(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [go_to: 3, go_to: 7, go_to: 0]")
    whole = request(path, map=mapped)
    journal = tmp_path / "journal"
    cut = MissionRequest(
        mission=path,
        map=mapped,
        engine="kinematic",
        noise="encoder",
        journal=journal,
        max_time=whole.sim_time_s * 0.6,
    )
    assert run_mission(cut).status == "cancelled"
    done = [json.loads(line) for line in journal.read_text().splitlines()[1:]]
    assert 1 <= len(done) < 3
    report = run_mission(replace(cut, max_time=None, resume=True, record=tmp_path / "run"))
    assert (report.status, report.steps_done) == ("done", 3)
    journal.unlink()
    assert replay(tmp_path / "run").identical
    assert report.sim_time_s < 1.7 * whole.sim_time_s


def test_a_mission_needs_a_world(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="say in which world the mission runs"):
        request(write(tmp_path, "steps: [nodes]"))


def test_a_recorded_mission_replays_to_the_bit_and_writes_nothing(mapped: Path, tmp_path: Path) -> None:
    path = write(tmp_path, f"steps: [go_to: 2, look, save: {tmp_path}/there.tolman, go_to: 0]")
    recording = tmp_path / "run.mcap"
    assert request(path, map=mapped, record=recording).status == "done"
    (tmp_path / "there.tolman").unlink()
    path.unlink()
    report = replay(recording)
    assert (report.identical, report.difference) == (True, None)
    assert not (tmp_path / "there.tolman").exists()


def test_two_robots_share_one_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    record = tmp_path / "run"
    report = request(EXAMPLES / "two_robots.py", world=str(EXAMPLES / "two_robots_world.yaml"), record=record)
    assert (report.status, report.reason) == ("done", "")
    assert len(HybridMap.load(tmp_path / "shared.tolman").nodes()) == 10
    recording = read_recording(record)
    assert [len(ticks) for ticks in recording.others] == [len(recording.ticks)]
    assert replay(record).identical
    assert "robot 1:" in list(timeline(recording))


def test_a_difference_is_found_on_any_of_the_robots(tmp_path: Path) -> None:
    path = write(tmp_path, "steps: [as: {robot: 1, steps: [race: [do: wander, wait: 1]]}]")
    request(path, world=str(EXAMPLES / "two_robots_world.yaml"), record=tmp_path / "run")
    recording = read_recording(tmp_path / "run")
    recording.others[0][9].driver = "somebody"
    world = ReplayWorld(recording)
    asked = MissionRequest(mission=path, engine="kinematic", noise="encoder", global_only=True)
    stage = Stage(cast(World, world), asked, {})
    job = MissionJob(stage, sites_of(stage, asked), Mission.load(path))
    for robot, agent in zip(world.robots, stage.agents, strict=True):
        robot.watch(agent)
    with pytest.raises(ReplayEnded):
        job.drive()
    assert world.difference is not None
    assert (world.difference.tick, world.difference.recorded) == (9, "somebody")


@pytest.mark.parametrize(("world", "status"), [("env1-textured", "done"), ("env1", "failed")])
def test_a_textured_wall_is_found_where_there_is_one(
    world: str, status: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = request(EXAMPLES / "find_textured_wall.py", world=world)
    assert report.status == status, report.reason
    assert (tmp_path / "textured.tolman").exists()


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_every_example_can_be_shown_without_doing_anything(path: Path) -> None:
    plan = dry_run(Mission.load(path))
    assert plan.problems == []
    assert plan.lines


CRASHING = '''
import os
from enum import Enum
from tolman.agent import Behavior, Proposal
from tolman.world.robot import WheelCommand

class Crashing(Behavior):
    """Ends its process in its tenth tick."""
    class States(Enum):
        """ON: the only one."""
        ON = "on"
    name = "crashing"
    priority = 12
    initial = States.ON
    def on_reset(self):
        self.ticks = 0
    def on(self, percept, context):
        self.ticks += 1
        if self.ticks == 10:
            os._exit(3)
        return Proposal(WheelCommand(50.0, 50.0), reason="soon over")
'''


def test_an_isolated_plugin_that_ends_its_process_ends_no_mission(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tolman.plugins.isolation.proxy.ANSWER_TIMEOUT", 60.0)
    monkeypatch.setattr("tolman.plugins.isolation.process.START_TIMEOUT", 120.0)
    (tmp_path / "plugins").mkdir()
    write(tmp_path / "plugins", CRASHING, "crashing.py")
    path = write(tmp_path, "steps: [on_failure: {do: {do: crashing}, otherwise: {wait: 3}}]")
    record = tmp_path / "run.mcap"
    report = request(path, world="env1", plugins=(tmp_path / "plugins",), isolate=True, record=record)
    assert report.status == "done"
    lines = list(timeline(read_recording(record)))
    faults = [line for line in lines if "crashing STOPPED in state ON" in line]
    assert len(faults) == 3
    assert "exit status 3" in faults[0]
    assert faults[-1].endswith("disabled")
    assert replay(record).identical


def test_what_a_mission_says_and_returns_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = """
from tolman.agent.missions.steps import Race, Say, Wait

def mission():
    yield Say("red \\x1b[31m")
    return (yield Race(Wait(0.1), Wait(9)))
"""
    path = write(tmp_path, text, "m.py")
    common = ["run", str(path), "--world", "env1"]
    assert execute([*common, "--json"]) == 0
    out, err = capsys.readouterr()
    report = json.loads(out)
    assert (report["said"], report["result"]) == (["red \x1b[31m"], [0, None])
    assert "red \\x1b[31m" in err
    assert execute(common) == 0
    assert "result: [0, None]" in capsys.readouterr().out


def test_a_mission_that_prints_does_not_spoil_the_json_of_its_dry_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, "print('loud')\ndef mission():\n    yield\n", "m.py")
    assert execute(["run", str(path), "--dry-run", "--json"]) == 1
    problems = json.loads(capsys.readouterr().out)["problems"]
    assert problems == ["a mission yields steps such as GoTo(5), not None"]


@pytest.mark.parametrize(
    "state", ["", "{", "[]", "{}", '{"world": 5, "sites": []}', '{"world": {}, "sites": [{}]}']
)
def test_a_damaged_state_beside_a_journal_is_one_line(tmp_path: Path, state: str) -> None:
    path = write(tmp_path, "steps: [wait: 0.1, wait: 0.1]")
    request(path, world="env1", journal=tmp_path / "j")
    (tmp_path / "j.state").write_text(state)
    with pytest.raises(MissionError, match=r"j\.state: damaged .*; begin again without --resume"):
        request(path, world="env1", journal=tmp_path / "j", resume=True)
