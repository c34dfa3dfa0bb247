"""Maps as JSON, GraphML, GeoJSON and ROS maps."""
