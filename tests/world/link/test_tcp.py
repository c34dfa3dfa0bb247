"""Our driver over sockets: a server in another process, connections that break, addresses that are none."""

import json
import re
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from tolman.maps import HybridMap
from tolman.scripts.cli.program import execute
from tolman.world import Pose, WheelCommand, open_world
from tolman.world.link.channel import LinkError
from tolman.world.link.device import Device
from tolman.world.link.driver import LinkedRobot, LinkedWorld
from tolman.world.link.opening import connect
from tolman.world.link.server import Server
from tolman.world.link.tcp import TcpChannel, parse_address
from tolman.world.link.units import E_PUCK2
from tolman.world.spec import WorldSpec, room_walls

SQUARE = WorldSpec("square", room_walls(1.0, 1.0))


class Served:
    """A server in a thread, to be used with `with`."""

    def __init__(self, port: int = 0, **options: object) -> None:
        start = Pose(0.5, 0.5, 0.0)
        self.world = open_world(SQUARE, engine="kinematic", noise="none", geometry=E_PUCK2, start=start)
        self.server = Server(Device(self.world), port=port, **options)  # type: ignore[arg-type]
        self.url = f"tcp://127.0.0.1:{self.server.port}"
        self._over = threading.Event()
        self._thread = threading.Thread(target=self.server.serve, args=(self._over.is_set,), daemon=True)

    def __enter__(self) -> "Served":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join(10)


def step_often(world: LinkedWorld) -> None:
    for _ in range(50):
        world.step()


@pytest.mark.parametrize(
    ("url", "address"),
    [
        ("tcp://10.0.0.2:1000", ("10.0.0.2", 1000)),
        ("tcp://robot.local", ("robot.local", 1000)),
        ("tcp://[::1]:7", ("::1", 7)),
    ],
)
def test_addresses(url: str, address: tuple[str, int]) -> None:
    assert parse_address(url) == address


@pytest.mark.parametrize(
    "url", ["", "10.0.0.2", "http://a:1", "tcp://", "tcp://a:0", "tcp://a:99999", "tcp://a b:1"]
)
def test_what_is_no_address_is_one_line(url: str) -> None:
    with pytest.raises(LinkError, match=r"write tcp://HOST:PORT"):
        parse_address(url)


def test_a_robot_that_is_not_there_is_one_line() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(LinkError, match="selector"):
        TcpChannel(f"tcp://127.0.0.1:{port}")


def test_one_that_says_nothing_is_given_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as mute, pytest.raises(LinkError, match="no sensors"):
        TcpChannel(f"tcp://127.0.0.1:{mute.getsockname()[1]}", giving_up=0.5)


def test_in_step_a_tick_is_a_command() -> None:
    with Served(fast=True) as served, connect(served.url, "place") as world:
        robot = world.robots[0]
        before = robot.sense()
        for _ in range(10):
            robot.act(WheelCommand(100.0, 200.0))
            world.step()
        after = robot.sense()
        assert after.tick == before.tick + 10
        assert after.time == pytest.approx(before.time + 0.32)
        assert after.encoders == pytest.approx((32.0, 64.0), abs=0.6)
        assert robot.look().shape == (16, 16)
        assert served.world.true_pose().heading > 0.0


def test_in_real_time_the_newest_sensors_make_a_tick() -> None:
    with Served() as served, connect(served.url, "place") as world:
        robot = world.robots[0]
        began, first = time.monotonic(), robot.sense().time
        for _ in range(20):
            robot.act(WheelCommand(150.0, 150.0))
            world.step()
        assert robot.sense().time - first == pytest.approx(time.monotonic() - began, abs=0.25)
        assert isinstance(robot, LinkedRobot)
        assert robot.predictor.counts[0] > 20


def test_wheels_stop_when_nobody_drives() -> None:
    with Served() as served, connect(served.url, "place") as world:
        world.robots[0].act(WheelCommand(200.0, 200.0))
        world.step()
        time.sleep(1.2)
        before = served.world.true_pose()
        time.sleep(0.3)
        assert served.world.true_pose() == before


def test_a_connection_that_broke_is_made_again() -> None:
    with Served(fast=True) as served:
        port = served.server.port
        channel = TcpChannel(served.url, giving_up=20.0)
        world = LinkedWorld(LinkedRobot(channel, E_PUCK2), SQUARE)
        world.step()
    with Served(port=port, fast=True):
        world.step()
        world.step()
        assert channel.reconnections >= 1
        world.close()


def test_a_link_that_is_gone_for_good_ends_the_run() -> None:
    with Served(fast=True) as served:
        channel = TcpChannel(served.url, giving_up=0.6)
        world = LinkedWorld(LinkedRobot(channel, E_PUCK2), SQUARE)
    with pytest.raises(LinkError, match="given up"):
        step_often(world)
    world.close()


def test_hostile_answers_are_no_more_than_a_lost_link() -> None:
    with socket.create_server(("127.0.0.1", 0)) as evil:

        def answer() -> None:
            for _ in range(3):
                connection = evil.accept()[0]
                with connection:
                    connection.recv(21)
                    connection.sendall(b"\x02" + bytes(50) + b"\xff" * 500)

        threading.Thread(target=answer, daemon=True).start()
        with pytest.raises(LinkError):
            TcpChannel(f"tcp://127.0.0.1:{evil.getsockname()[1]}", giving_up=1.0)


@pytest.mark.e2e
@pytest.mark.slow
def test_our_agent_maps_and_finds_its_way_by_a_server_in_another_process(tmp_path: Path) -> None:
    path, mapping = tmp_path / "m.tolman", ["map", "room", "--max-nodes", "2"]
    command = [sys.executable, "-m", "tolman.scripts.cli", "serve", "room", "--fast", "--port", "0", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        line = next(line for line in server.stderr if "serving" in line)
        url = re.findall(r"tcp://\S+?(?=;)", line)[0]
        try:
            assert execute([*mapping, "-o", str(path), "--global-only", "--robot", url]) == 0
            assert execute(["go", str(path), "--to", "0", "--robot", url]) == 0
        finally:
            server.send_signal(2)
        out, _ = server.communicate(timeout=30)
    assert server.returncode == 0
    assert json.loads(out)["clients"] == 2
    hybrid_map = HybridMap.load(path)
    assert len(hybrid_map.nodes()) == 2
    assert hybrid_map.meta.geometry == "e-puck2"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["map", "room", "-o", "m.tolman", "--robot", "tcp://a:1", "--start", "1,1,1"], "carry the robot"),
        (["map", "room", "-o", "m.tolman", "--robot", "tcp://a:1", "--record", "r"], "cannot be replayed"),
        (["map", "room", "-o", "m.tolman", "--link", "calm", "--record", "r"], "cannot be replayed"),
        (["map", "room", "-o", "m.tolman", "--robot", "tcp://a:1", "--live"], "true poses"),
        (["map", "room", "-o", "m.tolman", "--robot", "nowhere"], "write tcp://HOST:PORT"),
        (["map", "room", "-o", "m.tolman", "--calibration", "c.yaml"], "give --robot or --link"),
        (["map", "room", "-o", "m.tolman", "--link", "calm", "--calibration", "c.yaml"], "c.yaml"),
        (["serve", "room", "--fast", "--link", "calm"], "do not go together"),
        (["serve", "roomm"], "room"),
    ],
)
def test_what_does_not_go_together_is_one_line(
    arguments: list[str], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert execute(arguments) in (1, 2)
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert reason in error
    assert not (tmp_path / "m.tolman").exists()
