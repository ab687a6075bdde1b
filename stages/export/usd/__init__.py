"""USD: an articulation of UsdPhysics for Isaac Sim, Isaac Lab and Newton, with attributes of both engines.

- actuator_prims: Writes the actuators of a USD as prims of MuJoCo's own schema.
- bodies: Computes the poses of a USD's rigid bodies, and writes their mass properties in single precision.
- build: Writes all files of the format USD.
- date: Reads the date for a USD's metadata from the environment.
- joint_prims: Writes the joints of a USD as prims: frames, limits, and the attributes from `joint_facts`.
- joints: Converts joints and loops to joints of UsdPhysics: their types, and their frames on both bodies.
- layer: Writes layers of USD, prim by prim; no other module of the export imports `pxr`.
- metadata: Makes SimReady's metadata: what a USD is, who made it, and how large and heavy it is.
- model: Writes the layer of a robot in terms of UsdPhysics (openusd.org, "Rigid Body Physics in USD").
- section: Configuration of the USD writer.
- shapes: Writes the visuals of a link, as instances of meshes, and its colliders.
- writer: Declares the format USD: the robot, and the meshes that it refers to.
"""
