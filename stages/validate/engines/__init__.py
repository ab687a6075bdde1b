"""Physics engines as readers of model files: one module an engine."""
