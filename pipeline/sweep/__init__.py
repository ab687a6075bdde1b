"""Many plans from one command line, each built into a folder of its own."""
