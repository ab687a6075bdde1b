"""What is different between two robots, as their robot.json describe them."""
