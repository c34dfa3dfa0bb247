from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolman.agent import Agent
from tolman.agent.events import CornerReached, Event, WallMet
from tolman.agent.goals import Follow, FollowFrom
from tolman.behaviors.wall_following import Following, WallFollowing
from tolman.plugins.testing import (
    Trial,
    assert_drives_forward,
    assert_event_order,
    assert_in_place,
    assert_stands,
    assert_states,
    assert_turns,
    assert_valid,
    percept,
)
from tolman.plugins.testing.strategies import percept_runs
from tolman.world import open_world
from tolman.world.base import World
from tolman.world.robot import EPUCK, Percept, Pose, wrap_angle

GAP = 0.057 - EPUCK.body_radius
ENV1 = [
    ("concave", 0.943, 0.057),
    ("concave", 0.943, 0.603),
    ("convex", 0.643, 0.603),
    ("concave", 0.643, 0.943),
    ("concave", 0.057, 0.943),
    ("concave", 0.057, 0.057),
    ("concave", 0.243, 0.057),
    ("convex", 0.243, 0.590),
    ("convex", 0.477, 0.590),
    ("concave", 0.477, 0.057),
]
"""env1's nodes with the wall on the right, in order: 5.7 cm from each wall (m, world frame)."""


class Follower:
    """Follows walls in a kinematic world; keeps the corners with the true pose at each."""

    def __init__(self, world: World, side: str) -> None:
        self.world = world
        self.agent = Agent(world.robots[0], [WallFollowing()])
        self.corners: list[tuple[CornerReached, Pose]] = []
        self.heard: list[Event] = []
        self.agent.bus.subscribe(Event, self.heard.append)
        self.agent.bus.subscribe(CornerReached, lambda event: self.corners.append((event, world.true_pose())))
        self.agent.start("wall-following", Follow(side))

    def until(self, corners: int, max_ticks: int = 8000) -> Follower:
        for _ in range(max_ticks):
            if len(self.corners) >= corners:
                return self
            self.agent.tick()
            self.world.step()
        raise AssertionError(f"{len(self.corners)} corners in {max_ticks} ticks, expected {corners}")


def env1(side: str, noise: str, seed: int = 0) -> Follower:
    return Follower(open_world("env1", engine="kinematic", noise=noise, seed=seed, start=side), side)


@pytest.mark.parametrize("side", ["right", "left"])
def test_without_noise_corners_are_met_within_two_millimeters(side: str) -> None:
    follower = env1(side, "none").until(len(ENV1) + 1)
    nodes = ENV1 if side == "right" else [ENV1[9], *reversed(ENV1[:9])]
    for (event, pose), (kind, x, y) in zip(follower.corners, [*nodes, nodes[0]], strict=True):
        assert (event.kind, event.side) == (kind, side)
        assert math.hypot(pose.x - x, pose.y - y) < 0.002
    assert follower.world.collisions() == 0


def test_path_lengths_are_the_ways_between_corners() -> None:
    follower = env1("right", "none").until(len(ENV1) + 1)
    for i, (event, _) in enumerate(follower.corners[1:], start=1):
        (_, ax, ay), (_, bx, by) = ENV1[i - 1], ENV1[i % len(ENV1)]
        assert event.path_length == pytest.approx(math.hypot(bx - ax, by - ay), abs=0.003)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_with_the_published_noise_corners_stay_within_five_millimeters(seed: int) -> None:
    follower = env1("right", "thesis", seed).until(len(ENV1))
    assert [event.kind for event, _ in follower.corners] == [kind for kind, _, _ in ENV1]
    off = [math.hypot(p.x - x, p.y - y) for (_, p), (_, x, y) in zip(follower.corners, ENV1, strict=True)]
    assert max(off) < 0.005
    assert follower.world.collisions() == 0


def test_each_wall_is_told_before_its_corner_with_its_direction() -> None:
    follower = env1("right", "none").until(5)
    told = [event for event in follower.heard if isinstance(event, (CornerReached, WallMet))]
    assert_event_order(told, *[WallMet, CornerReached] * 5)
    for i, event in enumerate(told):
        if isinstance(event, CornerReached):
            assert abs(wrap_angle(event.heading - told[i - 1].heading)) < math.radians(1.5)
            assert abs(wrap_angle(event.heading - 0.5 * math.pi * round(event.heading / (0.5 * math.pi)))) < (
                math.radians(1.5)
            )


