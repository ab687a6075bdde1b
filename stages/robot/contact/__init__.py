"""Contacts: finds the shapes of a robot that are near each other, and the pairs that do not collide."""
