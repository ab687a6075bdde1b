"""Configuration of the fetch stage: the source of the robot."""

from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Discriminator, Tag

from linkwright.stages.fetch.bundle.sample.section import SampleSourceSection
from linkwright.stages.fetch.bundle.section import BundleSourceSection
from linkwright.stages.fetch.mjcf.section import MjcfSourceSection
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.source_section import SourceSection
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.robot.section import Section

SOURCES: dict[str, type[SourceSection]] = {
    "onshape": OnshapeSourceSection,
    "urdf": UrdfSourceSection,
    "mjcf": MjcfSourceSection,
    "bundle": BundleSourceSection,
    "sample": SampleSourceSection,
}
"""Kind of source → its keys."""


def _kind(source: Any) -> Any:
    return source.get("kind") if isinstance(source, dict) else getattr(source, "kind", None)


if TYPE_CHECKING:
    AnySource = SourceSection
else:
    AnySource = Annotated[
        Union[tuple(Annotated[keys, Tag(kind)] for kind, keys in SOURCES.items())],  # noqa: UP007
        Discriminator(_kind),
    ]


class FetchSections(Section):
    """The fetch stage's part of the configuration."""

    source: AnySource
    """Source of the robot."""
