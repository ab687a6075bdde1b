"""Measures: how well pieces stand for a part, as distances and volumes.

Every rung of the ladder, and every figure of a report, is judged by `measure(Target.of(part), pieces)`.
"""

from stages.mesh.measure.judge import FEW as FEW
from stages.mesh.measure.judge import hopeless as hopeless
from stages.mesh.measure.judge import measure as measure
from stages.mesh.measure.judge import near as near
from stages.mesh.measure.judge import outside_part as outside_part
from stages.mesh.measure.samples import even as even
from stages.mesh.measure.target import Target as Target
from stages.mesh.measure.tree import BoxTree as BoxTree
from stages.mesh.measure.tree import Nearest as Nearest
from stages.robot.geometry import Measures as Measures
