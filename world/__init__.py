"""The robot and its surroundings."""
