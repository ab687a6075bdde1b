"""Stability: what the simulation needs to hold a robot at its time step."""
