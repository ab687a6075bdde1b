"""Mesh files: OBJ and STL, and their names."""
