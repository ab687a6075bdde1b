"""Defines the configuration of everything that is exported besides the robot's mechanism.

- actuator_section: Defines the configuration `actuators`: the actuators of the dofs that a glob matches.
- element_section: Defines the configuration `elements` and `attributes`: the user's own XML in the exported
  files.
- format_section: Defines the base of the configurations of all formats.
- motor_section: Defines the configuration `motors`: the values of a motor, with the source of each.
- mujoco_section: Defines the configuration of MuJoCo's own settings.
- scene_section: Defines the configuration of the world around the robot: `ground` and `scene`.
- sensor_section: Defines the configuration `sensors`: the robot's sensors by name.
- variant_section: Defines the configuration `variants`: robots that differ a little from the robot, for
  learning.
"""
