"""Text for people and for files: names, globs, numbers with nouns, units."""
