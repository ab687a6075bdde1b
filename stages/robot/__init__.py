"""The robot: the value that every stage hands on, with its inertia, poses, names and kinematics.

- bundle: Describes a bundle: the raw replies that a build reads, pinned and named by their requests.
- check: Describes the result of a check of a built robot: the measured value, its limit, and where to look.
- codec: Converts the values that stages pass on through the cache to bytes and back, exactly.
- diagnostics: Collects the diagnostics of a stage, and raises all of its errors together.
- errors: Defines the tree of all errors.
- optional_section: Lists globs that may match nothing: those of a preset, which several robots share.
- quantity_keys: Reads keys that are lengths or angles: numbers in SI, or texts with a unit, such as "25 mm"
  and "-90 deg".
- section: Defines the base of every section of the configuration.
"""
