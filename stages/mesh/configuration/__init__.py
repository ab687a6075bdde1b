"""Defines the configuration of colliders and contact, and the settings that collider makers get from it."""
