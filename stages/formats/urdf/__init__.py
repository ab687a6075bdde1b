"""Reads URDF text as values: links, joints, shapes, transmissions.

- urdf_robot: Converts a robot to the robot that its URDF describes: links merged, loops replaced by mimics.
- chains: Derives from the robot the links and joints of its URDF as a tree, by their names in the URDF.
- contacts: Finds the links of a URDF that do not collide, for writing and checking an SRDF.
- diagnostics: Collects diagnostics of a URDF, by line: errors, and elements that are left out.
- elements: Reads values in a URDF's elements: children, numbers, poses.
- form: How a robot's URDF differs from the robot, as a value that writers and checks share.
- model: URDF values, exactly as in the file.
- names: Chooses names in a URDF for the things of a robot that are extra links and joints there.
- parse: Reads URDF text: all of URDF 1.0, and what later readers add to it (capsules, ros2_control, ...).
- shapes: Reads the visuals, collisions and materials of a URDF.
- srdf_form: Defines the content that only an SRDF has.
- transmission_counts: Changes the values in a <transmission> or <ros2_control> whose joints get another zero
  or sign.
- transmissions: Reads the transmissions of a URDF, of either style, and the joints of its ros2_control.
"""
