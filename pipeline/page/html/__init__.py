"""HTML: the document around a page, its style, and its pieces."""
