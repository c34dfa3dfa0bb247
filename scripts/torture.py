"""Torments map files: `python -m tolman.scripts.torture kills|mutations|full|all`. Exit 1 on a fault.

POSIX only.

kills: a process that maps is killed (SIGKILL) at random moments; what it had reported as saved must be there.
mutations: damaged and crafted files; each must be refused with one line or load what it truly held.
full: the disk runs full; one clear error, and the last good state stays.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import resource
import signal
import sqlite3
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..maps import HybridMap, LocalMap, MapError, MapFile, MapMeta, read_truth
from ..maps.map_file import read_state
from ..maps.records import pack_local_map, row_hash
from ..maps.schema import COLUMNS

MEMORY_LIMIT_MB = 500
PATIENCE = 30
"""Seconds after which one file counts as a hang."""


def local_map(rng: np.random.Generator, views: int = 8) -> LocalMap:
    """A local map of made-up samples; the generator decides all of it."""
    places = rng.uniform(-0.1, 0.1, (30, 2))
    panoramas = rng.uniform(0.0, 1.0, (views, 4, 16, 16))
    return LocalMap.build(places, places[:views], panoramas, entry_panorama=panoramas[0])


def map_made_up_world(
    path: Path, nodes: int, seed: int, saved: Callable[[int], None] = lambda _: None, resume: bool = False
) -> None:
    """Maps a ring of made-up nodes into a file, or goes on with one; calls saved(node) after each commit."""
    file = (
        MapFile.resume(path)
        if resume
        else MapFile.create(path, MapMeta(world="made-up", seed=seed), force=True)
    )
    rng = np.random.default_rng(seed)
    if isinstance(file.state, dict):
        rng.bit_generator.state = file.state["rng"]
    hybrid = file.map
    saved(-1)
    for node in range(len(hybrid.graph), nodes):
        hybrid.add_node(corner="concave", turn=float(rng.normal()), local_map=local_map(rng))
        if node:
            hybrid.add_arc(node - 1, node, "right", float(rng.uniform(0.2, 0.6)), 1e-4)
        file.append(
            hybrid, node, state={"rng": rng.bit_generator.state}, truth={"pose": [0.5, float(node), 0.0]}
        )
        saved(node)
    if not hybrid.graph.has_edge(nodes - 1, 0, "right"):
        arc = hybrid.add_arc(nodes - 1, 0, "right", float(rng.uniform(0.2, 0.6)), 1e-4)
        hybrid.meta = MapMeta(world="made-up", seed=seed, loop_closed=True)
        file.update(hybrid, arcs=[(arc.start, arc.end, "right"), (arc.end, arc.start, "left")])
    file.seal()


def content_digest(path: Path) -> str:
    """A hash of everything a map file holds, read through the public functions. Raises: MapError."""
    hybrid = HybridMap.load(path)
    whole: list[Any] = [hybrid.meta.to_json()]
    for node in hybrid.nodes():
        data = dict(hybrid.graph.nodes[node])
        local: LocalMap | None = data.pop("local_map")
        packed = None if local is None else pack_local_map(local.content)
        whole.append([node, data, None if packed is None else [packed[0], packed[1].hex()]])
    for arc in hybrid.arcs():
        whole.append(repr(arc))
    truth = read_truth(path)
    whole.append([sorted(truth.nodes.items()), truth.run, repr(read_state(path))])
    return hashlib.blake2b(json.dumps(whole, sort_keys=True).encode()).hexdigest()


# -- kills


def kills(count: int, seed: int, folder: Path, resumed: int = 50, nodes: int = 4) -> Counter[str]:
    """Kills a mapping process `count` times; resumes the first `resumed` unfinished ones to the end."""
    rng = np.random.default_rng(seed)
    whole = folder / "whole.tolman"
    started = time.monotonic()
    map_made_up_world(whole, nodes, 0)
    usual = time.monotonic() - started
    expected, wanted = whole.read_bytes(), HybridMap.load(whole)
    result: Counter[str] = Counter()
    for index in range(count):
        path = folder / f"killed-{index}.tolman"
        reported = _map_and_kill(path, nodes, float(rng.uniform(0.0, 1.3 * usual)))
        _judge(path, reported, wanted, result)
        if result["resumed"] < resumed and reported >= 0 and path.exists():
            map_made_up_world(path, nodes, 0, resume=True)
            result["resumed"] += 1
            result["resumed to other bytes"] += path.read_bytes() != expected
        for leftover in folder.glob(f"killed-{index}.tolman*"):
            leftover.unlink()
    return result


def _map_and_kill(path: Path, nodes: int, after: float) -> int:
    """Runs the mapping in a child and kills it after some seconds: the last node it reported, -2 for none."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            map_made_up_world(path, nodes, 0, lambda node: void(os.write(writing, bytes([node + 1]))))
        finally:
            os._exit(0)
    os.close(writing)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    told = b""
    while part := os.read(reading, 4096):
        told += part
    os.close(reading)
    return told[-1] - 1 if told else -2


