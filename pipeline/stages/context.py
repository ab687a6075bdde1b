"""Gives a stage its context: files, and values that are decoded only when a stage needs them."""

import functools
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.caching.actions import Action, Cache, Files
from linkwright.pipeline.element_files import element_texts
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.pipeline.config.plan import Plan
    from linkwright.stages.fetch.source import Calls, SweepState
    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Robot

NOTES = "notes.json"
ROBOT = "robot.json"
WRITTEN = "written.json"
"""The file of the facts that the export stage adds to the robot and its geometry."""

FILES = "files/"
"""The folder of the files that the export stage writes for the user."""


class BuildContext:
    """The context of a stage: the plan, the files of earlier stages, and the cache.

    `calls` counts the API calls of this build (as `Report.calls`). `detail` shows and logs a line about
    the work of the stage; `transient` shows a line that the next line replaces. `ledger`: the folder with
    the recorded calls of all builds, or None; `sweep`: the state that the fetches of a sweep share.
    """

    def __init__(
        self,
        plan: "Plan",
        cache: Cache,
        environ: Mapping[str, str],
        detail: Callable[[str], None] = lambda _: None,
        ledger: Path | None = None,
        sweep: "SweepState | None" = None,
    ) -> None:
        self.plan = plan
        self.cache = cache
        self.environ = environ
        self.detail = detail
        self.transient: Callable[[str], None] = lambda _: None
        self.files: dict[str, Files] = {}
        self.actions: dict[str, Action] = {}
        """The action of each stage whose result can be kept."""
        self.ledger = ledger
        self.sweep = sweep
        self.import_ahead: Callable[[], None] = lambda: None
        """Called by a stage that waits for the network when it knows that the later stages will run."""
        self.require_room: Callable[[], None] = lambda: None
        """Called by a stage before it spends API calls; raises if a disk has no room for the replies."""
        self.calls: dict[str, Any] = {"made": 0, "saved": 0}

    def digests(self, stage: str) -> dict[str, str]:
        """Returns the digests of an earlier stage's result, without its notes."""
        digests = self.files[stage].digests
        return {f"{stage}/{path}": digest for path, digest in digests.items() if path != NOTES}

    @functools.cached_property
    def bundle(self) -> "Bundle":
        return codec.decode_bundle(self.files["fetch"])

    @functools.cached_property
    def robot(self) -> "Robot":
        robot: Robot = codec.decode_robot(self.files["graph"][ROBOT])
        return robot

    @property
    def written(self) -> "Written":
        """The robot as it is in the exported files, with its shapes but without the files of the meshes."""
        # Late: a stage whose inputs did not change decodes nothing.
        from linkwright.stages.formats.written import decode

        shapes = codec.decode_geometry(self.files["mesh"], meshes=False)
        return decode(self.files["export"][WRITTEN], self.robot, shapes)

    @functools.cached_property
    def element_texts(self) -> Mapping[str, str]:
        """The texts of the files that `elements` name, read once in a build."""
        return element_texts(self.plan)

    @property
    def geometry(self) -> "Geometry":
        """The meshes, decoded at each access: they are large, and only one stage reads them."""
        return codec.decode_geometry(self.files["mesh"])


def notes(
    summary: str,
    diagnostics: tuple[Diagnostic, ...] = (),
    figures: Mapping[str, float] | None = None,
    **entries: Any,
) -> bytes:
    """Returns the notes of a stage as JSON: summary, diagnostics, figures and further `entries`."""
    content = {
        "summary": summary,
        "diagnostics": codec.plain_data(diagnostics),
        "figures": figures or {},
        **entries,
    }
    return json.dumps(content, indent=1).encode()


def call_record(calls: "Calls") -> dict[str, Any]:
    """Returns the API calls of a fetch in the form of `Report.calls`."""
    record: dict[str, Any] = {"made": calls.made, "saved": calls.saved}
    if calls.made:
        record |= {
            "counted_this_year": calls.year,
            "remaining": dict(calls.remaining),
            "served": dict(calls.served),
            "waited": round(calls.waited, 1),
        }
    return record
