"""Actuators: which dofs are driven, and how strongly.

- actuate: From the key `actuators`, and the actuators that the source has, to what drives a robot.
- advice: What a user may try with a robot that nothing drives.
- choices: What the key `actuators` says of each dof: types and parameters by glob, later entries first.
- gains: Servo gains and armatures that nobody gave: from the weight and inertia on a dof, what it can do, and
  the time step.
- gravity: The gravity that actuators hold a robot against.
- holding: The forces with which driven dofs hold a robot in each of its keyframes.
- loads: What the driven dofs of a robot must hold and move: forces by its weight, and inertias.
- make: Actuators from what is wanted of them, with what is not given estimated.
- motors: What motors of the library give the dofs that they drive, and their actuators.
- ranges: The range of a control that nobody gave.
- remarks: Diagnostics about what drives a robot.
- symmetric_dofs: Joints that are copies of each other, as those of a left and a right leg: one estimate holds
  for them all.
- terms: The attributes of MJCF that only single types of actuators have, as text.
- versions: What newer MuJoCos have: types and parameters of actuators that the installed one may lack.
"""
