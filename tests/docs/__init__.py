"""The documentation: its blocks run, its site is whole."""
