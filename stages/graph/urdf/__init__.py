"""The reader of URDF files: reads a file into a mechanism; reports or repairs its errors."""
