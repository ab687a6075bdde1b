"""USD: an articulation of UsdPhysics for Isaac Sim, Isaac Lab and Newton, with attributes of both engines."""
