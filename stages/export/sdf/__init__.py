"""SDF: links, joints, frames and sensors of a model for Gazebo, with loops as joints.

- bodies: Writes the links of an SDF: inertials, visuals and colliders.
- build: Writes all files of the format SDF.
- contacts: Chooses masks (`collide_bitmask`) for colliders of an SDF: two collide if their masks have a bit
  in common.
- joints: Writes the joints of an SDF: pose, axis, limits, damping, and the joint that they follow.
- lowering: Converts joints and loops of several degrees of freedom to chains of SDF joints and almost
  massless links, and chooses the pose in which the links of the SDF stand.
- model: Writes the model of a robot as SDF 1.9, in one file.
- section: Defines the configuration of the SDF writer.
- sensors: Writes the sensors of an SDF: force and torque sensors on joints, all others on links.
- writer: Declares the format SDF: the model, and the file by which Gazebo finds it.
"""
