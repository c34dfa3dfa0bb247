"""Maps, then visits node after node and looks ahead until it sees a wall with a pattern on it.

tolman run scripts/missions/find_textured_wall.py --world env1-textured
"""

from tolman.agent.mission_steps import Explore, Fail, GoTo, Look, Nodes, OnFailure, Save, Say

CONTRAST = 0.12
"""Standard deviation of luminance, in the image's middle rows, from which a wall counts as textured."""


def mission():
    """Ends at the first node from which a textured wall is seen; its number is the mission's result."""
    yield Explore(side="right")
    yield Save("textured.tolman")
    for node in (yield Nodes()):
        yield OnFailure(GoTo(node), retries=1)
        image = yield Look()
        middle = image[6:10]
        if float(middle.std()) > CONTRAST:
            yield Say(f"node {node}: a textured wall")
            return node
    yield Fail("no textured wall is seen from any node")
