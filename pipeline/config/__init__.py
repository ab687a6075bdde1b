"""Composes a plan from a command line and YAML files. Only this room and `sweep` import Hydra."""
