"""Reads robot.json back as the robot and all else that files are checked against."""
