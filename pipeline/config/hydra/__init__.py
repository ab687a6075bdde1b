"""Adapts Hydra: its files, its loader, its errors, and its own configuration."""
