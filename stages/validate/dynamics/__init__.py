"""The robot's dynamics, and what the engines find of it."""
