"""Comparing, aligning and merging maps."""
