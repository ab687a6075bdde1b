"""Makes the visual meshes of links, decimated within a measured error."""
