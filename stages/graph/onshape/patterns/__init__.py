"""Patterned and mirrored instances: the motion of each copy."""
