"""Defines an MJCF as a value: the model, its joints, its controls, its form, its bounds."""