@pytest.mark.parametrize("mismatch", [0.015, -0.015])
def test_walls_tell_what_odometry_turned_on_the_part_of_them_that_was_seen(mismatch: float) -> None:
    """Before a convex corner a wall has ended already, and after one it is not there yet."""
    world = open_world("env1", engine="kinematic", noise={"unequal_wheels": mismatch}, start="right")
    follower = Follower(world, "right").until(9)
    told = [event for event in follower.heard if isinstance(event, (CornerReached, WallMet))]
    turned = {"concave": 0.0, "convex": 0.0}
    seen = {"concave": 0.0, "convex": 0.0}
    for met, corner in zip(told[::2], told[1::2], strict=True):
        assert isinstance(met, WallMet)
        assert isinstance(corner, CornerReached)
        turned[corner.kind] += wrap_angle(corner.heading - met.heading)
        seen[corner.kind] += corner.path_length - met.path_length - corner.unobserved_length
    for kind, length in seen.items():
        assert -turned[kind] * EPUCK.track / length == pytest.approx(mismatch, rel=0.15)


SLANTED = """\
tolman-world: 1
description: a room with walls at 45 degrees
room: {size: [1.2, 1.0]}
polygons:
  - points: [[1.2, 0.6], [1.2, 1.0], [0.8, 1.0]]
  - points: [[0.0, 0.55], [0.25, 0.8], [0.0, 1.0]]
starts:
  right: [0.5, 0.057, 0]
"""


def test_slanted_walls_are_followed_corner_by_corner_and_their_turns_told(tmp_path: Path) -> None:
    path = tmp_path / "slanted.yaml"
    path.write_text(SLANTED)
    world = open_world(path, engine="kinematic", noise="none", start="right")
    follower = Follower(world, "right").until(8)
    walls = [event for event in follower.heard if isinstance(event, WallMet)]
    turns = [
        math.degrees(wrap_angle(wall.heading - corner.heading))
        for (corner, _), wall in zip(follower.corners, walls[1:], strict=False)
    ]
    assert [event.kind for event, _ in follower.corners[:7]] == ["concave"] * 4 + ["convex"] + ["concave"] * 2
    assert turns == pytest.approx([90.0, 45.0, 45.0, 141.3, -96.3, 45.0, 90.0], abs=4.0)
    first, again = follower.corners[0][1], follower.corners[7][1]
    assert first.distance_to(again) < 0.003
    assert world.collisions() == 0


def test_a_wall_come_upon_at_a_slant_is_no_corner() -> None:
    world = open_world("env1", engine="kinematic", noise="none", start=Pose(0.2, 0.8, 0.5))
    follower = Follower(world, "right").until(1)
    pose = follower.corners[0][1]
    assert math.hypot(pose.x - 0.057, pose.y - 0.943) < 0.003


def test_searching_it_drives_on_until_a_wall_is_ahead_then_turns_away_from_it() -> None:
    trial = Trial(WallFollowing(), goal=Follow("right"))
    assert_drives_forward(trial.run(ticks=20))
    trial.step(percept(front=0.02))
    assert_turns(trial.step(percept(front=0.02)), "left")
    assert_states(trial.states, Following.SEARCH, Following.TURN_AWAY)


def test_beside_a_wall_it_keeps_its_distance() -> None:
    for gap, side in ((GAP - 0.006, "left"), (GAP + 0.006, "right")):
        trial = Trial(WallFollowing(), goal=Follow("right", FollowFrom.WALL))
        trial.run(percept(right=gap), ticks=10)
        assert_drives_forward(trial.proposals[-1])
        assert_turns(trial.proposals[-1], side)


def test_a_wall_ahead_is_looked_at_standing_before_the_corner_is_told() -> None:
    trial = Trial(WallFollowing(), goal=Follow("right", FollowFrom.WALL))
    trial.run(percept(right=GAP), ticks=60)
    trial.run(percept(right=GAP, front=GAP - 0.001), ticks=4)
    for proposal in trial.proposals[-4:]:
        assert_stands(proposal)
    (corner,) = [event for event in trial.events if isinstance(event, CornerReached)]
    assert corner.kind == "concave"
    assert corner.turn == pytest.approx(0.5 * math.pi, abs=0.1)
    assert corner.path_length == pytest.approx(trial.pose.x, abs=0.002)
    assert_turns(trial.step(percept(right=GAP, front=GAP)), "left")


