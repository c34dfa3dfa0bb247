from __future__ import annotations

import os
import shutil
import sqlite3
import tempfile
from pathlib import Path

import pytest
from tolman.maps import HybridMap, MapFile, read_truth, recover, validate
from tolman.maps.errors import (
    MapError,
    MapFileDamagedError,
    MapFileError,
    MapFileExistsError,
    MapFileLockedError,
)
from tolman.maps.storage.map_file import read_extensions, read_state

from tools.torture.commands import commands
from tools.torture.disks import full, readonly
from tools.torture.faults import faults
from tools.torture.kills import kills
from tools.torture.maps import content_digest, map_made_up_world
from tools.torture.mutants import MUTATIONS
from tools.torture.mutations import mutations
from tools.torture.pairs import pairs

GOLDEN = Path(__file__).parent / "data" / "version1.tolman"
GOLDEN_DIGEST = (Path(__file__).parent / "data" / "version1.digest").read_text().strip()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("made") / "made.tolman"
    map_made_up_world(path, 3, 1)
    return path


@pytest.fixture
def sealed(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(made, tmp_path / "m.tolman"))


def test_the_golden_file_of_version_1_still_reads_as_it_did() -> None:
    assert validate(GOLDEN).valid
    assert content_digest(GOLDEN) == GOLDEN_DIGEST


def test_equal_runs_give_equal_bytes_and_leave_one_file(sealed: Path) -> None:
    again = sealed.with_name("again.tolman")
    map_made_up_world(again, 3, 1)
    assert again.read_bytes() == sealed.read_bytes()
    assert sorted(os.listdir(sealed.parent)) == ["again.tolman", "m.tolman"]


def test_a_map_saved_and_loaded_is_the_same_to_the_byte(sealed: Path) -> None:
    first, second = sealed.with_name("1.tolman"), sealed.with_name("2.tolman")
    HybridMap.load(sealed).save(first)
    HybridMap.load(first).save(second)
    assert first.read_bytes() == second.read_bytes()
    assert list(HybridMap.load(first).arcs()) == list(HybridMap.load(sealed).arcs())


def test_resuming_a_sealed_file_without_a_change_leaves_its_bytes(sealed: Path) -> None:
    before = sealed.read_bytes()
    MapFile.resume(sealed).seal()
    assert sealed.read_bytes() == before


def test_a_run_cut_off_anywhere_and_resumed_ends_with_the_same_bytes(sealed: Path) -> None:
    class CutError(Exception):
        pass

    for last in range(-1, 3):
        path = sealed.with_name(f"cut{last}.tolman")

        def cut(node: int, last: int = last) -> None:
            if node == last:
                raise CutError

        with pytest.raises(CutError):
            map_made_up_world(path, 3, 1, cut)
        sealed.with_name(path.name + "-lock").unlink(missing_ok=True)  # as after a kill
        map_made_up_world(path, 3, 1, resume=True)
        assert path.read_bytes() == sealed.read_bytes()


def test_a_viewer_reads_beside_the_writer_and_sees_what_was_committed(tmp_path: Path) -> None:
    hybrid = HybridMap()
    with MapFile.create(tmp_path / "m.tolman") as file:
        file.append(hybrid, hybrid.add_node(), state=b"\x00\x01")
        viewer = HybridMap.load(file.path)
        assert viewer.nodes() == [0]
        hybrid.add_node()
        assert HybridMap.load(file.path).nodes() == [0]
        file.append(hybrid, 1)
        assert HybridMap.load(file.path).nodes() == [0, 1]
    assert read_state(tmp_path / "m.tolman") == b"\x00\x01"


def test_one_writer_at_a_time(tmp_path: Path) -> None:
    with MapFile.create(tmp_path / "m.tolman"), pytest.raises(MapFileLockedError):
        MapFile.resume(tmp_path / "m.tolman")
    MapFile.resume(tmp_path / "m.tolman").seal()


