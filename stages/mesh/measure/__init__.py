"""Measures how well pieces represent a part, as distances and volumes.

Every rung of the ladder, and every figure of a report, is judged by `measure(MeasuredPart.of(part), pieces)`.

- field: Computes the distance from a part on a grid around it: once, to be interpolated for thousands of
  hulls.
- judge: Measures how far a collider is from a part, first at samples, then by a search between the samples.
- samples: Spreads points over surfaces evenly by area, in the same way whenever the surface is the same.
- target: Prepares a part for comparison with colliders.
- tree: Sorts triangles into a tree of boxes, for exact distances and for the largest value of a function on
  them.
- union: Tells whether points are in the union of a collider's pieces, and how far from it they are.
- volumes: Computes the volume of a collider outside its part, and of the part outside the collider.
"""

from linkwright.stages.mesh.measure.judge import QUICK_SAMPLE_COUNT as QUICK_SAMPLE_COUNT
from linkwright.stages.mesh.measure.judge import is_hopeless as is_hopeless
from linkwright.stages.mesh.measure.judge import is_near as is_near
from linkwright.stages.mesh.measure.judge import measure as measure
from linkwright.stages.mesh.measure.judge import outside_part as outside_part
from linkwright.stages.mesh.measure.samples import evenly_spread as evenly_spread
from linkwright.stages.mesh.measure.target import MeasuredPart as MeasuredPart
from linkwright.stages.mesh.measure.tree import BoxTree as BoxTree
from linkwright.stages.mesh.measure.tree import Nearest as Nearest
from linkwright.stages.robot.model.geometry import Measures as Measures
