"""Passes from one mechanism or robot to the next: names, masses, limits, relations, added links."""
