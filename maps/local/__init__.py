"""Local maps: a metric and a perceptual SOM of the space around a node."""
