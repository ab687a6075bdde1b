"""Actuators: which dofs are driven, and how strongly.

- actuate: Builds the actuation of a robot from the key `actuators` and the actuators of the source.
- advice: Advises to add actuators to a robot that its own weight moves.
- choices: Chooses the type and parameters of each dof's actuator from the key `actuators`; later entries win.
- gains: Estimates servo gains and armatures from the weight and inertia on a dof, its effort, and the time
  step.
- gravity: Reads the gravity against which actuators hold a robot.
- holding: Computes the forces with which driven dofs hold a robot in each of its keyframes.
- loads: Computes the loads of driven dofs: the forces that hold the weight, and the inertias that they move.
- make: Makes actuators from their parameters, and estimates the parameters that are not set.
- motors: Applies the values of motors from the library to the dofs and actuators that name them.
- ranges: Derives the control range of an actuator that has none from its dof or its motor.
- remarks: Reports dofs that are not driven, and actuators that sag, are too weak or too stiff.
- symmetric_dofs: Gives joints that are copies of each other, such as those of a left and a right leg, the
  same load.
- terms: Writes the MJCF attributes that only some actuator types have.
- versions: Refuses actuator types and parameters that the installed version of MuJoCo does not have.
"""
