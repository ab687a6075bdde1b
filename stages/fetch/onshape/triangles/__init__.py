"""The triangles of part studios: how they are requested and read."""
