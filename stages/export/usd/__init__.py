"""USD: an articulation of UsdPhysics for Isaac Sim, Isaac Lab and Newton, with attributes of both engines.

- bodies: Rigid bodies of a USD: where their links stand, and their mass properties in single precision.
- build: Writes all files of the format, from what the other modules of this room make of the robot.
- joint_prims: Joints of a USD as prims: frames, limits, and what `joint_facts` has.
- joints: Joints and loops as joints of UsdPhysics: which type, and where their frames are on both bodies.
- layer: Layers of USD, written prim by prim: the only module that imports `pxr`.
- model: USD: the layer of a robot, as UsdPhysics has it (openusd.org, "Rigid Body Physics in USD"), with what
  only PhysX or only Newton knows in their own attributes (`physx...`, `newton:...`; of joints PhysX's of both
  its older and its newer schema).
- section: Configuration of the USD writer.
- shapes: What a link looks like, as instances of meshes, and what it collides with.
- writer: USD: the robot, and the meshes that it refers to.
"""
