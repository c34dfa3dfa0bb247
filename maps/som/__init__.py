"""Self-organizing maps: lattices, training, initialization."""
