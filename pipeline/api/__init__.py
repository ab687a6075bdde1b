"""The functions and classes of `linkwright` for notebooks and scripts.

- arguments: Composes a plan from the arguments of `linkwright.build`, as from a command line.
- building: Defines `build`, which builds a robot, and the `Build` that it returns.
- robot: Defines the `Robot` of a build, with its kinematics and its mass matrix.
"""
