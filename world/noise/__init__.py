"""Noise: its presets, and the random streams it draws from."""
