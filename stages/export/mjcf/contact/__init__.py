"""Which geoms of an MJCF collide."""
