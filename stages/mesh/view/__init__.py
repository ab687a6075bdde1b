"""Draws pictures of links: their visual meshes beside their colliders."""
