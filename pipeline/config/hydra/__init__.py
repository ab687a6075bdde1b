"""Hydra: its files, its loader, its errors, its own node."""
