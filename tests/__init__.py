"""Tests of the pipeline, and the local Onshape they run against."""
