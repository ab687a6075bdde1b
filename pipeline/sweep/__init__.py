"""Sweeps: many plans from one command line, each built into its own folder."""
