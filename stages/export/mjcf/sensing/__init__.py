"""The sites and cameras of sensors in an MJCF."""
