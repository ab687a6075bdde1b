"""HTML: the document around a page, its style, its templates, and what fills them."""
