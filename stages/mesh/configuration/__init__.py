"""Configuration of colliders and contact, and what the makers of colliders are told of it."""
