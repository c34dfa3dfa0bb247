"""A simulated robot at work: `simulation.Simulation` opens a world, and maps, trips and missions run on it.

`requests` says what can be asked of it, `replay` runs a recorded session again, `truth` is what only scoring,
saving and drawing know.
"""
