"""The packets of the e-puck2's Wi-Fi protocol, as bytes: 21-byte commands, sensors, images.

Sources: GCtronic's firmware of radio and robot, and three clients, which agree on every offset; see
docs/robots.md. Integers and floats are little-endian, pixels have their high byte first.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

COMMAND_ID, IMAGE_ID, SENSORS_ID, EMPTY_ID = 0x80, 0x01, 0x02, 0x03
IMAGES, SENSORS = 1, 2
"""Bits of a request: which of the two streams are on."""
CALIBRATE, AVOID, PRESET = 1, 2, 4
"""Bits of the settings: take the infrared's baseline; on-board avoidance; the wheels' fields are counts."""
STOP_SOUND = 0x20
WIDTH, HEIGHT = 160, 120
COMMAND_SIZE, SENSORS_SIZE, IMAGE_SIZE = 21, 104, 2 * WIDTH * HEIGHT
PAYLOADS = {EMPTY_ID: 0, SENSORS_ID: SENSORS_SIZE, IMAGE_ID: IMAGE_SIZE}
"""Bytes that follow each id of a reply."""
UNCHANGED = 255
"""The value of a color's part that leaves the LED as it is: anything above 100."""

_COMMAND = struct.Struct("<BBBhhB12BB")
_SENSORS = struct.Struct("<3h3f3h3fb8H8HH4H2hHB3BB3H3HBB")
_INT16 = 1 << 15

Pixels: TypeAlias = NDArray[np.uint8]
"""(120, 160, 3) RGB, row 0 on top."""


class PacketError(ValueError):
    """Bytes that are no packet of the protocol."""


@dataclass(frozen=True, slots=True)
class Command:
    """What a client sends. left, right: steps/s; or counts to set, where `settings` has PRESET.

    leds: bits 0 to 3 LED1, 3, 5, 7; 4 the body, 5 the front. colors: R, G, B (0 to 100) of LED2, 4, 6, 8.
    """

    request: int = SENSORS
    settings: int = 0
    left: int = 0
    right: int = 0
    leds: int = 0
    colors: tuple[int, ...] = (UNCHANGED,) * 12
    sound: int = 0

    def pack(self) -> bytes:
        """The 21 bytes. Raises: PacketError for a value that does not fit its field."""
        try:
            return _COMMAND.pack(
                COMMAND_ID,
                self.request,
                self.settings,
                self.left,
                self.right,
                self.leds,
                *self.colors,
                self.sound,
            )
        except struct.error as error:
            raise PacketError(f"{self}: {error}") from None

    @classmethod
    def unpack(cls, data: bytes) -> Command:
        """The command in 21 bytes. Raises: PacketError."""
        if len(data) != COMMAND_SIZE or data[0] != COMMAND_ID:
            raise PacketError(f"no command: {len(data)} bytes that begin with {data[:1].hex() or 'none'}")
        _, request, settings, left, right, leds, *rest = _COMMAND.unpack(data)
        return cls(request, settings, left, right, leds, tuple(rest[:12]), rest[12])


@dataclass(frozen=True, slots=True)
class Sensors:
    """What the robot senses, in its own units (see `units`); the fields stand as on the wire.

    acceleration_vector: x, y, z, 768 a g. acceleration, orientation, inclination: its length and angles
    (deg). gyro: x, y, z, 131 a deg/s. magnetometer: uT. proximity, ambient: eight, clockwise from the front.
    tof: mm. microphones: right, left, back, front. steps: left, right, wrapping at 16 bits. remote: toggle,
    address, data. ground: three of proximity. ground_ambient: three. button: 1 pressed.
    """

    acceleration_vector: tuple[int, ...] = (0, 0, 768)
    acceleration: float = 768.0
    orientation: float = 0.0
    inclination: float = 0.0
    gyro: tuple[int, ...] = (0, 0, 0)
    magnetometer: tuple[float, ...] = (0.0, 0.0, 0.0)
    temperature: int = 25
    proximity: tuple[int, ...] = (0,) * 8
    ambient: tuple[int, ...] = (0,) * 8
    tof: int = 8190
    microphones: tuple[int, ...] = (0,) * 4
    steps: tuple[int, ...] = (0, 0)
    battery: int = 3300
    card: int = 0
    remote: tuple[int, ...] = (0, 0, 0)
    selector: int = 15
    ground: tuple[int, ...] = (0, 0, 0)
    ground_ambient: tuple[int, ...] = (0, 0, 0)
    button: int = 0

    def pack(self) -> bytes:
        """The 104 bytes, without the id. Raises: PacketError for a value that does not fit its field."""
        values: list[Any] = []
        for name in _FIELDS:
            value = getattr(self, name)
            values += value if isinstance(value, tuple) else [value]
        try:
            return _SENSORS.pack(*values, 0)
        except (struct.error, OverflowError) as error:
            raise PacketError(f"{self}: {error}") from None

    @classmethod
    def unpack(cls, data: bytes) -> Sensors:
        """The sensors in 104 bytes. Raises: PacketError for another number of bytes."""
        if len(data) != SENSORS_SIZE:
            raise PacketError(f"no sensors: {len(data)} bytes, not {SENSORS_SIZE}")
        values = iter(_SENSORS.unpack(data))
        return cls(*(_taken(values, count) for count in _COUNTS))


