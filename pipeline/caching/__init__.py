"""Caches results: a result is reused while its inputs are the same."""
