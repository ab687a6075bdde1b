"""The robot that is shipped with the package."""