def test_where_the_wall_ends_it_drives_its_distance_on_and_turns_around_the_end() -> None:
    trial = Trial(WallFollowing(), goal=Follow("left", FollowFrom.WALL))
    trial.run(percept(left=GAP), ticks=60)
    ended = trial.pose.x
    trial.run(ticks=130)
    (corner,) = [event for event in trial.events if isinstance(event, CornerReached)]
    assert corner.kind == "convex"
    assert corner.turn == pytest.approx(0.5 * math.pi, abs=0.1)
    assert corner.path_length == pytest.approx(ended + 0.057, abs=0.005)
    trial.run(ticks=80)
    assert_states(trial.states, *list(Following)[0:2], Following.ADVANCE, Following.CONVEX, Following.GAP)
    assert trial.pose.heading == pytest.approx(0.5 * math.pi, abs=0.05)


def test_where_nothing_tells_the_walls_direction_it_goes_slowly() -> None:
    trial = Trial(WallFollowing(), goal=Follow("right", FollowFrom.WALL))
    trial.run(percept(right=GAP), ticks=60)
    before = trial.pose.x
    trial.run(percept(right=GAP), ticks=20)
    seen, before = trial.pose.x - before, trial.pose.x
    trial.run(ticks=30)
    before = trial.pose.x
    trial.run(ticks=20)
    assert trial.pose.x - before == pytest.approx(0.5 * seen, rel=0.05)


@pytest.mark.parametrize(
    ("start", "turn", "side"),
    [
        (FollowFrom.CONCAVE, None, "left"),
        (FollowFrom.CONVEX, None, "right"),
        (FollowFrom.CONCAVE, 0.7, "left"),
    ],
)
def test_at_a_corner_it_begins_with_the_turn_it_was_told(
    start: FollowFrom, turn: float | None, side: str
) -> None:
    trial = Trial(WallFollowing(), goal=Follow("right", start, turn))
    proposal = trial.step()
    assert_in_place(proposal)
    assert_turns(proposal, side)
    for _ in range(300):
        if trial.behavior.state is not trial.states[0] and trial.behavior.state in (
            Following.FOLLOW,
            Following.GAP,
        ):
            break
        trial.step()
    assert abs(trial.pose.heading) == pytest.approx(0.5 * math.pi if turn is None else turn, abs=0.01)


def mirror(run: list[Percept]) -> list[Percept]:
    return [Percept(p.tick, p.time, p.infrared[::-1], p.encoders, p.accelerometer) for p in run]


@settings(max_examples=50, deadline=None)
@given(percept_runs(), st.sampled_from(list(FollowFrom)))
def test_left_is_the_mirror_image_of_right_whatever_is_sensed(run: list[Percept], start: FollowFrom) -> None:
    right = Trial(WallFollowing(), goal=Follow("right", start))
    left = Trial(WallFollowing(), goal=Follow("left", start))
    right.run(run)
    left.run(mirror(run))
    for one, other in zip(right.proposals, left.proposals, strict=True):
        one, other = assert_valid(one), assert_valid(other)
        assert (one.command.left, one.command.right) == pytest.approx(
            (other.command.right, other.command.left), abs=1e-6
        )
    assert right.states == left.states
    assert not right.behavior.finished


def test_only_a_follow_goal_is_taken() -> None:
    with pytest.raises(TypeError, match="needs a Follow goal, not None"):
        Trial(WallFollowing())


WEDGE = """\
tolman-world: 1
room: {size: [1.5, 1.5]}
polygons:
  - points: [[0.4, 0.7], [1.0, 0.7], [1.0, 1.05]]
starts:
  right: [0.343, 0.643, 180]
"""


def test_a_sharp_edge_is_passed_before_it_is_turned_around(tmp_path: Path) -> None:
    """The node 5.7 cm past the edge of 30 degrees and off its wall: the next one leads back over it."""
    path = tmp_path / "wedge.yaml"
    path.write_text(WEDGE)
    world = open_world(path, engine="kinematic", noise="none", start="right")
    agent = Agent(world.robots[0], [WallFollowing()])
    corners: list[CornerReached] = []
    agent.bus.subscribe(CornerReached, corners.append)
    turn = math.pi - math.atan2(0.35, 0.6)
    agent.start("wall-following", Follow("right", FollowFrom.CONVEX, -turn))
    while not corners and world.time < 60.0:
        agent.tick()
        world.step()
    assert world.collisions() == 0
    assert corners[0].kind == "convex"
    end, pose = (1.0, 1.05), world.true_pose()
    assert math.dist(end, (pose.x, pose.y)) == pytest.approx(math.hypot(0.057, 0.057), abs=0.01)


