"""The placement of a robot in the scene: its extents, and its contacts with the ground."""