def void(_: object) -> None:
    """Takes a value and gives none."""


def _judge(path: Path, reported: int, wanted: HybridMap, result: Counter[str]) -> None:
    result["killed"] += 1
    if reported < -1:
        result["killed before the file was reported"] += 1
        return
    try:
        found = HybridMap.load(path)
    except MapError as error:
        print(f"does not open: {error}", file=sys.stderr)
        result["does not open"] += 1
        return
    for node in range(reported + 1):
        same = node in found.graph and _same_node(found, wanted, node)
        result["nodes lost"] += not same
    result["nodes reported"] += reported + 1


def _same_node(found: HybridMap, wanted: HybridMap, node: int) -> bool:
    one, other = found.local_map(node), wanted.local_map(node)
    if one is None or other is None:
        return False
    same = pack_local_map(one.content) == pack_local_map(other.content)
    return same and found.graph.nodes[node]["turn"] == wanted.graph.nodes[node]["turn"]


# -- mutations


def mutations(count: int, seed: int, folder: Path) -> Counter[str]:
    """Reads `count` damaged and crafted files in child processes, and counts how each ended."""
    source = folder / "source.tolman"
    map_made_up_world(source, 4, 1)
    truth = content_digest(source)
    result: Counter[str] = Counter()
    done = 0
    while done < count:
        size = min(250, count - done)
        result += _batch(source, truth, range(done, done + size), seed, folder)
        done += size
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024
    result["peak memory of a reader, MB"] = peak
    result["over the memory limit"] = int(peak > MEMORY_LIMIT_MB)
    return result


def _batch(source: Path, truth: str, numbers: range, seed: int, folder: Path) -> Counter[str]:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        with os.fdopen(writing, "w") as out:
            for number in numbers:
                signal.alarm(PATIENCE)
                print(_one(source, truth, number, seed, folder), file=out, flush=True)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as lines:
        result = Counter(line.strip() for line in lines)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        result["hangs" if os.WTERMSIG(status) == signal.SIGALRM else "crashes"] += 1
    return result


def _one(source: Path, truth: str, number: int, seed: int, folder: Path) -> str:
    rng = np.random.default_rng([seed, number])
    path = folder / "mutant.tolman"
    name = MUTATIONS[number % len(MUTATIONS)]
    crafted = mutate(source, path, name, rng)
    try:
        digest = content_digest(path)
    except MapError as error:
        return "refused" if "\n" not in str(error) else f"more than one line: {name}"
    except Exception as error:
        return f"another exception: {name}: {type(error).__name__}: {error}"
    if digest == truth:
        return "loaded what it held"
    return f"crafted and loaded: {name}" if crafted else f"silently wrong: {name}"


BYTES = ("truncate", "extend", "flip", "flip few", "overwrite", "zero", "swap pages", "header", "double page")
ROWS = ("swap values", "set value", "delete row", "copy tensor", "swap tensors", "flip tensor", "digest")
CRAFTED = (
    "huge tensor",
    "huge lattice",
    "deep json",
    "infinite",
    "dangling",
    "view",
    "check",
    "trigger",
    "blob",
)
MUTATIONS = BYTES * 3 + ROWS * 2 + CRAFTED


def mutate(source: Path, path: Path, name: str, rng: np.random.Generator) -> bool:
    """Writes a damaged copy; whether it was crafted with checksums that hold."""
    if name in BYTES:
        path.write_bytes(_bytes_mutant(source.read_bytes(), name, rng))
        return False
    path.write_bytes(source.read_bytes())
    connection = sqlite3.connect(path, isolation_level=None)
    try:
        connection.execute("PRAGMA writable_schema = ON")
        if name in ROWS:
            _row_mutant(connection, name, rng)
        else:
            _crafted_mutant(connection, name, rng)
    finally:
        connection.close()
    return name in CRAFTED


