"""Checks that the engines of `target` take the files, by the rows of `stages.targets.readers`.

- build: Checks the files of a build for each of its targets.
- geom_pairs: Finds the geoms of a compiled model that may touch.
- judge: Checks a file for an engine: which of the things in the file the engine does not take.
- model_things: Finds, in a compiled model, the things that engines do not take, by the elements of its file.
- text_things: Finds, in the text of a URDF, an MJCF or an SDF, the things that readers do not take.
"""
