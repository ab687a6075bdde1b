"""Checks that no excluded links touch at `home`, and no links whose contact was not reported."""

from collections.abc import Iterator
from typing import Any

import mujoco

from linkwright.stages.mujoco.names import body_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few
from linkwright.stages.validate.model.coordinates import set_values

MIN_DEPTH = 1e-5
"""Smallest depth [m] of contacts that count: in single precision, coincident faces may or may not touch."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks contact at `home`, except in a URDF, which says nothing about contact."""
    geometry, robot = compiled.geometry, compiled.robot
    if compiled.urdf or geometry is None:
        return
    data = mujoco.MjData(compiled.model)
    set_values(compiled.model, data, robot, home(robot), urdf=False)
    mujoco.mj_collision(compiled.model, data)
    excludes = {(exclude.link_a, exclude.link_b): exclude for exclude in geometry.excludes}
    reported = {(touch.link_a, touch.link_b) for touch in geometry.touching}
    wrong: dict[str, Finding] = {}
    touching_pairs = set()
    for first, first_shape, second, second_shape in _link_contacts(compiled, geometry, data):
        pair = first, second
        exclude = excludes.get(pair)
        touching_pairs.add(pair)
        if exclude is not None and _is_excluded(exclude, first_shape, second_shape):
            text = f"{first} and {second}, which are excluded from contact"
            wrong[text] = _finding(first, second, "touch at home, and must be excluded from contact")
        elif pair not in reported:
            text = f"{first} and {second}, which was not reported"
            wrong[text] = _finding(first, second, "touch at home, which they do not with the robot's shapes")
    detail = (
        f"touching at home: {'; '.join(wrong)}"
        if wrong
        else f"{_pair_text(len(touching_pairs))} at home, as reported"
    )
    findings = few(wrong.values())
    yield compiled.within("contact with itself", float(len(wrong)), 0.0, detail, findings)


def _finding(first: str, second: str, message: str) -> Finding:
    return Finding(f'exclude "{first}" "{second}"', "body1, body2", message)


def _is_excluded(exclude: Exclude, first: int, second: int) -> bool:
    """Tells whether two colliders are excluded, by their positions among those of their links. An exclude
    without geoms is for all colliders of both links."""
    return not exclude.geoms or (first, second) in exclude.geoms


def _pair_text(number: int) -> str:
    return f"{count(number, 'pair')} of links {'touches' if number == 1 else 'touch'}"


def _link_contacts(
    compiled: CompiledModel, geometry: Geometry, data: Any
) -> Iterator[tuple[str, int, str, int]]:
    """Yields the two colliders of each contact between links, in the order of the links: each as its link and
    its position among the link's collision shapes."""
    model = compiled.model
    places: dict[int, tuple[int, str, int]] = {}
    colliders = geometry.by_link()
    for place, link in enumerate(compiled.robot.links):
        body = body_index(model, link.name)
        start = int(model.body_geomadr[body])
        geoms = range(start, start + int(model.body_geomnum[body]))
        solid = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
        # If the root is the world, the ground is one of its geoms.
        number = len(colliders[link.name, "collision"])
        places |= {geom: (place, link.name, position) for position, geom in enumerate(solid[:number])}
    for contact in data.contact[: data.ncon]:
        if contact.dist < -MIN_DEPTH and all(geom in places for geom in contact.geom):
            (_, first, at_first), (_, second, at_second) = sorted(places[geom] for geom in contact.geom)
            yield first, at_first, second, at_second
