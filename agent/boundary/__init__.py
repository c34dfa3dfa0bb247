"""The boundary as it is followed: its trace, and knowing when the robot is round."""
