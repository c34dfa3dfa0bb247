"""What the robot senses: infrared, encoders, camera."""
