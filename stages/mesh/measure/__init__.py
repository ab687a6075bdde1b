"""Measures: how well pieces stand for a part, as distances and volumes.

Every rung of the ladder, and every figure of a report, is judged by `measure(Target.of(part), pieces)`.

- field: How far places are outside of a part, on a grid over it: worked out once, and then read off for
  thousands of hulls.
- judge: The measures of a collider: samples, then a search for what lies between them.
- samples: Points on surfaces, spread evenly by area, the same for the same surface.
- target: A part made ready to be compared with colliders.
- tree: Triangles in a tree of boxes: exact distances from them, and the largest value of a function on them.
- union: The union of a collider's pieces: what is in it, and how far from it points are.
- volumes: How much a collider has too much and too little, as volumes.
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
