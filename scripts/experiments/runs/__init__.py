"""Single runs of the experiments, and the worlds they are made in."""
