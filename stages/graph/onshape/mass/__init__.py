"""Masses of parts: CAD's, the user's, or estimated."""
