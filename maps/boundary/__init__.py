"""The boundary of a map: the walk along its arcs."""
