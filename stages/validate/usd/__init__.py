"""The checks of a USD, read by usd-core."""
