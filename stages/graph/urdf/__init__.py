"""The reader of URDF files: what a file says becomes a mechanism; what it gets wrong is told or mended."""
