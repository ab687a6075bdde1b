"""Measures: how well pieces stand for a part, as distances and volumes.

Every rung of the ladder, and every figure of a report, is judged by `measure(Target.of(part), pieces)`.
"""

from linkwright.stages.mesh.measure.judge import FEW as FEW
from linkwright.stages.mesh.measure.judge import hopeless as hopeless
from linkwright.stages.mesh.measure.judge import measure as measure
from linkwright.stages.mesh.measure.judge import near as near
from linkwright.stages.mesh.measure.judge import outside_part as outside_part
from linkwright.stages.mesh.measure.samples import even as even
from linkwright.stages.mesh.measure.target import Target as Target
from linkwright.stages.mesh.measure.tree import BoxTree as BoxTree
from linkwright.stages.mesh.measure.tree import Nearest as Nearest
from linkwright.stages.robot.model.geometry import Measures as Measures
