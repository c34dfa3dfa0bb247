"""Two robots share one map: the first makes it, the second finds its way with it.

tolman run scripts/missions/two_robots.py --world scripts/missions/two_robots_world.yaml
"""

from tolman.agent.missions.steps import As, Explore, GoTo, Load, Nodes, Place, Save, Say, Together


def mission():
    """The first maps and saves; then both drive at once, in different parts of the world."""
    yield Explore(side="right")
    yield Save("shared.tolman")
    nodes = yield Nodes()
    middle = nodes[len(nodes) // 2]

    def second():
        yield Load("shared.tolman")
        yield Place(middle)  # somebody puts it there: it does not have to find out where it is
        return (yield GoTo(nodes[len(nodes) // 2 + 1]))

    places = yield Together(GoTo(nodes[1]), As(1, second))
    yield Say(f"the first is at node {places[0]}, the second at node {places[1]}")
    return places
