"""URDF text as values: links, joints, shapes, transmissions."""
