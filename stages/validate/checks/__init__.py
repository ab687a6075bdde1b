"""The checks of the written files: one module for each check."""
