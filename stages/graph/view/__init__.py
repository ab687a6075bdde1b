"""The robot as people read it: an outline, tables, and a picture."""
