"""Composes a plan from a command line and YAML files. Only this room and `sweep` import Hydra.

- choices: Resolves a composed tree: command line over robot file, chosen formats and targets, default name.
- compose: Composes plans from a command line.
- grammar: Writes names and values in the grammar of Hydra's overrides.
- interpolated: Converts texts of interpolations, such as `${oc.env:SPEED,4}`, where the schema needs a number
  or a boolean.
- looking: Produces the output of `--cfg` and `--info`: the configuration, and how it was composed.
- messages: Describes errors of a configuration: the full key, the given value, the allowed values.
- motor_library: Reads the motors that `actuators` names, and makes them part of the plan.
- objective_section: Configuration of the objective: what a search minimizes or maximizes.
- optional: Adds to the key `optional` of a configuration: globs that may match nothing.
- overrides: Converts overrides as the user types them to overrides for Hydra.
- page_section: Configuration of the page about a build, `report.html`, and of the robot's picture.
- partial: Composes an invalid configuration as far as possible, so that all errors are reported in one run.
- plain: Converts composed trees to plain data.
- plan: Defines the whole configuration as one frozen value.
- presets: Finds the YAML files that a configuration is composed from: in `conf`, and in the user's folders.
- schema: Looks up keys in the schema: their section, their type, their names.
"""
