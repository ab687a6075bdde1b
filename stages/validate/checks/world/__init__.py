"""Checks the surroundings of the mechanism: scene, options, keyframes, sensors and actuators.

- actuators: Checks that each actuator drives its dof with its gains and ranges, and has a control in each
  keyframe.
- keyframes: Checks the keyframes: the saved pose as `cad`, where loops and relations hold, `home`, and the
  user's own.
- options: Checks that gravity, contacts, constraints and actuators are enabled, and that the time step is
  short enough.
- scene: Checks that nothing in the scene changes the robot of the MJCF.
- sensors: Checks that each sensor measures its target at its place, and that each camera is at its place.
- source_elements: Checks that the MJCF and its scene have the elements that only an MJCF source has, as
  MuJoCo compiles both.
- surroundings: Checks that the scene has the ground and the physics options with which the robot was judged.
"""
