"""The files of a configuration: what they may hold, and which folders they may name."""
