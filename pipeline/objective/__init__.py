"""Computes the objective of a robot: the numbers that a search minimizes or maximizes."""
