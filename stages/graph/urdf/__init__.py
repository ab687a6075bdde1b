"""The reader of URDF files: a file becomes a mechanism; what is wrong in it is reported or repaired."""
