"""Reads a recording back: bounded, as nobody knows who made it, and as far as it goes if it was cut off."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, get_args, get_origin, get_type_hints

import numpy as np

from ...files.messages import printable, quoted
from ...files.reading import open_regular
from ...world.robot import Image, Percept, Pose, WheelCommand
from ..errors import RecordingError

VERSION = 1
MAGIC = b"\x89MCAP0\r\n"
MAX_UNPACKED = 64_000_000
"""Bytes that may be unpacked in any case, besides ten times the file's size; runs need five times."""
MAX_MESSAGE = 8_000_000
_FRAME = 9
"""Bytes before each record: its kind, and its length."""


@dataclass(slots=True)
class RecordedTick:
    """All that was kept of one tick, as it stands in the file.

    pose: where the agent believed to be, m, rad. states: of the active behaviors; belief: node ->
    probability; both None where they are as in the tick before.
    """

    percept: Percept
    images: list[Image] = field(default_factory=list)
    proposals: list[Any] = field(default_factory=list)
    command: WheelCommand | None = None
    driver: str | None = None
    events: list[str] = field(default_factory=list)
    truth: Pose | None = None
    pose: Pose | None = None
    states: dict[str, str] | None = None
    belief: dict[int, float] | None = None


@dataclass(slots=True)
class Recording:
    """A recorded run. ticks: of the first robot; others: of the world's further ones, in order.

    early: events from before the first tick, as text. complete: whether it was not cut off.
    """

    header: Mapping[str, Any]
    ticks: list[RecordedTick] = field(default_factory=list)
    attachments: dict[str, bytes] = field(default_factory=dict)
    early: list[str] = field(default_factory=list)
    others: tuple[list[RecordedTick], ...] = ()
    complete: bool = False


def read_recording(path: Path) -> Recording:
    """Reads a recording as far as it goes. Raises: RecordingError if it is none or damaged."""
    with open_regular(path, RecordingError) as file:
        try:
            return _Reader(file).read()
        except RecordingError as fault:
            raise RecordingError(f"{printable(str(path))}: {fault}") from fault
        except Exception as fault:  # the library raises whatever a damaged record leads it to
            problem = quoted(f"{type(fault).__name__}: {fault}")
            raise RecordingError(
                f"{printable(str(path))}: not a recording, or damaged ({problem})"
            ) from fault


def read_percepts(path: Path) -> list[Percept]:
    """The percepts of a recording, in order: what a scripted robot plays. Raises: RecordingError."""
    return [tick.percept for tick in read_recording(path).ticks]