def in_a_room(folder: Path, text: str, start: Pose, side: str, seed: int) -> Follower:
    """Beside a wall of a room of one's own, in the kinematic twin with the published noise."""
    path = folder / "room.yaml"
    path.write_text(f"tolman-world: 1\n{text}\n")
    world = open_world(path, engine="kinematic", noise="thesis", seed=seed, start=start)
    follower = Follower(world, side)
    follower.agent.start("wall-following", Follow(side, FollowFrom.WALL))
    return follower


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.05, 0.08, 0.15, 0.3])
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_pillar_is_followed_right_round_without_a_corner(tmp_path: Path, radius: float, side: str) -> None:
    heading = 0.0 if side == "right" else math.pi
    text = f"room: {{size: [2.0, 2.0]}}\ncylinders: [{{at: [1.0, 1.0], radius: {radius}}}]"
    follower = in_a_room(tmp_path, text, Pose(1.0, 1.057 + radius, heading), side, seed=3)
    away: list[float] = []
    for _ in range(round(2.5 * math.tau * (radius + 0.057) / 0.03 / 0.032)):
        follower.agent.tick()
        follower.world.step()
        pose = follower.world.true_pose()
        away.append(math.hypot(pose.x - 1.0, pose.y - 1.0) - radius)
    assert all(corner.kind == "bend" for corner, _ in follower.corners)
    assert min(away) > 0.050
    assert max(away) < 0.080
    assert sum(away) / len(away) == pytest.approx(0.057, abs=0.004)


def blunt_corner(degrees: float) -> str:
    """A room with a block whose edge at (1.0, 0.5), seen from below, turns by so much."""
    turn = math.radians(degrees)
    right = [1.0 + 0.5 * math.cos(turn), 0.5 + 0.5 * math.sin(turn)]
    points = [[0.3, 0.5], [1.0, 0.5], right, [0.3, right[1]]]
    return f"room: {{size: [2.0, 1.6]}}\npolygons: [{{points: {points}}}]"


@pytest.mark.parametrize("degrees", [52, 60])
def test_a_blunt_corner_is_as_far_from_both_walls_from_either_side(tmp_path: Path, degrees: float) -> None:
    turn = math.radians(degrees)
    edge = 0.057 / math.cos(0.5 * turn)
    place = (1.0 + edge * math.sin(0.5 * turn), 0.5 - edge * math.cos(0.5 * turn))
    along = Pose(0.7, 0.443, 0.0), "left"
    down = (1.0 + 0.3 * math.cos(turn), 0.5 + 0.3 * math.sin(turn))
    start = Pose(down[0] + 0.057 * math.sin(turn), down[1] - 0.057 * math.cos(turn), turn - math.pi)
    for pose, side in (along, (start, "right")):
        for seed in range(4):
            follower = in_a_room(tmp_path, blunt_corner(degrees), pose, side, seed).until(1)
            corner, at = follower.corners[0]
            assert corner.kind == "convex"
            assert abs(corner.turn) == pytest.approx(turn, abs=0.17)
            assert math.hypot(at.x - place[0], at.y - place[1]) < 0.012


@pytest.mark.parametrize("degrees", [20, 30])
def test_a_wall_that_bends_away_a_little_is_followed_without_a_corner(tmp_path: Path, degrees: float) -> None:
    for seed in range(4):
        follower = in_a_room(tmp_path, blunt_corner(degrees), Pose(0.7, 0.443, 0.0), "left", seed)
        while follower.world.true_pose().x < 1.25:
            follower.agent.tick()
            follower.world.step()
        assert follower.corners == []


@pytest.mark.parametrize("gap", [0.10, 0.11, 0.13])
def test_a_passage_hardly_wider_than_the_robot_is_driven_into(tmp_path: Path, gap: float) -> None:
    """Up along a block that leaves a gap below the room's upper wall, then through it."""
    text = f"room: {{size: [1.2, 1.0]}}\nboxes: [{{corners: [[0.5, 0.0], [0.7, {1.0 - gap}]]}}]"
    for seed in range(4):
        follower = in_a_room(tmp_path, text, Pose(0.443, 0.4, 0.5 * math.pi), "right", seed)
        for _ in range(1200):
            follower.agent.tick()
            follower.world.step()
            if follower.world.true_pose().x > 0.74:
                break
        assert follower.world.true_pose().x > 0.74
        assert follower.corners[0][0].kind == "convex"
        assert follower.world.collisions() == 0