def test_an_existing_file_is_kept_without_force(sealed: Path) -> None:
    before = sealed.read_bytes()
    with pytest.raises(MapFileExistsError, match="exists already"):
        MapFile.create(sealed)
    with pytest.raises(MapFileExistsError):
        HybridMap().save(sealed)
    assert sealed.read_bytes() == before
    HybridMap().save(sealed, force=True)
    assert HybridMap.load(sealed).nodes() == []


def test_truth_and_extensions_are_kept_apart_from_the_map(sealed: Path) -> None:
    file = MapFile.resume(sealed)
    file.put_extension("someone", "color", {"door": "red"})
    file.update(file.map, truth={-1: {"world": "w"}})
    file.seal()
    assert read_extensions(sealed) == {("someone", "color"): {"door": "red"}}
    assert read_truth(sealed).nodes[2] == {"pose": [0.5, 2.0, 0.0]}
    assert read_truth(sealed).run == {"world": "w"}
    copied = sealed.with_name("copy.tolman")
    HybridMap.load(sealed).save(copied)
    assert read_truth(copied).nodes == {}


def test_what_an_update_no_longer_finds_in_the_map_is_deleted(sealed: Path) -> None:
    file = MapFile.resume(sealed)
    arcs = list(file.map.graph.edges(keys=True))
    file.map.remove_node(2)
    file.update(file.map, [2], arcs)
    file.seal()
    assert HybridMap.load(sealed).nodes() == [0, 1]
    assert validate(sealed).valid


def test_a_blocked_edge_is_remembered(sealed: Path) -> None:
    file = MapFile.resume(sealed)
    local = file.map.local_map(1)
    assert local is not None
    i, j = local.edges[0].tolist()
    local.block(i, j)
    file.update(file.map, [1])
    file.seal()
    found = HybridMap.load(sealed).local_map(1)
    assert found is not None
    assert found.blocked == {(i, j)}


@pytest.mark.parametrize(
    "bad", [{"notes": {"a": (1, 2)}}, {"notes": {"a": "x" * 5000}}, {"turn": float("nan")}]
)
def test_what_cannot_be_stored_is_refused_and_nothing_of_it_is_kept(
    tmp_path: Path, bad: dict[str, object]
) -> None:
    hybrid = HybridMap()
    with MapFile.create(tmp_path / "m.tolman") as file:
        file.append(hybrid, hybrid.add_node())
        node = hybrid.add_node()
        hybrid.graph.nodes[node].update(bad)
        with pytest.raises(MapError):
            file.append(hybrid, node)
    assert HybridMap.load(tmp_path / "m.tolman").nodes() == [0]


def test_a_file_copied_without_its_log_is_refused(tmp_path: Path) -> None:
    hybrid = HybridMap()
    file = MapFile.create(tmp_path / "m.tolman")
    file.append(hybrid, hybrid.add_node())
    alone = Path(shutil.copy(file.path, tmp_path / "alone.tolman"))
    file.seal()
    with pytest.raises(MapFileError, match="never sealed"):
        HybridMap.load(alone)


@pytest.mark.parametrize("content", [b"", b"hello", b"SQLite format 3\0" + bytes(84), bytes(5000)])
def test_what_is_no_map_is_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "m.tolman"
    path.write_bytes(content)
    with pytest.raises(MapFileError) as caught:
        HybridMap.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_folders_and_missing_files_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing.tolman"):
        with pytest.raises(MapFileError):
            HybridMap.load(path)
        with pytest.raises(MapFileError):
            MapFile.resume(path)
    with pytest.raises(MapFileError, match="there is no folder"):
        MapFile.create(tmp_path / "no" / "m.tolman")


def test_a_newer_version_is_refused_by_number(sealed: Path) -> None:
    data = bytearray(sealed.read_bytes())
    data[60:64] = (9).to_bytes(4, "big")
    sealed.write_bytes(bytes(data))
    with pytest.raises(MapFileError, match="format version 9; this program reads version 1"):
        HybridMap.load(sealed)


