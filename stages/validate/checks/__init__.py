"""What must hold of the files that were written."""
