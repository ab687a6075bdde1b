"""Writes mesh files, OBJ and STL, and names them."""
