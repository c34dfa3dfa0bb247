"""Maps, then visits node after node and looks ahead until it sees a wall with a pattern on it.

tolman run scripts/missions/find_textured_wall.py --world env1-textured
"""

from tolman.agent.missions.steps import Explore, Fail, GoTo, Look, Nodes, OnFailure, Save, Say

STEP, STEPS = 0.08, 5
"""So many steps of luminance along a row make a texture; plain walls meet in at most three edges."""


def is_textured(image):
    """Whether one of the rows at the height of the camera has the steps of a texture."""
    steps = abs(image[7:9, 1:] - image[7:9, :-1]) > STEP
    return int(steps.sum(axis=1).max()) >= STEPS


def mission():
    """Ends at the first node from which a textured wall is seen; its number is the mission's result."""
    yield Explore(side="right")
    yield Save("textured.tolman")
    for node in (yield Nodes()):
        yield OnFailure(GoTo(node), retries=1)
        if is_textured((yield Look())):
            yield Say(f"node {node}: a textured wall")
            return node
    yield Fail("no textured wall is seen from any node")
