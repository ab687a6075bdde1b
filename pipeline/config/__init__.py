"""Composes a plan from a command line and YAML files. Only this room and `sweep` import Hydra.

- choices: Choices after composition: the precedence of values, and the default name of the robot.
- compose: Composes plans from a command line.
- grammar: Names and values in the grammar of Hydra's overrides.
- interpolated: Converts texts of interpolations, such as `${oc.env:SPEED,4}`, where the schema needs a number
  or a boolean.
- looking: The output of `--cfg` and `--info`: the configuration, and how it was composed.
- messages: Messages about errors of a configuration: the full key, the given value, the allowed values.
- motor_library: The motors that `actuators` names: read when a plan is made, and part of it, so that a cached
  result knows what their files held.
- optional: The key `optional` of a configuration: globs that may match nothing.
- overrides: Converts overrides as the user types them to overrides for Hydra.
- page_section: Configuration of the page about a build, `report.html`, and of the robot's picture.
- partial: Composes an invalid configuration as far as possible, so that all errors are reported in one run.
- plain: Composed trees as plain data.
- plan: The whole configuration as one frozen value.
- presets: The YAML files that a configuration is composed from: ours in `conf`, and the user's own.
- schema: The schema of a key: its section, its type, its names.
"""
