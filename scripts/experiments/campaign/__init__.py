"""Campaigns: which runs there are, running them, keeping their rows."""
