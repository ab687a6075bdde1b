"""The five stages: inputs, context and results of each."""
