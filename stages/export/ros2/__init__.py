"""A ROS 2 package: description, ros2_control, controllers and launch files of a robot.

- build: Writes all files of the format ROS 2, and those of MoveIt's package.
- control: Determines the content of ros2_control: interfaces of joints, sensors, and the hardware.
- controllers: Chooses the controllers of a robot.
- description: Makes the URDF of a ROS 2 package: the robot's URDF, with paths and names for ROS.
- files: Fills the templates of a ROS 2 package: launch files, parameters, `package.xml` and others.
- moveit: Writes the package by which MoveIt plans for a robot: the SRDF in the names of the ROS package, and
  settings of its groups and joints.
- names: Makes names that ROS accepts: of packages, links, joints and sensors.
- section: Defines the configuration of the ROS 2 package.
- trajectories: Groups the joints that follow trajectories together: those of each arm, of each gripper, and
  the others.
- writer: Declares the format ROS 2: a folder that `colcon build` accepts.
- xacro_files: Writes the xacro files of a ROS 2 package: a macro of the robot, one of its ros2_control, and
  the file that instantiates them.
"""
