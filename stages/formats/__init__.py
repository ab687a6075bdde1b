"""Text to value and back, without policy: URDF, MJCF, XML, glTF, numbers, units, triangles."""
