"""Actuators: which dofs are driven, and how strongly."""
