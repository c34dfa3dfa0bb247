"""Self-organizing maps, local maps, the hybrid graph and its storage."""
