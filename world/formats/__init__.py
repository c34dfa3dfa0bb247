"""Reading worlds: our YAML, ROS maps, mazes, Webots arenas."""