def _bytes_mutant(data: bytes, name: str, rng: np.random.Generator) -> bytes:
    mutant, size, page = bytearray(data), len(data), 16384
    place, length = int(rng.integers(size)), int(rng.integers(1, 5000))
    if name == "truncate":
        return bytes(mutant[:place])
    if name == "extend":
        return bytes(mutant) + rng.bytes(length)
    if name == "flip":
        mutant[place] ^= 1 << int(rng.integers(8))
    elif name == "flip few":
        for _ in range(int(rng.integers(2, 40))):
            mutant[int(rng.integers(size))] ^= 1 << int(rng.integers(8))
    elif name == "overwrite":
        mutant[place : place + length] = rng.bytes(min(length, size - place))
    elif name == "zero":
        mutant[place : place + length] = bytes(min(length, size - place))
    elif name == "header":
        mutant[int(rng.integers(16, 100))] = int(rng.integers(256))
    else:
        one, other = (int(n) * page for n in rng.integers(size // page, size=2))
        first, second = mutant[one : one + page], mutant[other : other + page]
        mutant[other : other + page] = first
        if name == "swap pages":
            mutant[one : one + page] = second
    return bytes(mutant)


def _row_mutant(connection: sqlite3.Connection, name: str, rng: np.random.Generator) -> None:
    table = ("node", "arc", "meta", "truth", "session")[int(rng.integers(5))]
    columns = COLUMNS[table][1:]
    column = columns[int(rng.integers(len(columns)))]
    number = int(rng.integers(4))
    if name == "swap values":
        table, column = ("node", "arc")[number % 2], ("turn", "distance")[number % 2]
        key = "id" if table == "node" else "start"
        connection.execute(f"UPDATE {table} SET {column} = {column} + 0.25 WHERE {key} % 2 = 0")
    elif name == "set value":
        values = (0, 7, -1.5, "x", b"\x00" * 8, None, 2**62)
        value = values[int(rng.integers(len(values)))]
        try:
            connection.execute(f"UPDATE {table} SET {column} = ?", (value,))
        except sqlite3.Error:
            connection.execute("UPDATE node SET turn = turn + 1 WHERE id = 0")
    elif name == "delete row":
        connection.execute(f"DELETE FROM {table} WHERE hash = (SELECT max(hash) FROM {table})")
    elif name == "copy tensor":
        connection.execute(
            "UPDATE tensors SET data = (SELECT data FROM tensors WHERE node = 0) WHERE node = 1"
        )
    elif name == "swap tensors":
        connection.execute("UPDATE tensors SET node = 100 WHERE node = 0")
        connection.execute("UPDATE tensors SET node = 0 WHERE node = 1")
    elif name == "flip tensor":
        data = bytearray(
            connection.execute("SELECT data FROM tensors WHERE node = ?", (number,)).fetchone()[0]
        )
        data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        connection.execute("UPDATE tensors SET data = ? WHERE node = ?", (bytes(data), number))
    else:
        connection.execute("UPDATE digest SET total = total + 1 WHERE name = 'node'")


def _crafted_mutant(connection: sqlite3.Connection, name: str, rng: np.random.Generator) -> None:
    """Hostile content under checksums that hold."""
    if name in ("huge tensor", "huge lattice"):
        manifest = json.loads(connection.execute("SELECT local_map FROM node WHERE id = 0").fetchone()[0])
        if name == "huge tensor":
            manifest["tensors"][0][2] = [[2**40, 2], [2**62, 2**62], [-1, -2], [10**30, 1]][
                int(rng.integers(4))
            ]
        else:
            manifest["metric"] = [[10**9, 10**9, "hexagonal"], [5, -5, "hexagonal"], [25, 1e300, "x"]][
                int(rng.integers(3))
            ]
        _reset(connection, "node", "local_map", json.dumps(manifest))
    elif name == "deep json":
        _reset(connection, "node", "notes", "[" * 2000 + "]" * 2000)
    elif name == "infinite":
        _reset(connection, "node", "turn", float("inf"))
    elif name == "dangling":
        _reset(connection, "arc", '"end"', 99)
    elif name == "blob":
        connection.execute("UPDATE tensors SET data = zeroblob(100000000) WHERE node = 0")
    else:
        sql = {
            "view": "CREATE VIEW meta AS WITH RECURSIVE t(key) AS (SELECT 1 UNION ALL SELECT key FROM t)"
            " SELECT key, key AS value, key AS hash FROM t",
            "check": "CREATE TABLE meta (key TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL,"
            " hash INTEGER NOT NULL, CHECK (length(hex(zeroblob(900000000))) > 0)) STRICT, WITHOUT ROWID",
            "trigger": "CREATE TRIGGER evil AFTER INSERT ON meta BEGIN DELETE FROM node; END",
        }[name]
        if name == "trigger":
            connection.execute(sql)
        else:
            kind = "view" if name == "view" else "table"
            root = "0" if name == "view" else "rootpage"
            connection.execute(
                f"UPDATE sqlite_master SET type = '{kind}', rootpage = {root}, sql = ? WHERE name = 'meta'",
                (sql,),
            )


def _reset(connection: sqlite3.Connection, table: str, column: str, value: Any) -> None:
    """Changes one value of the first row, and mends the row's checksum and the digest."""
    columns = COLUMNS[table]
    row = list(connection.execute(f"SELECT {', '.join(columns)}, hash FROM {table} LIMIT 1").fetchone())
    old = row.pop()
    row[columns.index(column)] = value
    new = row_hash(table, tuple(row))
    connection.execute(f"UPDATE {table} SET {column} = ?, hash = ? WHERE hash = ?", (value, new, old))
    total = connection.execute("SELECT total FROM digest WHERE name = ?", (table,)).fetchone()[0] + new - old
    connection.execute("UPDATE digest SET total = ? WHERE name = ?", ((total + 2**63) % 2**64 - 2**63, table))


# -- full disk


def full(folder: Path, sizes: range = range(150_000, 1_200_000, 70_000)) -> Counter[str]:
    """Maps while no file may grow beyond a size: one clear error, everything reported still there."""
    result: Counter[str] = Counter()
    for size in sizes:
        path = folder / f"full-{size}.tolman"
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            told = [-1]
            try:
                map_made_up_world(path, 12, 0, lambda node, told=told: void(told.append(node)))  # type: ignore[misc]
                text = "finished"
            except MapError as error:
                text = f"clear: {error}" if "\n" not in str(error) else "unclear"
            except BaseException as error:
                text = f"unclear: {error!r}"
            os.write(writing, f"{max(told)} {text}".encode())
            os._exit(0)
        os.close(writing)
        with os.fdopen(reading) as lines:
            number, _, text = lines.read().partition(" ")
        os.waitpid(child, 0)
        result["runs"] += 1
        result["ended with a clear error"] += text.startswith("clear")
        if text.startswith("unclear"):
            print(text, file=sys.stderr)
            result["unclear errors"] += 1
        if int(number) >= 0:
            found = HybridMap.load(path)
            result["nodes lost"] += sum(node not in found.graph for node in range(int(number) + 1))
            map_made_up_world(path, 12, 0, resume=True)
            result["resumed when there was room"] += 1
    return result


FAULTS = (
    "does not open",
    "nodes lost",
    "resumed to other bytes",
    "hangs",
    "crashes",
    "over the memory limit",
)


def faults(result: Counter[str]) -> list[str]:
    """The entries of a result that must be zero but are not."""
    prefixes = ("silently wrong", "crafted and loaded", "another exception", "more than one line", "unclear")
    return [name for name, times in result.items() if times and (name in FAULTS or name.startswith(prefixes))]


def main() -> int:
    """Runs the campaigns named on the command line and prints what happened."""
    parser = argparse.ArgumentParser(prog="torture", description=__doc__)
    parser.add_argument("campaign", choices=["kills", "mutations", "full", "all"])
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--mutations", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        campaigns: dict[str, Callable[[], Counter[str]]] = {
            "kills": lambda: kills(options.kills, options.seed, Path(name)),
            "mutations": lambda: mutations(options.mutations, options.seed, Path(name)),
            "full": lambda: full(Path(name)),
        }
        for campaign, run in campaigns.items():
            if options.campaign in (campaign, "all"):
                result = run()
                for text, times in sorted(result.items()):
                    print(f"{campaign}: {text}: {times}")
                wrong += faults(result)
    if wrong:
        print(f"faults: {', '.join(wrong)}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
