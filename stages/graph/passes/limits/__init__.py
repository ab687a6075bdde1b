"""Limits of dofs: the user's, checks of them, and placeholders for missing limits."""
