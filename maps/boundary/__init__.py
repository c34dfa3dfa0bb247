"""The boundaries of a map: walks along its arcs, and where they lie."""
