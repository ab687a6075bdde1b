"""Configuration of the page about a build, `report.html`, and of the robot's picture."""

from typing import Annotated, Literal

from pydantic import Field

from linkwright.stages.robot.section import Count, Section, example

MOST_FACES = 1_000_000
"""Largest value of `faces`: a page with more triangles is too large to open or to send."""


class PageSection(Section):
    """The page about the build, in which the robot moves, and the robot's picture."""

    live: Literal["whole", "shared", "kinematics"] = "whole"
    """How the robot simulates in `report.html`. whole: the physics engine is in the file, which needs nothing
    else; shared: the engine is `linkwright-engine.js` beside the page, a single file for all jobs of a sweep;
    kinematics: no engine, only sliders move the robot, and the file is small."""

    faces: Annotated[Count, Field(le=MOST_FACES), example(50_000)] = 200_000
    """Largest number of triangles that the page shows of the robot's visual meshes, and of its colliders. If
    there are more, the page shows simplified copies, and says so; small parts lose triangles first. The
    exported meshes stay as they are."""

    preview: Literal["png", "turn", "none"] = "png"
    """The picture of the robot. png: `preview.png`; turn: also `preview.webp`, in which it turns; none: no
    picture."""
