"""Code of the user's own, and where it may come from."""
