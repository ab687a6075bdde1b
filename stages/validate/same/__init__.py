"""The comparers: whether what a reader of any format read is the robot as it was written.

- differences: Where a file's kinematics leaves the robot's: the first elements of the tree that are not as
  they must be.
- found: A robot as a file has it: what a reader of a format gives to the checks of `stages.validate.same`.
- joints: Type and numbers of each joint: limits, effort and dynamics; nothing else acts on it.
- loops: What closes a loop is where the robot has it, at values at which nothing is closed.
- masses: Mass, centre of mass and inertia of each link are those of its parts in CAD.
- motion: Links and frames are where the robot has them: where CAD saved its parts, and wherever its joints
  move.
- names: Every link, joint and frame is there by name, and nothing else.
- relations: Each relation of two joints is there, with its numbers, and no other.
- shapes: Each link has the shapes of the robot: as many, of their files and sizes, where they must be, and of
  their colours.
"""
