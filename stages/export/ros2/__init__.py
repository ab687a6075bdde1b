"""A ROS 2 package: description, ros2_control, controllers and launch files of a robot."""
