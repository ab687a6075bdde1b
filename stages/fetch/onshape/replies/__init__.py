"""Replies of a server: reads, checks and stores them."""
