"""Files of older format versions: brought up to date by a chain of pure steps, refused everywhere else.

Version 1 is the only one there has been, so its golden file is migrated to made-up versions 2 and 3: the one
adds a column and a key of the meta, the other changes what a local map's manifest says.
"""

from __future__ import annotations

import json
import shutil
import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest
from tolman.maps import HybridMap, migrate, recover, validate
from tolman.maps.errors import MapFileDamagedError, MapFileExistsError, MapFileVersionError
from tolman.maps.storage import migration as migrating
from tolman.maps.storage.migration import STEPS, Formats, Rows, Step
from tolman.maps.storage.reader import open_map, read_rows
from tolman.maps.storage.schema import CURRENT, SCHEMAS, VERSION_1

DATA = Path(__file__).parent / "data"
GOLDEN = DATA / "version1.tolman"

VERSION_2 = replace(
    VERSION_1,
    version=2,
    tables={
        **VERSION_1.tables,
        "node": VERSION_1.tables["node"].replace(" notes TEXT", " floor INTEGER NOT NULL, notes TEXT"),
    },
)
VERSION_3 = replace(VERSION_2, version=3)


def add_floor(rows: Rows) -> Rows:
    nodes = [(*row[:5], 0, *row[5:]) for row in rows["node"]]
    return {**rows, "node": nodes, "meta": [*rows["meta"], ("floors", "1")]}


def say_unit(manifest: str, data: bytes) -> tuple[str, bytes]:
    return json.dumps({**json.loads(manifest), "unit": "m"}), data


FORMATS = Formats(
    schemas={1: VERSION_1, 2: VERSION_2, 3: VERSION_3},
    steps={1: Step(rows=add_floor), 2: Step(local_map=say_unit)},
    current=VERSION_3,
)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copy(GOLDEN, tmp_path / "old.tolman"))


def test_there_is_a_schema_a_step_and_a_golden_file_of_every_version() -> None:
    assert sorted(SCHEMAS) == list(range(1, CURRENT.version + 1))
    assert sorted(STEPS) == list(range(1, CURRENT.version))
    assert all((DATA / f"version{version}.tolman").is_file() for version in SCHEMAS)


def test_a_file_two_versions_old_goes_through_both_steps(old: Path) -> None:
    new, before = old.with_name("new.tolman"), old.read_bytes()
    done = migrate(old, new, formats=FORMATS)
    golden = HybridMap.load(GOLDEN)
    meta, graph = golden.meta, golden.graph
    assert (done.version, done.nodes, done.arcs) == (1, len(graph), graph.number_of_edges())
    connection = open_map(new, VERSION_3)
    try:
        nodes = read_rows(connection, "node", VERSION_3)
        assert [row[5] for row in nodes] == [0] * len(graph)
        assert [row[3] for row in nodes] == [graph.nodes[node]["turn"] for node in sorted(graph)]
        assert {json.loads(row[7])["unit"] for row in nodes} == {"m"}
        assert ("floors", "1") in read_rows(connection, "meta", VERSION_3)
        assert ("side", json.dumps(meta.side)) in read_rows(connection, "meta", VERSION_3)
        kept = [row[0] for row in connection.execute("SELECT data FROM tensors ORDER BY node")]
    finally:
        connection.close()
    source = sqlite3.connect(GOLDEN)
    assert kept == [row[0] for row in source.execute("SELECT data FROM tensors ORDER BY node")]
    source.close()
    assert old.read_bytes() == before


def test_migrating_twice_gives_the_same_bytes_and_only_once_without_force(old: Path) -> None:
    one, other = old.with_name("1.tolman"), old.with_name("2.tolman")
    migrate(old, one, formats=FORMATS)
    migrate(old, other, formats=FORMATS)
    assert one.read_bytes() == other.read_bytes()
    with pytest.raises(MapFileExistsError):
        migrate(old, one, formats=FORMATS)


def test_a_file_of_the_current_version_or_of_none_is_not_migrated(old: Path) -> None:
    with pytest.raises(MapFileVersionError, match="older version"):
        migrate(old, old.with_name("new.tolman"))
    old.write_bytes(b"no map")
    with pytest.raises(MapFileVersionError):
        migrate(old, old.with_name("new.tolman"), formats=FORMATS)


@pytest.mark.parametrize("table", ["node", "tensors"])
def test_a_damaged_old_file_is_refused_and_nothing_is_written(old: Path, table: str) -> None:
    connection = sqlite3.connect(old)
    if table == "node":
        connection.execute("UPDATE node SET turn = turn + 1 WHERE id = 1")
    else:
        connection.execute("UPDATE tensors SET data = zeroblob(length(data)) WHERE node = 1")
    connection.commit()
    connection.close()
    with pytest.raises(MapFileDamagedError, match=r"old\.tolman: "):
        migrate(old, old.with_name("new.tolman"), formats=FORMATS)
    assert not old.with_name("new.tolman").exists()


def test_validate_and_recover_know_old_files(old: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(migrating, "FORMATS", FORMATS)
    new, nodes = old.with_name("new.tolman"), len(HybridMap.load(GOLDEN).graph)
    about = validate(old)
    assert "format version 1" in about.problems[0]
    assert about.savable_nodes == nodes
    assert recover(old, new) == about
    open_map(new, VERSION_3).close()
    old.write_bytes(old.read_bytes()[:60000])
    assert validate(old).problems[-1] == "nothing can be saved"


def test_reading_another_version_says_what_would_do(old: Path) -> None:
    new = old.with_name("new.tolman")
    migrate(old, new, formats=FORMATS)
    with pytest.raises(MapFileVersionError, match="format version 3; this program reads version 1: a newer"):
        HybridMap.load(new)
    with pytest.raises(MapFileVersionError, match="brings it up to date"):
        open_map(old, VERSION_3)
