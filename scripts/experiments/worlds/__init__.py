"""The worlds that experiments are made in: changed, imported, or drawn from a seed."""
