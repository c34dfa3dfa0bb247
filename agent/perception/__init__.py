"""What the infrared sensors and the camera say of the walls around the robot."""