_FIELDS = tuple(entry.name for entry in fields(Sensors))
_COUNTS = tuple(len(value) if isinstance(value := getattr(Sensors(), name), tuple) else 0 for name in _FIELDS)


def _taken(values: Iterator[Any], count: int) -> Any:
    return tuple(next(values) for _ in range(count)) if count else next(values)


def wrapped(count: int) -> int:
    """A count of steps as 16 bits hold it: -32768 to 32767."""
    return (count + _INT16) % (2 * _INT16) - _INT16


def pack_image(image: NDArray[np.floating]) -> bytes:
    """The 38400 bytes, RGB565, of an image (120, 160, 3) in [0, 1]. Raises: PacketError for another shape."""
    if image.shape != (HEIGHT, WIDTH, 3):
        raise PacketError(f"an image is (120, 160, 3), not {image.shape}")
    red, green, blue = (np.clip(image, 0.0, 1.0) * (31, 63, 31) + 0.5).astype(np.uint16).transpose(2, 0, 1)
    words: NDArray[np.uint16] = red << 11 | green << 5 | blue
    return words.astype(">u2").tobytes()


def unpack_image(data: bytes) -> Pixels:
    """The image in 38400 bytes: low bits are zero, as the clients read it. Raises: PacketError."""
    if len(data) != IMAGE_SIZE:
        raise PacketError(f"no image: {len(data)} bytes, not {IMAGE_SIZE}")
    words = np.frombuffer(data, dtype=">u2").reshape(HEIGHT, WIDTH).astype(np.uint16)
    return np.stack((words >> 8 & 0xF8, words >> 3 & 0xFC, words << 3 & 0xF8), axis=-1).astype(np.uint8)


class CommandReader:
    """Takes commands out of a stream of bytes; what is no command is skipped to the next 0x80."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._buffer = bytearray()

    def feed(self, data: bytes) -> None:
        """Takes bytes in."""
        self._buffer += data

    def __len__(self) -> int:
        """Bytes that wait."""
        return len(self._buffer)

    def waits(self) -> bool:
        """Whether a whole command may have come."""
        return len(self._buffer) >= COMMAND_SIZE

    def next(self) -> Command | None:
        """The next whole command, or None; a part of one is kept."""
        at = self._buffer.find(COMMAND_ID)
        del self._buffer[: len(self._buffer) if at < 0 else at]
        if len(self._buffer) < COMMAND_SIZE:
            return None
        command = Command.unpack(bytes(self._buffer[:COMMAND_SIZE]))
        del self._buffer[:COMMAND_SIZE]
        return command


class ReplyReader:
    """Takes packets out of a robot's stream, in any pieces."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """The packets that are whole now: id and payload. Raises: PacketError for an unknown id."""
        self._buffer += data
        while self._buffer:
            kind = self._buffer[0]
            if kind not in PAYLOADS:
                raise PacketError(f"a packet of unknown id 0x{kind:02x}")
            size = 1 + PAYLOADS[kind]
            if len(self._buffer) < size:
                return
            payload = bytes(self._buffer[1:size])
            del self._buffer[:size]
            yield kind, payload
