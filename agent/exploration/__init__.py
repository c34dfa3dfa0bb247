"""What local exploration keeps: panoramas, and the graph of places they were taken from."""
