"""Checks the robot in simulations.

- control_noise: Checks that the model stays stable under noise over the full range of every control, as in
  the exploration of a learning policy.
- energy: Checks that the robot keeps its energy if nothing dissipates it, as a consistent mechanism does.
- gravity_compensation: Checks that the robot's weight is compensated only as far as its actuators carry it.
- rest: Checks that the robot rests with the controls of `home`: its actuators hold it, and it does not fall
  over.
- time_step: Checks that the model is stable from `home` at half and at double its time step.
- torque: Checks that the actuators can hold the robot's weight, and a payload, over the range of the joints.
- trial: Checks that the model stays finite and stable in a trial run from `home`, with the controls of
  `home`.
- variants: Checks that the variants of the MJCF fit the robot and are physically possible, and simulates a
  sample.
"""
