"""Where the robot is: odometry, the wheels as they are, walls as landmarks."""
