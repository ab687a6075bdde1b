"""Limits of dofs: the user's, checks of them, and numbers that stand in for missing limits."""
