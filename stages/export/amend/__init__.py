"""Amendments: the user's own XML, in files that are otherwise complete."""
