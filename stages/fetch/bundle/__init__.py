"""A bundle as one zip file."""
