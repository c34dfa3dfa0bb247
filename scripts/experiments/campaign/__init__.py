"""Campaigns: which runs there are, how they are run, and how their results are kept."""
