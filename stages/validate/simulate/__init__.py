"""Runs compiled models, and computes the forces that hold them."""
