"""Obstacles that stand free: where to look for them, crossing to them, and linking them to the map."""
