"""SDF: links, joints, frames and sensors of a model for Gazebo, with loops as joints.

- bodies: Links of an SDF: their inertia, what is seen of them, and what they collide with.
- build: Writes all files of the format, from what the other modules of this room make of the robot.
- contacts: Which colliders of an SDF collide, by `collide_bitmask`: two do whose masks have a bit in common.
- joints: Joints of an SDF: their place, axis, limits and damping, and what they follow.
- lowering: Lowering: joints and loops of several degrees of freedom as SDF joints of one each, with links of
  next to no mass between them; and the pose in which the links of the SDF stand.
- model: SDF 1.9: the model of a robot, in one file.
- section: Configuration of the SDF writer.
- sensors: Sensors of an SDF: on links those that are mounted, on joints those of their load.
- writer: SDF: the model, and the file by which Gazebo finds it.
"""
