"""Writes the file of a new robot from its source, for `linkwright new`.

- choices: Chooses base, actuators and contact of a new robot from what its source shows, with the reasons.
- command: Surveys a source, writes the robot's file, and prints what it found.
- joint_table: Lists the joints of a robot, and what each of them lacks.
- peer_config: Reads a configuration of onshape-to-robot: its source, and the robot's name.
- peer_joints: Converts `joint_properties` of onshape-to-robot to keys of joints and actuators.
- peer_options: Converts the options of onshape-to-robot to keys of a robot's file, or names them.
- robot_file: Writes the text of a new robot's file.
- source_keys: Reads an address or a path as the keys of a source, and chooses the robot's name.
- survey: Reads the mechanism of a source, and finds the problems that end its build.
- yaml_lines: Writes lines of YAML, and comments.
"""
