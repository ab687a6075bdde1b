"""A URDF on this computer, and the meshes that it names, as a bundle."""
