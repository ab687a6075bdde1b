"""Mates: joints, coordinates, limits, and several mates between two bodies."""
