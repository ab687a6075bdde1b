"""Cuts surfaces by planes, and measures how far the pieces of a collider stand out."""
