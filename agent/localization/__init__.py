"""Finding out where on a mapped boundary the robot is."""
