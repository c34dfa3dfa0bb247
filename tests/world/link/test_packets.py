"""The codec: what is packed is unpacked, where the bytes stand, and streams in any pieces."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.world.link.packets import (
    EMPTY_ID,
    IMAGE_ID,
    IMAGE_SIZE,
    SENSORS_ID,
    Command,
    CommandReader,
    PacketError,
    ReplyReader,
    Sensors,
    pack_image,
    unpack_image,
    wrapped,
)

BYTE, INT16, WORD = st.integers(0, 255), st.integers(-32768, 32767), st.integers(0, 65535)
FLOAT = st.floats(width=32, allow_nan=False)
COMMANDS = st.builds(Command, BYTE, BYTE, INT16, INT16, BYTE, st.tuples(*[BYTE] * 12), BYTE)
SENSORS = st.builds(
    Sensors,
    st.tuples(*[INT16] * 3),
    FLOAT,
    FLOAT,
    FLOAT,
    st.tuples(*[INT16] * 3),
    st.tuples(*[FLOAT] * 3),
    st.integers(-128, 127),
    st.tuples(*[WORD] * 8),
    st.tuples(*[WORD] * 8),
    WORD,
    st.tuples(*[WORD] * 4),
    st.tuples(INT16, INT16),
    WORD,
    BYTE,
    st.tuples(*[BYTE] * 3),
    BYTE,
    st.tuples(*[WORD] * 3),
    st.tuples(*[WORD] * 3),
    BYTE,
)


@given(COMMANDS)
def test_a_command_is_what_was_packed(command: Command) -> None:
    assert Command.unpack(command.pack()) == command
    assert len(command.pack()) == 21


@given(SENSORS)
def test_sensors_are_what_was_packed(sensors: Sensors) -> None:
    assert Sensors.unpack(sensors.pack()) == sensors
    assert len(sensors.pack()) == 104


def test_bytes_stand_where_the_robots_firmware_has_them() -> None:
    assert Command(left=212, right=-212).pack()[:7].hex(" ") == "80 02 00 d4 00 2c ff"
    sensors = Sensors(proximity=tuple(range(100, 108)), tof=1234, steps=(-1, 2), battery=3300, selector=15)
    data = sensors.pack()
    assert struct.unpack_from("<8H", data, 37) == tuple(range(100, 108))
    assert struct.unpack_from("<H", data, 69) == (1234,)
    assert struct.unpack_from("<2h", data, 79) == (-1, 2)
    assert struct.unpack_from("<H", data, 83) == (3300,)
    assert data[89] == 15


@pytest.mark.parametrize("data", [b"", bytes(21), b"\x80" * 20, b"\x80" * 22])
def test_what_is_no_command_is_refused(data: bytes) -> None:
    with pytest.raises(PacketError, match="no command"):
        Command.unpack(data)


def test_values_that_do_not_fit_are_refused() -> None:
    with pytest.raises(PacketError):
        Command(left=40000).pack()
    with pytest.raises(PacketError):
        Sensors(tof=-1).pack()
    with pytest.raises(PacketError):
        Sensors.unpack(bytes(103))
    with pytest.raises(PacketError):
        unpack_image(bytes(3))


@given(st.integers(-(10**9), 10**9))
def test_counts_wrap_at_16_bits(count: int) -> None:
    assert wrapped(count) == struct.unpack("<h", struct.pack("<H", count % 65536))[0]


def test_pixels_have_their_high_byte_first() -> None:
    image = np.zeros((120, 160, 3))
    image[..., 0] = 1.0
    assert pack_image(image)[:2].hex() == "f800"
    assert unpack_image(b"\xf8\x00" * (160 * 120))[5, 7].tolist() == [248, 0, 0]


@given(st.integers(0, 2**32 - 1))
def test_images_come_back_within_a_step_of_their_bits(seed: int) -> None:
    image = np.random.default_rng(seed).random((120, 160, 3))
    back = unpack_image(pack_image(image)) / 255.0
    assert float(np.abs(back - image).max()) < 8 / 255 + 0.02


@given(st.lists(COMMANDS, max_size=6), st.binary(max_size=40), st.data())
def test_commands_are_read_in_any_pieces_and_after_garbage(
    commands: list[Command], garbage: bytes, data: st.DataObject
) -> None:
    stream = garbage.replace(b"\x80", b"") + b"".join(command.pack() for command in commands)
    reader, found = CommandReader(), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        reader.feed(stream[:size])
        stream = stream[size:]
        while (command := reader.next()) is not None:
            found.append(command)
    assert found == commands


@given(st.binary(max_size=400))
def test_a_reader_of_commands_bears_any_bytes(data: bytes) -> None:
    reader = CommandReader()
    reader.feed(data)
    while reader.next() is not None:
        pass
    assert len(reader) < 21


@given(st.lists(st.sampled_from([IMAGE_ID, SENSORS_ID, EMPTY_ID]), max_size=4), st.integers(1, 9000))
def test_replies_are_read_in_any_pieces(kinds: list[int], size: int) -> None:
    sizes = {IMAGE_ID: IMAGE_SIZE, SENSORS_ID: 104, EMPTY_ID: 0}
    stream = b"".join(bytes([kind]) + bytes(sizes[kind]) for kind in kinds)
    reader = ReplyReader()
    found: list[tuple[int, bytes]] = []
    for at in range(0, len(stream), size):
        found += reader.feed(stream[at : at + size])
    assert [kind for kind, _ in found] == kinds


def test_an_unknown_reply_is_an_error() -> None:
    with pytest.raises(PacketError, match="0x77"):
        list(ReplyReader().feed(b"\x77"))
