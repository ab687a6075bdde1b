"""Masses and forces: inertia, mass matrix, statics, and what holds a robot.

- driven: The robot as it is built: with what its motors give the dofs, and the armatures that were added.
- fused_geometry: The shapes of a robot whose links on fixed joints are part of others.
- fusing: Links on fixed joints as part of the links above them: one rigid body, and no motion lost.
- holding_control: The control and the state with which an actuator holds a pose.
- inertia: Moving and merging inertias, and those of solids of even density.
- mass_matrix: The robot's own dynamics: its mass matrix at any configuration.
- measuring: The sensors that a robot has with what drives it.
- passive: The joints that nothing drives: neither an actuator, nor a relation.
- statics: The forces that hold a robot's weight, at many configurations at once.
"""
