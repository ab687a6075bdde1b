"""Configuration of what is exported beside the robot's mechanism."""
