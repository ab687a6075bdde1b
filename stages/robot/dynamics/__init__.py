"""Masses and forces: inertia, mass matrix, statics, and the controls that hold a robot.

- driven: Gives a robot's dofs the dynamics of its motors, and added armatures.
- fused_geometry: Merges the shapes of links on fixed joints into those of the links that hold them.
- fusing: Fuses links on fixed joints with the links above them, without losing a motion.
- holding_control: Computes the control and the state with which an actuator holds a pose.
- inertia: Moves, merges and checks inertias, and computes those of solids of even density.
- mass_matrix: Computes the robot's mass matrix at any configuration.
- measuring: Selects the sensors of a robot that its actuators allow.
- passive: Finds the joints that neither an actuator nor a relation drives.
- statics: Computes the forces that hold a robot's weight, at many configurations at once.
"""
