"""Studies past the thesis: variants, unseen rooms, ablations."""
