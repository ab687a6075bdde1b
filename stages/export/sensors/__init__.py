"""What measures the robot: from the key `sensors` to sensors with their places."""
