"""Which shapes of a robot are near each other, and which pairs do not collide."""
