"""URDF: the tree of links and joints, in one file."""
