"""A compiled model in motion: how it is run, and what holds it."""
