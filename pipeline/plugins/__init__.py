"""Loads the user's own code, and restricts where it may come from."""
