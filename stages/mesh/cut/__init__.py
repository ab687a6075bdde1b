"""Cutting: planes, the two sides of a cut, and what stands out of a piece."""
