"""Whole commands in processes of their own: what they promise, and what they answer to bad input."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.e2e

MAP_KEYS = {
    *("nodes", "arcs", "local_maps", "loop_closed", "loop_correct", "reason", "loop_distance_m"),
    *("true_loop_distance_m", "position_error_m", "path_integration_error_m", "collisions", "sim_time_s"),
    *("wall_time_s", "real_time_factor", "seed", "profile", "noise", "world", "version"),
}
GO_KEYS = {
    *("reached", "lost", "reason", "path", "legs", "position_error_m", "heading_error_deg", "distance_m"),
    *("sim_time_s", "wall_time_s", "seed"),
}
QUICK = ("map", "env1", "--global-only", "--max-nodes", "3")


@dataclass(frozen=True)
class Outcome:
    """What a command printed and its exit status."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        values = json.loads(self.out)
        assert isinstance(values, dict)
        return values


def tolman(*arguments: object) -> Outcome:
    command = [sys.executable, "-m", "tolman.scripts.cli", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    return Outcome(done.returncode, done.stdout, done.stderr)


def refused(outcome: Outcome, *words: str) -> None:
    """Asserts exit status 2 and one line of error with each of the words in it."""
    errors = [line for line in outcome.err.splitlines() if line.startswith("tolman: error: ")]
    assert (outcome.status, outcome.out, len(errors)) == (2, "", 1), outcome
    assert "Traceback" not in outcome.err
    for word in words:
        assert word in errors[0]


@pytest.fixture(scope="module")
def mapped(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """A small map that every test here may read, and what the command said."""
    path = tmp_path_factory.mktemp("mapped") / "small.tolman"
    outcome = tolman(*QUICK, "-o", path, "--json")
    assert outcome.status == 0, outcome
    return path, outcome


def test_worlds_are_listed_for_people_and_for_programs() -> None:
    names = tolman("worlds").out.split("\n")
    listed = tolman("worlds", "--json").json["worlds"]
    assert {"env1", "env2", "env3"} <= {entry["name"] for entry in listed}
    assert all(any(line.startswith(entry["name"]) for line in names) for entry in listed)


def test_map_reports_what_the_contract_names(mapped: tuple[Path, Outcome]) -> None:
    report = mapped[1].json
    assert set(report) >= MAP_KEYS
    assert (report["nodes"], report["local_maps"], report["reason"]) == (3, 0, "max nodes")
    assert (report["seed"], report["noise"], report["profile"]) == (0, "thesis", "default")
    assert report["world"] == "env1"


def test_the_same_command_gives_the_same_bytes(mapped: tuple[Path, Outcome], tmp_path: Path) -> None:
    again = tmp_path / "again.tolman"
    assert tolman(*QUICK, "-o", again).status == 0
    assert again.read_bytes() == mapped[0].read_bytes()
    another = tmp_path / "another.tolman"
    assert tolman(*QUICK, "-o", another, "--seed", 1).status == 0
    assert another.read_bytes() != mapped[0].read_bytes()


def test_a_recorded_mapping_is_replayed_to_the_bit(mapped: tuple[Path, Outcome], tmp_path: Path) -> None:
    run, path = tmp_path / "run.mcap", tmp_path / "m.tolman"
    assert tolman(*QUICK, "-o", path, "--record", run).status == 0
    assert path.read_bytes() == mapped[0].read_bytes(), "recording changes nothing"
    assert tolman("replay", run).status == 0
    refused(tolman(*QUICK, "-o", path, "--force", "--record", tmp_path / "missing" / "run"), "no folder")


def test_info_tells_of_the_map_and_leaves_it_alone(mapped: tuple[Path, Outcome]) -> None:
    before = mapped[0].read_bytes()
    values = tolman("info", mapped[0], "--json").json
    assert values["nodes"] == len(values["node_ids"]) == len(values["node_list"]) == 3
    assert values["arcs"] == len(values["arc_list"]) == mapped[1].json["arcs"]
    assert tolman("info", mapped[0]).status == 0
    assert mapped[0].read_bytes() == before


def test_a_map_is_drawn_the_same_every_time(mapped: tuple[Path, Outcome], tmp_path: Path) -> None:
    for name in ("a.svg", "b.svg"):
        assert tolman("plot", mapped[0], "-o", tmp_path / name).status == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_going_reports_what_the_contract_names_and_alters_nothing(mapped: tuple[Path, Outcome]) -> None:
    before = mapped[0].read_bytes()
    trip = tolman("go", mapped[0], "--to", 1, "--from", 0, "--json")
    assert trip.status == (0 if trip.json["reached"] else 1)
    assert set(trip.json) >= GO_KEYS
    assert all({"from", "to", "side", "distance_m"} <= set(leg) for leg in trip.json["legs"])
    assert mapped[0].read_bytes() == before


def test_an_unknown_world_is_refused_with_the_nearest(tmp_path: Path) -> None:
    refused(tolman("map", "env11", "-o", tmp_path / "m.tolman"), "env11", "env1")
    assert list(tmp_path.iterdir()) == []


def test_a_world_file_with_a_fault_is_refused_with_its_line(tmp_path: Path) -> None:
    world = tmp_path / "w.yaml"
    world.write_text("tolman-world: 1\nroom: {size: [1.0, 1.0]}\nboxs: []\n")
    refused(tolman("map", world, "-o", tmp_path / "m.tolman"), "w.yaml", "3", "boxes")


def test_an_existing_map_is_not_overwritten(mapped: tuple[Path, Outcome]) -> None:
    before = mapped[0].read_bytes()
    refused(tolman("map", "env1", "-o", mapped[0]), "exists", "--force", "--resume")
    refused(tolman("map", "nowhere", "-o", mapped[0], "--force"), "nowhere")
    assert mapped[0].read_bytes() == before


@pytest.mark.parametrize("start", ["0.36,0.2,0", "0.01,0.5,0", "1e9,0,0"])
def test_a_start_in_a_wall_or_far_away_is_refused(tmp_path: Path, start: str) -> None:
    refused(tolman("map", "env1", "-o", tmp_path / "m.tolman", "--start", start))
    assert list(tmp_path.iterdir()) == []


def test_an_output_that_cannot_be_written_is_refused_before_the_run(tmp_path: Path) -> None:
    refused(tolman("map", "env1", "-o", tmp_path / "missing" / "m.tolman"), "no folder")
    refused(tolman("map", "env1", "-o", "/proc/m.tolman"), "/proc")
    refused(tolman("map", "env1", "-o", tmp_path / "m", "--figure", "/proc/m.png"), "/proc")


def test_an_interrupted_mapping_can_be_read_and_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    broken, whole = tmp_path / "broken.tolman", tmp_path / "whole.tolman"
    command = ("map", "env1", "--global-only", "--noise", "encoder")
    full = [sys.executable, "-m", "tolman.scripts.cli", *command, "-o", str(broken)]
    with subprocess.Popen(full, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as process:
        assert process.stderr is not None
        process.stderr.readline()  # its first progress, or nothing if it was faster than that
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode in (0, 130)
    assert tolman("info", broken, "--json").json["nodes"] > 0
    if process.returncode == 130:
        assert tolman(*command, "-o", broken, "--resume").status == 0
    assert tolman(*command, "-o", whole).status == 0
    assert broken.read_bytes() == whole.read_bytes()


def test_resuming_needs_a_map(tmp_path: Path) -> None:
    refused(tolman("map", "env1", "-o", tmp_path / "m.tolman", "--resume"), "no such map")


def readers(path: Path, folder: Path) -> list[Outcome]:
    """What every command that reads a map says of the file."""
    return [
        tolman("go", path, "--to", "0"),
        tolman("info", path),
        tolman("plot", path, "-o", folder / "m.png"),
    ]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "text": lambda data: b"this is not a map\n" * 99,
    "cut": lambda data: data[: len(data) // 2],
    "altered": lambda data: data.replace(b"concave", b"concavf", 1),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_map_is_refused(mapped: tuple[Path, Outcome], tmp_path: Path, damage: str) -> None:
    path = tmp_path / "damaged.tolman"
    path.write_bytes(DAMAGES[damage](mapped[0].read_bytes()))
    for outcome in readers(path, tmp_path):
        refused(outcome, "damaged.tolman")


def test_validate_says_what_is_wrong_and_saves_the_rest(mapped: tuple[Path, Outcome], tmp_path: Path) -> None:
    assert tolman("validate", mapped[0], "--json").json["problems"] == []
    damaged, saved = tmp_path / "damaged.tolman", tmp_path / "saved.tolman"
    damaged.write_bytes(DAMAGES["altered"](mapped[0].read_bytes()))
    found = tolman("validate", damaged)
    assert found.status == 1
    assert "checksum" in found.out
    assert tolman("validate", damaged, "--recover", saved, "--json").json["savable_nodes"] == 2
    assert tolman("info", saved, "--json").json["nodes"] == 2
    refused(tolman("validate", damaged, "--recover", saved), "exists", "--force")


@pytest.mark.parametrize("form", ["graphml", "json", "geojson", "ros"])
def test_a_map_is_exported_once(mapped: tuple[Path, Outcome], tmp_path: Path, form: str) -> None:
    out = tmp_path / ("m.yaml" if form == "ros" else f"m.{form}")
    outcome = tolman("export", mapped[0], "--format", form, "-o", out)
    if form == "ros":  # drawn from local maps, and this map has none
        refused(outcome, "local map")
        return
    assert outcome.status == 0
    assert out.stat().st_size > 100
    refused(tolman("export", mapped[0], "--format", form, "-o", out), "exists", "--force")


def test_maps_of_one_world_are_matched_and_merged(tmp_path: Path) -> None:
    one, other, merged = (tmp_path / f"{name}.tolman" for name in ("one", "other", "merged"))
    assert tolman("map", "env1", "--global-only", "-o", one).status == 0
    assert tolman("map", "env1", "--global-only", "-o", other, "--side", "left", "--seed", 3).status == 0
    matched = tolman("diff", one, other, "--json").json["matched"]
    assert sorted(pair[0] for pair in matched) == list(range(10))
    assert tolman("merge", one, other, "-o", merged).status == 0
    assert tolman("info", merged, "--json").json["nodes"] == 10
    refused(tolman("merge", one, other, "-o", merged), "exists", "--force")


def test_a_missing_map_is_refused(tmp_path: Path) -> None:
    for outcome in readers(tmp_path / "nowhere.tolman", tmp_path):
        refused(outcome, "nowhere.tolman")


def test_an_unknown_node_is_refused_with_the_known_ones(mapped: tuple[Path, Outcome]) -> None:
    refused(tolman("go", mapped[0], "--to", "99"), "99", "known: 0, 1, 2")
    refused(tolman("go", mapped[0], "--to", "kitchen"), "kitchen", "known")
    refused(tolman("go", mapped[0], "--to", "1", "--from", "98"), "98")


def test_a_map_in_the_wrong_world_is_refused(mapped: tuple[Path, Outcome]) -> None:
    refused(tolman("go", mapped[0], "--to", "1", "--world", "env2"), "env2", "env1")


def test_settings_that_are_wrong_are_refused(tmp_path: Path) -> None:
    config = tmp_path / "settings.yaml"
    config.write_text("no_such_behavior: {speed: 1}\n")
    refused(tolman("map", "env1", "-o", tmp_path / "m.tolman", "--config", config), "no_such_behavior")
    refused(tolman("map", "env1", "-o", tmp_path / "m.tolman", "--config", tmp_path / "nowhere"), "nowhere")
    refused(tolman("map", "env1", "-o", tmp_path / "m.tolman", "--plugins", tmp_path / "nowhere"), "nowhere")
