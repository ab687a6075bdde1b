"""Writes HTML: the document around a page, its style, its templates, and their values."""
