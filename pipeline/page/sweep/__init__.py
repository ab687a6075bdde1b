"""Renders summary.html: the jobs of a sweep, in a table and in plots."""
