"""Finding the way: trips over arcs, across open floor and within local maps."""
