"""URDF: the tree of links and joints."""
