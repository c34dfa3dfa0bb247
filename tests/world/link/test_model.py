"""The model of a link: reproducible by seed, as late as was published, in order."""

import numpy as np
import pytest
from tolman.world import open_world
from tolman.world.errors import WorldError
from tolman.world.link.device import Device
from tolman.world.link.model import LINKS, Link, find_timings
from tolman.world.link.packets import IMAGE_ID, SENSORS_ID, Command, Sensors
from tolman.world.link.units import E_PUCK2


def link(name: str, seed: int = 0) -> Link:
    world = open_world("room", engine="kinematic", noise="none", geometry=E_PUCK2)
    return Link(Device(world), find_timings(name), seed)


def arrivals(of: Link, ticks: int, request: int = 2) -> list[tuple[float, int]]:
    of.send(Command(request))
    found = []
    for _ in range(ticks):
        of.tick()
        found += [(of.time, kind) for kind, _ in of.arrived()]
    return found


def test_the_robot_is_silent_until_its_first_command() -> None:
    silent = link("ideal")
    for _ in range(20):
        silent.tick()
    assert silent.arrived() == []


def test_an_ideal_link_brings_sensors_every_tick() -> None:
    assert [kind for _, kind in arrivals(link("ideal"), 10)] == [SENSORS_ID] * 10


def test_the_same_seed_gives_the_same_link() -> None:
    assert arrivals(link("published", 4), 400) == arrivals(link("published", 4), 400)
    assert arrivals(link("published", 4), 400) != arrivals(link("published", 5), 400)


def test_stalls_of_up_to_two_seconds_happen_and_nothing_is_lost_or_reordered() -> None:
    of = link("published", 1)
    of.send(Command(left=100, right=100))
    times, counts = [], []
    for _ in range(3000):
        of.tick()
        for _, payload in of.arrived():
            times.append(of.time)
            counts.append(Sensors.unpack(payload).steps[0])
    assert 1.0 < np.diff(times).max() < 2.2
    assert (np.diff(np.unwrap(counts, period=65536)) >= 0).all()


def test_images_take_as_long_as_was_published() -> None:
    shares, seconds = np.array(LINKS["published"].image).T
    random = np.random.default_rng(0)
    drawn = np.interp(random.random(20000), shares, seconds)
    assert np.median(drawn) == pytest.approx(0.133, abs=0.01)
    assert drawn.max() < 5.9
    assert np.quantile(drawn, 0.95) == pytest.approx(1.69, abs=0.2)


def test_images_come_before_the_sensors_of_their_cycle() -> None:
    kinds = [kind for _, kind in arrivals(link("ideal"), 20, request=3)]
    assert kinds[:4] == [IMAGE_ID, SENSORS_ID] * 2


def test_an_unknown_link_names_the_nearest() -> None:
    with pytest.raises(WorldError, match="published"):
        find_timings("publishd")
