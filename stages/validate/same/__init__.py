"""Compares the robot that the reader of any format returns with the robot as it was written.

- differences: Finds where a file's kinematics differs from the robot's: the first such elements of the tree.
- joints: Compares the type and the numbers of each joint: limits, effort and dynamics.
- loops: Compares the frames that close a loop with the robot's, at values at which no loop is closed.
- masses: Compares the mass, centre of mass and inertia of each link with those of its parts in CAD.
- motion: Compares the places of links and frames: where CAD saved the parts, and where the joints move them.
- names: Compares the names of links, joints and frames with the robot's.
- read_robot: Defines the robot that a format's reader reads from a file, for the comparisons in this package.
- relations: Compares the relations of joints with the robot's, with their numbers.
- shapes: Compares the shapes of each link with the robot's: their number, files, sizes, places and colours.
"""
