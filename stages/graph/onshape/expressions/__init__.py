"""Expressions as designers type them."""
