"""Worlds as people have them, drawn from seeds: scanned plans, offices, halls, mazes, clutter."""
