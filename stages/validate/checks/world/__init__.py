"""Checks of what surrounds the mechanism: scene, options, keyframes, sensors, actuators.

- actuators: Each actuator drives its dof with its gains and ranges, and each keyframe has its control and its
  state.
- keyframes: The keyframes: the saved pose as `cad`, where loops and relations hold, `home`, and the user's
  own.
- options: The simulation is of a world with weight, contact and joints that hold, in steps that engines bear.
- scene: The scene has the robot of the MJCF as that has it: nothing that the scene says changes it.
- sensors: Each sensor measures what it shall, where it shall, and each camera is where it shall be.
- source_elements: What an MJCF source alone has is in the MJCF and its scene, as MuJoCo compiles both:
  tendons and what acts on them, cameras, lights, attributes, and what lies beside the robot.
- surroundings: The scene is the one that the robot was judged in: its ground, and what MuJoCo is told of
  physics.
"""
