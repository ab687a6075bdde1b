"""Reads the triangles of part studios, and assigns them to parts."""
