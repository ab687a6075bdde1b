"""Contact of the robot with itself: which of its links do not collide, and which touch where it starts."""
