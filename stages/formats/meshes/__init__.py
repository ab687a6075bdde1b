"""Mesh files as points and triangles: glTF, DAE, and the files that are written."""
