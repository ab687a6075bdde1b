"""Physics engines as readers of model files."""
