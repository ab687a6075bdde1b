"""Reading files that may be anything: which, how large, and where in them something is."""
