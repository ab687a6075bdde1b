"""The sites and cameras of an MJCF."""
