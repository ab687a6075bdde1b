"""An SRDF held against the robot and its URDF's names."""
