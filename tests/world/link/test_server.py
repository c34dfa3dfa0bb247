"""The server, driven by bytes: streams and steps, one client after the other, whatever comes."""

import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tolman.world import Pose, WorldError, open_world
from tolman.world.link.device import Device
from tolman.world.link.packets import EMPTY_ID, IMAGE_ID, SENSORS_ID, Command, ReplyReader, Sensors
from tolman.world.link.server import Server
from tolman.world.link.units import E_PUCK2
from tolman.world.spec import WorldSpec, room_walls

SQUARE = WorldSpec("square", room_walls(1.0, 1.0))
Serve = Callable[..., Server]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Starts servers in threads; each has to have ended well when it is told that it is over."""
    over = threading.Event()
    running: list[tuple[threading.Thread, list[BaseException]]] = []

    def start(**options: object) -> Server:
        world = open_world(
            SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=Pose(0.5, 0.5, 0.0)
        )
        server = Server(Device(world), **options)  # type: ignore[arg-type]
        faults: list[BaseException] = []

        def work() -> None:
            try:
                server.serve(over.is_set)
            except BaseException as fault:
                faults.append(fault)

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        running.append((thread, faults))
        return server

    yield start
    over.set()
    for thread, faults in running:
        thread.join(10)
        assert not thread.is_alive()
        assert faults == []


class Caller:
    """A client of a test."""

    def __init__(self, server: Server) -> None:
        self.socket = socket.create_connection((server.host, server.port), timeout=20)
        self.reader = ReplyReader()
        self.found: list[tuple[int, bytes]] = []

    def send(self, command: Command) -> None:
        self.socket.sendall(command.pack())

    def packet(self) -> tuple[int, bytes]:
        while not self.found:
            data = self.socket.recv(65536)
            assert data, "the server hung up"
            self.found += self.reader.feed(data)
        return self.found.pop(0)

    def ask(self, command: Command) -> Sensors:
        self.send(command)
        kind, payload = self.packet()
        assert kind == SENSORS_ID
        return Sensors.unpack(payload)

    def is_quiet(self, seconds: float = 0.15) -> bool:
        self.socket.settimeout(seconds)
        try:
            return not self.socket.recv(1)
        except TimeoutError:
            return True
        finally:
            self.socket.settimeout(20)


def test_in_step_each_command_is_answered_once_and_lets_a_tick_pass(serve: Serve) -> None:
    caller = Caller(serve(fast=True))
    assert caller.is_quiet()
    counts = [caller.ask(Command(left=500, right=250)).steps for _ in range(5)]
    assert counts == [(16 * tick, 8 * tick) for tick in range(1, 6)]
    assert caller.is_quiet()


def test_in_step_images_and_sensors_come_in_turn_or_at_once(serve: Serve) -> None:
    caller = Caller(serve(fast=True))
    caller.send(Command(request=3))
    assert [caller.packet()[0] for _ in range(2)] == [IMAGE_ID, SENSORS_ID]
    caller.send(Command(request=0))
    assert caller.packet() == (EMPTY_ID, b"")
    caller.send(Command(request=4))
    assert caller.is_quiet()


def test_in_real_time_sensors_stream_after_one_command(serve: Serve) -> None:
    caller = Caller(serve())
    assert caller.is_quiet()
    caller.send(Command())
    began = time.monotonic()
    kinds = [caller.packet()[0] for _ in range(15)]
    assert set(kinds) == {SENSORS_ID}
    assert time.monotonic() - began > 0.3


def test_half_commands_are_waited_for(serve: Serve) -> None:
    caller = Caller(serve(fast=True))
    data = Command(left=1000).pack()
    for byte in range(20):
        caller.socket.sendall(data[byte : byte + 1])
    assert caller.is_quiet()
    caller.socket.sendall(data[20:])
    assert Sensors.unpack(caller.packet()[1]).steps == (32, 0)


def test_wheels_stop_with_the_connection_unless_they_are_to_go_on(serve: Serve) -> None:
    for stops in (True, False):
        server = serve(fast=True, stops=stops)
        first = Caller(server)
        assert first.ask(Command(left=500)).steps == (16, 0)
        first.socket.close()
        wait(lambda server=server: not server.connected)  # type: ignore[misc]
        server.device.tick()
        assert server.device.sensors().steps[0] == (16 if stops else 32)


def test_a_second_client_waits_and_counters_survive(serve: Serve) -> None:
    server = serve(fast=True)
    first, second = Caller(server), Caller(server)
    first.ask(Command(left=500))
    second.send(Command())
    assert second.is_quiet()
    first.socket.close()
    assert Sensors.unpack(second.packet()[1]).steps == (16, 0)


def test_a_slow_reader_gets_whole_packets_and_old_ones_are_dropped(serve: Serve) -> None:
    server = serve()
    caller = Caller(server)
    caller.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    caller.send(Command(request=3))
    time.sleep(0.6)
    kinds = {caller.packet()[0] for _ in range(6)}
    assert kinds == {IMAGE_ID, SENSORS_ID}


def test_one_that_never_reads_does_not_stop_the_robots_time(serve: Serve) -> None:
    server = serve()
    deaf = Caller(server)
    deaf.send(Command(request=3, left=100))
    before = server.device.world.time
    wait(lambda: server.device.world.time > before + 0.5)
    deaf.socket.close()
    assert Caller(server).ask(Command()).selector == 15


def test_a_flood_of_commands_is_borne(serve: Serve) -> None:
    server = serve(fast=True)
    caller = Caller(server)
    caller.socket.sendall(Command(left=10).pack() * 3000)
    kinds = [caller.packet()[0] for _ in range(3000)]
    assert set(kinds) == {SENSORS_ID}


def test_resets_are_borne(serve: Serve) -> None:
    server = serve()
    for _ in range(20):
        caller = Caller(server)
        caller.send(Command(request=3))
        caller.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        caller.socket.close()
    assert Caller(server).ask(Command()).selector == 15


@pytest.mark.parametrize("fast", [True, False])
def test_garbage_never_brings_the_server_down(serve: Serve, fast: bool) -> None:
    server = serve(fast=fast)
    dice = random.Random(1)
    for _ in range(60):
        caller = Caller(server)
        pieces = (dice.randbytes(dice.randrange(300)), Command().pack()[: dice.randrange(22)], b"\x80" * 50)
        for _ in range(dice.randrange(4)):
            caller.socket.sendall(dice.choice(pieces))
        caller.socket.close()
    last = Caller(server)
    last.send(Command(request=0))
    last.send(Command(request=2))
    while last.packet()[0] != SENSORS_ID:
        pass


def test_a_port_that_is_taken_is_one_line(serve: Serve) -> None:
    server = serve()
    with pytest.raises(WorldError, match=r"cannot listen at .*--port"):
        serve(port=server.port)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=120))
def test_any_bytes_leave_a_server_that_answers(one: Server, data: bytes) -> None:
    caller = Caller(one)
    caller.socket.sendall(data)
    caller.socket.close()
    assert Caller(one).ask(Command()).selector == 15


@pytest.fixture
def one(serve: Serve) -> Server:
    """One server for all examples."""
    return serve(fast=True)


def wait(until: Callable[[], bool]) -> None:
    """Waits at most 20 s."""
    end = time.monotonic() + 20
    while not until():
        assert time.monotonic() < end
        time.sleep(0.01)
