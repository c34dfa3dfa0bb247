"""What moves the robot: DART, and a kinematic twin of it."""
