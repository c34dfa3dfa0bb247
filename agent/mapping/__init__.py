"""From corners met to nodes, arcs and local maps."""
