"""The context of a stage: files, and values that are decoded only where they are needed."""

import functools
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.caching.actions import Action, Cache, Files
from pipeline.element_files import element_texts
from stages.robot import codec
from stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from pipeline.config.plan import Plan
    from stages.export.writer import Exported
    from stages.fetch.source import Calls
    from stages.formats.mjcf_form import MjcfForm
    from stages.formats.urdf.form import UrdfForm
    from stages.robot.actuation import Actuation
    from stages.robot.amendments import Amendments
    from stages.robot.bundle import Bundle
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot
    from stages.robot.scene import Scene
    from stages.robot.sensing import Sensing

NOTES = "notes.json"
ROBOT = "robot.json"
ACTUATION = "actuation.json"
FORM = "form.json"
MJCF_FORM = "mjcf_form.json"
SENSING = "sensing.json"
AMENDMENTS = "amendments.json"
SCENE = "scene.json"
FILES = "files/"
"""The folder of the files that the export stage writes for the user."""


class BuildContext:
    """The context of a stage: the plan, the files of earlier stages, and the cache.

    `calls` counts the API calls of this build (as `Report.calls`). `detail` shows and logs a line about
    the work of the stage; `transient` shows a line that the next line replaces. `ledger`: the folder with
    the recorded calls of all builds, or None; `began`: the start [s since the epoch] of the sweep that
    this build is a job of.
    """

    def __init__(
        self,
        plan: "Plan",
        cache: Cache,
        environ: Mapping[str, str],
        detail: Callable[[str], None] = lambda _: None,
        ledger: Path | None = None,
        began: float | None = None,
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
        self.began = began
        self.import_ahead: Callable[[], None] = lambda: None
        """Called by a stage that waits for the network when it knows that the later stages will run."""
        self.require_room: Callable[[], None] = lambda: None
        """Called by a stage before it spends API calls: raises where a disk has no room for the replies."""
        self.calls: dict[str, Any] = {"made": 0, "saved": 0}

    def digests(self, stage: str) -> dict[str, str]:
        """The digests of an earlier stage's result, without its notes."""
        found = self.files[stage].digests
        return {f"{stage}/{path}": digest for path, digest in found.items() if path != NOTES}

    @functools.cached_property
    def bundle(self) -> "Bundle":
        return codec.decode_bundle(self.files["fetch"])

    @functools.cached_property
    def robot(self) -> "Robot":
        robot: Robot = codec.decode_robot(self.files["graph"][ROBOT])
        return robot

    @property
    def actuation(self) -> "Actuation":
        """What drives the robot in the exported files."""
        from stages.robot.actuation import Actuation

        return codec.load(Actuation, self.files["export"][ACTUATION])

    @property
    def exported(self) -> "tuple[Actuation, Geometry, UrdfForm, MjcfForm, Sensing, Amendments, Scene]":
        """What drives the robot in the exported files, its shapes, the forms of its URDF and MJCF, what
        measures it, what the user's own XML changed in them, and where they put it."""
        forms = self.form, self.mjcf_form
        return self.actuation, self.shapes, *forms, self.sensing, self.amendments, self.scene

    @property
    def sensing(self) -> "Sensing":
        """What measures the robot in the exported files."""
        from stages.robot.sensing import Sensing

        return codec.load(Sensing, self.files["export"][SENSING])

    @property
    def amendments(self) -> "Amendments":
        """What the user's own XML changed in the exported files."""
        from stages.robot.amendments import Amendments

        return codec.load(Amendments, self.files["export"][AMENDMENTS])

    @property
    def scene(self) -> "Scene":
        """Where the exported files put the robot."""
        from stages.robot.scene import Scene

        return codec.load(Scene, self.files["export"][SCENE])

    @functools.cached_property
    def element_texts(self) -> Mapping[str, str]:
        """The texts of the files that `elements` name, read once in a build."""
        return element_texts(self.plan)

    @property
    def form(self) -> "UrdfForm":
        """How the exported URDF differs from the robot."""
        from stages.formats.urdf.form import UrdfForm

        return codec.load(UrdfForm, self.files["export"][FORM])

    @property
    def mjcf_form(self) -> "MjcfForm":
        """How the exported MJCF differs from the robot."""
        from stages.formats.mjcf_form import MjcfForm

        return codec.load(MjcfForm, self.files["export"][MJCF_FORM])

    @property
    def geometry(self) -> "Geometry":
        """The meshes, decoded at each access: they are large, and only one stage reads them."""
        return codec.decode_geometry(self.files["mesh"])

    @property
    def shapes(self) -> "Geometry":
        """The same without the files of the meshes."""
        return codec.decode_geometry(self.files["mesh"], meshes=False)


def facts(exported: "Exported") -> dict[str, bytes]:
    """What the validate stage needs to know of the exported files."""
    return {
        ACTUATION: codec.dump(exported.actuation),
        FORM: codec.dump(exported.form),
        MJCF_FORM: codec.dump(exported.mjcf_form),
        SENSING: codec.dump(exported.sensing),
        AMENDMENTS: codec.dump(exported.amendments),
        SCENE: codec.dump(exported.scene),
    }


def notes(
    summary: str,
    diagnostics: tuple[Diagnostic, ...] = (),
    figures: Mapping[str, float] | None = None,
    **more: Any,
) -> bytes:
    found = {"summary": summary, "diagnostics": codec.plain(diagnostics), "figures": figures or {}, **more}
    return json.dumps(found, indent=1).encode()


def spent(calls: "Calls") -> dict[str, Any]:
    """The calls of a fetch, as the report has them."""
    spent: dict[str, Any] = {"made": calls.made, "saved": calls.saved}
    if calls.made:
        spent |= {
            "counted_this_year": calls.year,
            "remaining": dict(calls.remaining),
            "served": dict(calls.served),
            "waited": round(calls.waited, 1),
        }
    return spent
