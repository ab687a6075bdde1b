"""Where a robot stands: how far it reaches, and what touches the ground."""
