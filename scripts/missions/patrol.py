"""Patrols all nodes of a map, twice; a node that cannot be reached is skipped and counted.

tolman run scripts/missions/patrol.py --map m.tolman
"""

from tolman.agent.errors import StepFailedError
from tolman.agent.missions.steps import GoTo, Nodes, Repeat, Say


def mission():
    """All nodes in the order of their numbers, two rounds."""
    nodes = yield Nodes()
    missed = []

    def one_round():
        for node in nodes:
            try:
                yield GoTo(node)
            except StepFailedError as failed:
                missed.append(node)
                yield Say(f"node {node}: {failed.reason}")

    yield Repeat(one_round, times=2)
    yield Say(f"patrol done, {len(missed)} of {2 * len(nodes)} visits missed")
    return missed
