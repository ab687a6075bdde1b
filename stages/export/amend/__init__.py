"""Amendments: adds the user's own XML to files that are otherwise complete."""
