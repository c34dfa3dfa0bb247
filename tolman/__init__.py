"""A robot explores an unknown walled world, builds a hybrid map of it, and finds its way with it later.

Five lines map a room, in memory or into a file:

    import tolman

    with tolman.Simulation("env1", seed=3) as simulation:
        report = simulation.map("env1.tolman")
    print(report.nodes, tolman.HybridMap.load("env1.tolman"))

or step a world by hand, with behaviors of your own:

    with tolman.Simulation("env1", behaviors=[Shy()]) as simulation:
        simulation.agent.start("shy")
        while simulation.time < 10.0:
            simulation.step()

What is here, by what you do with it:

- run: `Simulation`, and `map_world`, `go_to`, `run_mission` for what `tolman map`, `go` and `run` do
- worlds: `open_world`, `World`, `WorldSpec`, `built_in_worlds`, `find_world`
- maps: `HybridMap`, `LocalMap`, `SOM`
- behaviors: `Behavior`, `Transition`, `Proposal`, `Context`, `Percept`, `WheelCommand`, `Agent`
- missions: `Mission`

Everything else is in the packages `tolman.world`, `tolman.maps`, `tolman.agent`, `tolman.behaviors` and
`tolman.plugins` (the test kit is `tolman.plugins.testing`). Nothing is loaded before it is used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
