"""The bytes between an agent and a plugin in a subprocess: fixed binary ticks, JSON for the rest, no pickle.

Every message is a length (4 bytes, little-endian), a kind (1 byte) and a body. What the plugin's side sends
is never trusted: lengths are limited, numbers are checked by the agent as any proposal is.
"""

from __future__ import annotations

import json
import os
import select
import struct
import time
from enum import IntEnum

from ...agent.behavior import Context
from ...world.robot import Percept, Pose
from ..errors import IsolationError

LIMIT = 1 << 20
"""Bytes of a message at most."""
SEND_TIMEOUT = 1.0
"""Seconds that the other end may leave a full pipe unread."""
_HEAD = struct.Struct("<IB")
_TICK = struct.Struct("<q9d?B")
_PROPOSAL = struct.Struct("<?ddd?H")


class Kind(IntEnum):
    """What a message is. Those below 10 come from the agent, the others from the plugin."""

    START = 1
    STOP = 2
    TICK = 3
    IMAGE = 4
    EVENT = 5
    ARBITRATE = 6
    HELLO = 10
    DONE = 11
    PROPOSAL = 12
    LOOK = 13
    PUBLISH = 14
    FAULT = 15
    RESULT = 16
    SUBSCRIBE = 17
    DECISION = 18


class Channel:
    """One end of the two pipes."""

    def __init__(self, read: int, write: int) -> None:
        """File descriptors; the channel closes them."""
        self._read, self._write = read, write
        self._buffer = bytearray()
        self._poll, self._room = select.poll(), select.poll()
        self._poll.register(read, select.POLLIN)
        self._room.register(write, select.POLLOUT)
        os.set_blocking(write, False)

    def send(self, kind: Kind, body: bytes = b"") -> None:
        """Sends one message. Raises: IsolationError if the other end is gone or does not read it."""
        data = memoryview(_HEAD.pack(len(body), kind) + body)
        try:
            while data:
                try:
                    data = data[os.write(self._write, data) :]
                except BlockingIOError:
                    if not self._room.poll(1e3 * SEND_TIMEOUT):
                        raise IsolationError("the subprocess does not read what it is sent") from None
        except OSError as fault:
            raise IsolationError("the subprocess is gone") from fault

    def receive(self, deadline: float | None = None) -> tuple[int, bytes]:
        """The next message. Raises: IsolationError if the other end is gone, too late or sends too much.

        deadline: of `time.monotonic`, s; None waits for ever.
        """
        size, kind = _HEAD.unpack(self._exactly(_HEAD.size, deadline))
        if size > LIMIT:
            raise IsolationError(f"the subprocess sent a message of {size} bytes, more than {LIMIT}")
        return kind, self._exactly(size, deadline)

    def _exactly(self, size: int, deadline: float | None) -> bytes:
        buffer = self._buffer
        while len(buffer) < size:
            if deadline is not None:
                left = deadline - time.monotonic()
                if left <= 0.0 or not self._poll.poll(1e3 * left):
                    raise IsolationError("the subprocess did not answer in time")
            chunk = os.read(self._read, 1 << 16)
            if not chunk:
                raise IsolationError("the subprocess has ended")
            buffer += chunk
        data = bytes(buffer[:size])
        del buffer[:size]
        return data

    def close(self) -> None:
        """Closes both pipes."""
        for descriptor in (self._read, self._write):
            os.close(descriptor)


def pack_tick(percept: Percept, context: Context) -> bytes:
    """A percept and what the context has of this tick."""
    pose = context.pose
    head = _TICK.pack(
        percept.tick,
        percept.time,
        pose.x,
        pose.y,
        pose.heading,
        context.distance,
        context.turn,
        *percept.accelerometer,
        context.in_control,
        len(percept.infrared),
    )
    values = struct.pack(f"<{len(percept.infrared) + 2}d", *percept.infrared, *percept.encoders)
    return head + values + (json.dumps(dict(percept.readings)).encode() if percept.readings else b"")


def unpack_tick(body: bytes, context: Context) -> Percept:
    """The percept; the context takes the rest."""
    tick, now, x, y, heading, distance, turn, ax, ay, az, in_control, count = _TICK.unpack_from(body)
    values = struct.unpack_from(f"<{count + 2}d", body, _TICK.size)
    context.time, context.pose, context.in_control = now, Pose(x, y, heading), in_control
    context.distance, context.turn = distance, turn
    rest = body[_TICK.size + 8 * (count + 2) :]
    readings = {name: tuple(each) for name, each in json.loads(rest).items()} if rest else {}
    return Percept(tick, now, values[:count], (values[count], values[count + 1]), (ax, ay, az), readings)


def pack_proposal(
    command: tuple[float, float] | None, activation: float, reason: str, state: int, finished: bool
) -> bytes:
    """What `propose` returned (command None: nothing), the state's index, and whether it has finished."""
    left, right = command or (0.0, 0.0)
    text = reason.encode()[:500]
    flags = _PROPOSAL.pack(command is not None, left, right, activation, finished, state)
    return flags + text


def unpack_proposal(body: bytes) -> tuple[tuple[float, float] | None, float, str, int, bool]:
    """The inverse of `pack_proposal`. Raises: IsolationError for what is none."""
    try:
        wants, left, right, activation, finished, state = _PROPOSAL.unpack_from(body)
    except struct.error as fault:
        raise IsolationError("the subprocess sent no proposal") from fault
    reason = body[_PROPOSAL.size :].decode(errors="replace")
    return ((left, right) if wants else None), activation, reason, state, finished
