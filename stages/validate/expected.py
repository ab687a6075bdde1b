"""What a file that no engine reads is compared with, besides the robot."""

from dataclasses import dataclass

from stages.formats.urdf.form import AS_IS, UrdfForm
from stages.formats.urdf.srdf_form import SrdfForm
from stages.robot.actuation import NONE, Actuation
from stages.robot.amendments import UNCHANGED, Amendments
from stages.robot.geometry import Geometry
from stages.robot.scene import Scene
from stages.robot.sensing import NOTHING, Sensing


@dataclass(frozen=True, slots=True, eq=False)
class Expected:
    """`actuation`: what drives the robot; `geometry`: its shapes, without their files, None where these are
    unknown; `form`: how the URDF differs from the robot; `amendments`: what the user's own XML changed;
    `scene`: where the files put the robot, None where nothing is known of that; `sensing`: what measures
    it; `srdf`: what is known of its SRDF alone, None for nothing."""

    actuation: Actuation = NONE
    geometry: Geometry | None = None
    form: UrdfForm = AS_IS
    amendments: Amendments = UNCHANGED
    scene: Scene | None = None
    sensing: Sensing = NOTHING
    srdf: SrdfForm | None = None


NOTHING_ELSE = Expected()
"""The robot alone is known."""
