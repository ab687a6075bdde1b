"""Checks of the robot as it is simulated.

- control_noise: The model stays whole under noise over the full range of every control: the search of a
  learning policy.
- energy: The robot keeps its energy where nothing takes any: its masses, inertias and joints make one
  mechanism.
- gravity_compensation: No weight is taken off the robot but what its actuators carry.
- rest: With the controls of `home`, the robot stays there: its actuators hold it, and it does not fall over.
- time_step: The model stays whole from `home` at half its time step, and at double: it does not owe that to
  its step.
- torque: Each joint holds the robot's weight over its range, with a payload if one is given, with what drives
  it.
- trial: The model stays whole and finite in a trial run from `home`, with the controls there, at its time
  step.
"""
