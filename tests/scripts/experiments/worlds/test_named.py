"""The worlds of experiments: named changes of the built-in ones, and files copied into the work folder."""

import math
from pathlib import Path

import pytest
from tolman.scripts.experiments.worlds.named import (
    CHANGES,
    ODD_ANGLE,
    experiment_world,
    import_world,
)
from tolman.scripts.experiments.worlds.names import noise_scale, split
from tolman.world import built_in_world
from tolman.world.errors import WorldError
from tolman.world.geometry import Plan

MAP = """image: map.pgm
resolution: 0.05
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.2
"""


def write_room(folder: Path) -> Path:
    """A ROS map: a room of 24 x 16 cells inside one cell of wall."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [[0] * 26, *([0, *[254] * 24, 0] for _ in range(16)), [0] * 26]
    (folder / "map.pgm").write_bytes(b"P5\n26 18\n255\n" + bytes(value for row in rows for value in row))
    path = folder / "map.yaml"
    path.write_text(MAP, encoding="utf-8")
    return path


def width(world: object) -> float:
    x0, _, x1, _ = Plan(world.shapes).bounds  # type: ignore[attr-defined]
    return x1 - x0


@pytest.mark.parametrize("change", sorted(CHANGES))
def test_every_change_leaves_a_world_with_both_starts(change: str, tmp_path: Path) -> None:
    spec = experiment_world(f"env2 {change}", tmp_path)
    assert {start.name for start in spec.starts} >= {"right", "left"}
    same = spec.digest == built_in_world("env2").digest
    assert same is (change == "noisier")


def test_only_the_noisier_world_has_more_noise() -> None:
    assert noise_scale("env1 noisier") == 1.5
    assert {noise_scale(f"env1 {change}") for change in CHANGES if change != "noisier"} == {1.0}
    assert split("map.yaml x0.4") == ("map.yaml", "x0.4")


def test_the_odd_angle_is_near_no_right_one() -> None:
    turns = [math.degrees(ODD_ANGLE) * k % 90.0 for k in range(1, 5)]
    assert min(min(turn, 90.0 - turn) for turn in turns) > 10.0


def test_an_unknown_change_or_world_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="unknown change 'painted'"):
        experiment_world("env1 painted", tmp_path)
    with pytest.raises(WorldError):
        experiment_world("nowhere.wbt", tmp_path)


def test_an_imported_map_is_copied_with_its_bitmap_and_opened_at_its_scale(tmp_path: Path) -> None:
    source = write_room(tmp_path / "elsewhere")
    work = tmp_path / "work"
    plain, small = import_world(str(source), work), import_world(f"{source}:0.5", work)
    assert (plain, small) == ("map.yaml", "map.yaml x0.5")
    for file in (source, source.with_name("map.pgm")):
        file.unlink()
    whole, half = experiment_world(plain, work), experiment_world(small, work)
    assert width(half) == pytest.approx(0.5 * width(whole))


@pytest.mark.parametrize("source", ["nowhere.wbt", "README.md", "map.yaml:large"])
def test_what_is_no_world_file_is_refused(source: str, tmp_path: Path) -> None:
    write_room(tmp_path)
    (tmp_path / "README.md").write_text("no world")
    with pytest.raises(WorldError):
        import_world(str(tmp_path / source), tmp_path / "work")
