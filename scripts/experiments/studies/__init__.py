"""Studies beyond the thesis: variants, ablation, drawn rooms, unknown starts and changed worlds."""
