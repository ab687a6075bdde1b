"""Defines the configuration of the SDF writer."""

from typing import Literal

from linkwright.stages.export.configuration.format_section import FormatSection


class SdfFormatSection(FormatSection):
    """The SDF."""

    files = ("<name>.sdf", "model.config")

    meshes: Literal["relative", "model"] = "relative"
    """How the SDF names mesh files. relative: by paths relative to its own folder, wherever that is; model:
    as `model://<name>/assets/...`, for readers that look models up by the names of their folders."""
