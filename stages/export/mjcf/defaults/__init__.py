"""Default classes of an MJCF."""
