"""What must hold of the files that were written: one module a check."""
