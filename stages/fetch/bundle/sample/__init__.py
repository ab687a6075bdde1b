"""Provides the robots of the gallery, which are shipped with the package."""
