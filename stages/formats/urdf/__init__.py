"""URDF text as values: links, joints, shapes, transmissions.

- as_written: The robot that a URDF describes, where its form differs from that of the robot.
- chains: The links and joints of a URDF as a tree, by their names there, as far as the robot says what they
  are.
- contacts: Which links of a URDF do not collide, as far as the robot says: for who writes or checks an SRDF.
- diagnostics: Diagnostics of a URDF, by line: errors, and elements that are left out.
- elements: Values in a URDF's elements: children, numbers, poses.
- form: How a robot's URDF differs from the robot: for who writes and who checks one.
- model: A URDF as a value, exactly as in the file.
- names: What stands in a URDF for what a robot has and URDF has no word for: its names, for who writes and
  who checks one.
- parse: Reads URDF text: all of URDF 1.0, and what later readers add to it (capsules, ros2_control, ...).
- shapes: The visuals, collisions and materials of a URDF.
- srdf_form: What an SRDF says that nothing else of the robot does.
- transmission_counts: Values in a <transmission> or <ros2_control> whose joints are counted anew.
- transmissions: The transmissions of a URDF, of either style, and the joints of its ros2_control.
"""
