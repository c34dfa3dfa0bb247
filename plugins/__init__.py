"""Discovery and checking of behaviors."""
