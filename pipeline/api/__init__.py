"""What `linkwright` offers to notebooks and scripts.

- arguments: `build`'s arguments as a plan.
- building: `build`, and the `Build` that it returns.
- robot: the `Robot` of a build, with its kinematics and dynamics.
"""
