"""Single runs, by kind: from plain settings to plain figures."""
