"""The visual meshes of a link: decimated to what a viewer needs, within a measured error."""
