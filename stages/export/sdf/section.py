"""Configuration of the SDF writer."""

from typing import Literal

from linkwright.stages.robot.section import Section


class SdfFormatSection(Section):
    """The SDF."""

    meshes: Literal["relative", "model"] = "relative"
    """How the SDF names mesh files. relative: by paths relative to its own folder, wherever that lies; model:
    as `model://<name>/assets/...`, for readers that look models up by the names of their folders."""


SECTION = SdfFormatSection
"""The section of the configuration."""
