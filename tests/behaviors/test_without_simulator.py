from __future__ import annotations

import subprocess
import sys

TRIAL = """
import sys
from tolman.agent.goals import ExploreLocally, Follow, GoAlong, DrivePath, ReacquireCorner
from tolman.behaviors.go_to_node import GoToNode
from tolman.behaviors.local_exploration import LocalExploration
from tolman.behaviors.local_go_to import LocalGoTo
from tolman.behaviors.position_correction import PositionCorrection
from tolman.behaviors.wall_following import WallFollowing
from tolman.plugins.testing import Trial, percept

Trial(WallFollowing(), goal=Follow("right")).run(percept(right=0.022), ticks=5)
Trial(LocalExploration(), goal=ExploreLocally()).run(ticks=5)
Trial(PositionCorrection(), goal=ReacquireCorner("right", "concave", 0.1)).run(ticks=5)
Trial(GoToNode(), goal=GoAlong(())).run(ticks=2)
Trial(LocalGoTo(), goal=DrivePath(((0.1, 0.0),))).run(ticks=5)
heavy = {"dartpy", "embreex", "matplotlib", "yaml", "tolman.world.physics.dart"}
print(" ".join(sorted(heavy & set(sys.modules))))
"""


def test_a_behavior_s_test_loads_no_simulator() -> None:
    done = subprocess.run([sys.executable, "-c", TRIAL], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