def test_a_damaged_local_map_is_noticed_when_read_and_by_validate(sealed: Path) -> None:
    connection = sqlite3.connect(sealed)
    data = bytearray(connection.execute("SELECT data FROM tensors WHERE node = 1").fetchone()[0])
    data[1000] ^= 1
    connection.execute("UPDATE tensors SET data = ? WHERE node = 1", (bytes(data),))
    connection.commit()
    connection.close()
    hybrid = HybridMap.load(sealed)
    damaged, sound = hybrid.local_map(1), hybrid.local_map(0)
    assert damaged is not None
    assert sound is not None
    assert sound.metric.units == 25
    with pytest.raises(MapFileDamagedError, match="node 1"):
        damaged.metric  # noqa: B018 - reading raises
    about = validate(sealed)
    assert any("node 1" in problem for problem in about.problems)
    assert (about.savable_nodes, about.savable_local_maps) == (3, 2)


def test_recover_writes_what_can_be_saved(sealed: Path) -> None:
    connection = sqlite3.connect(sealed)
    connection.execute("UPDATE node SET turn = turn + 1 WHERE id = 2")
    connection.commit()
    connection.close()
    with pytest.raises(MapFileDamagedError, match="checksum"):
        HybridMap.load(sealed)
    output = sealed.with_name("saved.tolman")
    about = recover(sealed, output)
    assert not about.valid
    saved = HybridMap.load(output)
    assert saved.nodes() == [0, 1]
    assert {(arc.start, arc.end) for arc in saved.arcs()} == {(0, 1), (1, 0)}
    assert validate(output).valid
    assert read_truth(output).nodes[1] == {"pose": [0.5, 1.0, 0.0]}


def test_recover_of_a_truncated_file_saves_its_graph(tmp_path: Path) -> None:
    path = tmp_path / "m.tolman"
    map_made_up_world(path, 8, 2)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    with pytest.raises(MapFileDamagedError, match="cut off"):
        HybridMap.load(path)
    about = validate(path)
    assert about.problems
    if about.savable_nodes:
        recover(path, tmp_path / "saved.tolman")
        assert len(HybridMap.load(tmp_path / "saved.tolman").graph) == about.savable_nodes


def test_recovering_onto_the_file_itself_is_refused(sealed: Path) -> None:
    with pytest.raises(MapFileError, match="name another"):
        recover(sealed, sealed, force=True)


def test_a_read_only_folder_gives_clear_errors_and_can_be_read() -> None:
    folder = Path(tempfile.mkdtemp())  # pytest's own folders are closed to other users
    try:
        result = readonly(folder)
    finally:
        shutil.rmtree(folder)
    assert result["ended with a clear error"] == result["attempts"] == 6
    assert faults(result) == []


def test_kills_lose_nothing_that_was_reported(tmp_path: Path) -> None:
    result = kills(8, 0, tmp_path, resumed=2, nodes=2)
    assert result["killed"] == 8
    assert faults(result) == []


def test_mutations_are_refused_or_load_what_they_held(tmp_path: Path) -> None:
    result = mutations(len(MUTATIONS), 7, tmp_path)
    assert faults(result) == []
    assert result["refused"] + result["loaded what it held"] == len(MUTATIONS)


def test_crafted_files_are_refused_or_well_formed_through_all_commands(tmp_path: Path) -> None:
    result = commands(40, 3, tmp_path, plotted=2)
    assert faults(result) == []
    assert result["refused"] >= 15
    assert result["loaded, and well-formed"] >= 1


def test_a_full_disk_gives_a_clear_error_and_can_be_resumed(tmp_path: Path) -> None:
    result = full(tmp_path, range(300_000, 500_000, 190_000))
    assert result["ended with a clear error"] == result["runs"] == 2
    assert faults(result) == []


def test_pairs_of_maps_are_judged_by_where_their_nodes_truly_are(tmp_path: Path) -> None:
    result = pairs(tmp_path, count=1, seed=11, local_maps=0, engine="kinematic")
    assert faults(result) == []
    assert result["nodes matched rightly"] == result["nodes that both maps have"] >= 20
    assert result["of those refused"] == result["pairs of different worlds"] == 2
    assert result["merged to one closed boundary"] == 1