class _Reader:
    """Goes through the records of a file once, in their order."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._left = file.seek(0, 2)
        self._may_unpack = MAX_UNPACKED + 10 * self._left
        file.seek(0)
        self._crc = 0
        self._topics: dict[int, str] = {}
        self._robots: dict[int, list[RecordedTick]] = {0: []}
        self._recording = Recording({})
        self._has_header = False

    def read(self) -> Recording:
        from mcap.opcode import Opcode

        if self._take(len(MAGIC)) != MAGIC:
            raise RecordingError("not a recording: it is no MCAP file")
        keep = {
            Opcode.METADATA: self._metadata,
            Opcode.ATTACHMENT: self._attachment,
            Opcode.CHUNK: self._chunk,
            Opcode.DATA_END: self._end,
        }
        for kind, content in self._records():
            if kind in keep:
                keep[Opcode(kind)](content)
            if self._recording.complete:
                break
        if not self._has_header:
            raise RecordingError("an MCAP file, but not a recording of tolman, or cut off before its header")
        self._recording.ticks = self._robots.pop(0)
        self._recording.others = tuple(self._robots[index] for index in sorted(self._robots))
        return self._recording

    def _take(self, length: int) -> bytes:
        data = self._file.read(length)
        self._left -= len(data)
        self._crc = zlib.crc32(data, self._crc)
        return data

    def _records(self) -> Iterator[tuple[int, bytes]]:
        """Kind and content of one record after the other, up to where the file is cut off."""
        while self._left >= _FRAME:
            self._before = self._crc
            frame = self._take(_FRAME)
            length = int.from_bytes(frame[1:], "little")
            if length > self._left:
                return
            yield frame[0], self._take(length)

    def _metadata(self, content: bytes) -> None:
        from mcap.records import Metadata

        record = Metadata.read(_stream(content))
        if record.name == "tolman":
            self._recording.header = _header(record.metadata)
            self._has_header = True

    def _attachment(self, content: bytes) -> None:
        from mcap.records import Attachment

        if zlib.crc32(content[:-4]) != int.from_bytes(content[-4:], "little"):
            raise RecordingError("damaged: an attachment has another checksum")
        record = Attachment.read(_stream(content))
        self._recording.attachments[record.name] = record.data

    def _end(self, content: bytes) -> None:
        known = int.from_bytes(content[:4], "little")
        if known not in (0, self._before):
            raise RecordingError("damaged: what it holds has another checksum")
        self._recording.complete = True

    def _chunk(self, content: bytes) -> None:
        from mcap.opcode import Opcode
        from mcap.records import Channel, Chunk, Message

        chunk = Chunk.read(_stream(content))
        data = self._unpacked(chunk.compression, chunk.data)
        if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
            raise RecordingError("damaged: a part of it has another checksum")
        at = 0
        while at + _FRAME <= len(data):
            kind, length = data[at], int.from_bytes(data[at + 1 : at + _FRAME], "little")
            inner = data[at + _FRAME : at + _FRAME + length]
            at += _FRAME + length
            if kind == Opcode.CHANNEL:
                channel = Channel.read(_stream(inner))
                self._topics[channel.id] = channel.topic
            elif kind == Opcode.MESSAGE:
                message = Message.read(_stream(inner), len(inner))
                self._message(self._topics[message.channel_id], message.data)

    def _unpacked(self, compression: str, packed: bytes) -> bytes:
        import zstandard

        if compression == "":
            return packed
        if compression != "zstd":
            raise RecordingError(f"packed by {quoted(compression)}; known: zstd")
        parts, stream = [], zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(packed)
        while part := stream.read(1 << 20):
            parts.append(part)
            self._may_unpack -= len(part)
            if self._may_unpack < 0:
                raise RecordingError("it unpacks to more than ten times its size: nothing tolman has written")
        return b"".join(parts)

    def _message(self, topic: str, data: bytes) -> None:
        if len(data) > MAX_MESSAGE:
            raise RecordingError(f"a message of {len(data)} bytes, more than the limit of {MAX_MESSAGE}")
        index = 0
        if topic.startswith("/robot"):
            number, _, topic = topic.removeprefix("/robot").partition("/")
            index, topic = int(number), f"/{topic}"
        ticks, value = self._robots.setdefault(index, []), json.loads(data)
        if topic == "/percept":
            ticks.append(RecordedTick(percept_of(value)))
        elif ticks and topic in _FILL:
            _FILL[topic](ticks[-1], value)
        elif index == 0 and not ticks:
            self._recording.early.append(data.decode())


def _stream(content: bytes) -> Any:
    from mcap.data_stream import ReadDataStream

    return ReadDataStream(BytesIO(content))


def _header(record: Mapping[str, str]) -> Mapping[str, Any]:
    if record.get("version") != str(VERSION):
        raise RecordingError(
            f"a recording of version {quoted(record.get('version'))}; this tolman reads {VERSION}"
        )
    try:
        header = json.loads(record.get("header", ""))
    except (ValueError, RecursionError) as fault:
        raise RecordingError(f"its header is no JSON ({fault})") from fault
    if not isinstance(header, dict):
        raise RecordingError(f"its header is {quoted(header)}, not an object")
    return header


def percept_of(value: Mapping[str, Any]) -> Percept:
    """A percept from its fields by name. Raises: RecordingError for others than are known here."""
    hints = _hints()
    for name, each in value.items():
        if name not in hints:
            raise RecordingError(f"percepts with {quoted(name)}; known: {', '.join(hints)}")
        if not _fits(each, hints[name]):
            raise RecordingError(f"a percept with {quoted(each)} for {name}")
    return Percept(**{name: _fixed(each) for name, each in value.items()})


@cache
def _hints() -> dict[str, Any]:
    return get_type_hints(Percept)


def _fits(value: Any, hint: Any) -> bool:
    """Whether JSON holds what a percept's field is: a number, a list of numbers, or such by name."""
    kinds = get_args(hint)
    if get_origin(hint) is tuple:
        counts = Ellipsis in kinds or (isinstance(value, list) and len(value) == len(kinds))
        return isinstance(value, list) and counts and all(_fits(each, kinds[0]) for each in value)
    if kinds:
        return isinstance(value, dict) and all(_fits(each, kinds[-1]) for each in value.values())
    return isinstance(value, int if hint is int else int | float) and not isinstance(value, bool)


def _fixed(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _fixed(each) for name, each in value.items()}
    return tuple(value) if isinstance(value, list) else value


def _image(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    pixels = np.frombuffer(base64.b64decode(value["data"]), dtype="<f4")
    tones = (3,) if value["encoding"] == "32FC3" else ()
    tick.images.append(pixels.reshape(value["height"], value["width"], *tones).astype(np.float32))


def _proposals(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    tick.proposals = [[*map(_plain, each)] for each in value["proposals"]]


def _plain(value: Any) -> Any:
    if not isinstance(value, str | int | float):
        raise RecordingError(f"a proposal holds texts and numbers, not {quoted(value)}")
    return value


def _command(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    tick.command = WheelCommand(float(value["left"]), float(value["right"]))
    tick.driver = None if value["driver"] is None else str(value["driver"])


def _event(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    if not isinstance(value["event"], dict):
        raise RecordingError(f"an event is {quoted(value['event'])}, not an object")
    tick.events.append(json.dumps(value["event"], separators=(",", ":"), sort_keys=True))


def _truth(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    tick.truth = Pose(float(value["x"]), float(value["y"]), float(value["heading"]))


def _agent(tick: RecordedTick, value: Mapping[str, Any]) -> None:
    x, y, heading = value["pose"]
    tick.pose = Pose(float(x), float(y), float(heading))
    if "states" in value:
        tick.states = {str(name): str(state) for name, state in value["states"].items()}
    if "belief" in value:
        tick.belief = {int(node): float(weight) for node, weight in value["belief"].items()}


_FILL: dict[str, Callable[[RecordedTick, Mapping[str, Any]], None]] = {
    "/image": _image,
    "/proposals": _proposals,
    "/command": _command,
    "/event": _event,
    "/truth": _truth,
    "/agent": _agent,
}
