"""The robot: the value that every stage hands on, with its inertia, poses, names and kinematics.

- bundle: A bundle: the raw replies that a build reads, pinned and named by their requests.
- check: One check of a built robot: what was measured, against what limit, and where to look.
- codec: Values as bytes and back, exactly: what travels between stages through the cache.
- diagnostics: The sink of diagnostics: what a stage finds on its way, and the errors that stop it, reported
  together.
- errors: Everything that can go wrong, as one tree.
- optional_section: Globs that may match nothing: those of a preset, which several robots share.
- quantity_keys: Keys that are lengths or angles: numbers in SI, or texts with a unit, such as "25 mm" and
  "-90 deg".
- section: The base of every section of the configuration.
"""
