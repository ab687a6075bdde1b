"""Defines the five stages: inputs, context and results of each."""
