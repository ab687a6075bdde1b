"""A ROS 2 package: description, ros2_control, controllers and launch files of a robot.

- build: Writes all files of the format, from what the other modules of this room make of the robot.
- control: What ros2_control commands and measures: interfaces of joints, sensors, and the hardware.
- controllers: The controllers of a robot.
- description: The URDF of a ROS 2 package: the robot's own, with paths and names for ROS.
- files: The texts of a ROS 2 package, each from a template.
- moveit: The package by which MoveIt plans for a robot: the SRDF in the names of the ROS package, and what
  goes with its groups and joints.
- names: Names that ROS takes: of packages, links, joints and sensors.
- section: Configuration of the ROS 2 package.
- trajectories: Which joints follow trajectories together: those of an arm, of a gripper, and the others.
- writer: A ROS 2 package: the folder that `colcon build` takes.
- xacro_files: The xacro files of a ROS 2 package: a macro of the robot, one of its ros2_control, and the file
  that robots are made from.
"""
