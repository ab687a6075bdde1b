"""Defines `linkwright.build`, which builds a robot from its configuration and returns it as values."""

import base64
import functools
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.api.arguments import plan_of
from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.terminal.check_text import tally
from linkwright.pipeline.terminal.display import progress_for
from linkwright.stages.robot.codec import decode_robot
from linkwright.stages.show.graph_view.views import PICTURE

if TYPE_CHECKING:
    from linkwright.pipeline.api.robot import Robot


@dataclass(frozen=True, eq=False, repr=False)
class Build:
    """The result of a build."""

    report: Report
    """Status, calls, figures, diagnostics and checks."""
    files: Mapping[str, bytes]
    """The robot's files in memory, relative path → bytes: those of an output folder, without the report and
    the log."""
    encoded: bytes | None
    """The robot as the graph stage encoded it; None if the build stopped earlier."""

    @functools.cached_property
    def robot(self) -> "Robot":
        """The robot: links, joints, poses and mass matrix. Raises LinkwrightError after `until=fetch`."""
        if self.encoded is None:
            raise LinkwrightError(
                "there is no robot: the build ended before the graph stage", "until", "until=graph"
            )
        # Imported late: it imports numpy, which a build needs only if its robot is used.
        from linkwright.pipeline.api.robot import Robot

        return Robot(decode_robot(self.encoded))

    @property
    def assets(self) -> dict[str, bytes]:
        """The files that `<name>.xml` and `scene.xml` name, relative path → bytes, as MuJoCo takes them.

        MuJoCo finds a file by its base name alone, and the packages of `export=ros2` and `export=python` hold
        copies.
        """
        model = f"{self.report.name}.xml"
        return {
            path: data for path, data in self.files.items() if path == model or path.startswith("assets/")
        }

    @property
    def outline(self) -> str:
        """The kinematic tree as text, a line for each link."""
        return "\n".join(self.report.outline)

    def __repr__(self) -> str:
        return f"<linkwright.Build {self._heading()}>"

    def _heading(self) -> str:
        report = self.report
        checks = [tally(report.checks)] if report.checks else []
        parts = [report.status, *checks, f"{len(self.files)} files"]
        return f"{report.heading}: {', '.join(parts)}"

    def _repr_html_(self) -> str:
        """Returns HTML for a notebook: status, kinematic tree and picture."""
        pieces = [f"<p>{escape(self._heading())}</p>"]
        if self.report.outline:
            pieces.append(f"<pre>{escape(self.outline)}</pre>")
        if PICTURE in self.files:
            # As an image, so that no script in it can run.
            data = base64.b64encode(self.files[PICTURE]).decode()
            name = escape(f"links and joints of {self.report.name}")
            style = "background: white; max-width: 100%"
            pieces.append(f'<img alt="{name}" src="data:image/svg+xml;base64,{data}" style="{style}">')
        return "\n".join(pieces)


def build(
    *arguments: str | os.PathLike[str] | Mapping[str, Any],
    output: str | os.PathLike[str] | None = None,
    trust: bool = False,
    plugins: Sequence[str] = (),
    config_dirs: Sequence[str | os.PathLike[str]] = (),
    progress: bool = False,
) -> Build:
    """Builds a robot, as the command `linkwright` does, and returns it.

        linkwright.build("robot=my_arm", "root=free")        overrides, as on the command line
        linkwright.build("robot/my_arm.yaml", "root=free")   the path of a robot's file, and overrides
        linkwright.build({"source": {"kind": "urdf", "path": "arm.urdf"}})      a robot as data

    A mapping holds what a robot's YAML holds. Relative paths are those of the working folder.

    output: the folder that gets the files too; without it, and without the key `output`, the build writes
        only its cache.
    trust: whether a xacro file, which is a program, may run. A robot's file or mapping cannot say so.
    plugins: modules whose classes the robot may name. A robot's file or mapping cannot set them.
    config_dirs: folders that hold `robot/`, besides the working folder.
    progress: whether the stages are shown on stderr while they run.

    Raises ConfigError for problems found before the first stage, and another LinkwrightError for later
    errors. A failed check does not raise: see `report.status` and `report.failed_checks`.
    """
    plan = plan_of(arguments, trust, plugins, output, config_dirs)
    display = None
    if progress:
        display = progress_for(sys.stderr)
    result = build_files(plan, display, in_memory=plan.output is None)
    return Build(result.report, result.files, result.robot)
