"""At `home` nothing of the robot touches itself that is excluded from contact, or that was not reported."""

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

DEEP = 1e-5
"""Contacts are looked at that are deeper [m]: in single precision faces that lie on each other are in contact
or not."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """URDF says nothing of contact."""
    geometry, robot = compiled.geometry, compiled.robot
    if compiled.urdf or geometry is None:
        return
    data = mujoco.MjData(compiled.model)
    set_values(compiled.model, data, robot, home(robot), urdf=False)
    mujoco.mj_collision(compiled.model, data)
    excludes = {(one.link_a, one.link_b): one for one in geometry.excludes}
    reported = {(one.link_a, one.link_b) for one in geometry.touching}
    wrong: dict[str, Finding] = {}
    met = set()
    for one, first, other, second in _contacts(compiled, geometry, data):
        pair = one, other
        exclude = excludes.get(pair)
        met.add(pair)
        if exclude is not None and _meant(exclude, first, second):
            text = f"{one} and {other}, which are excluded from contact"
            wrong[text] = _finding(one, other, "touch at home, and must be excluded from contact")
        elif pair not in reported:
            text = f"{one} and {other}, which was not reported"
            wrong[text] = _finding(one, other, "touch at home, which they do not with the robot's shapes")
    detail = f"touching at home: {'; '.join(wrong)}" if wrong else f"{_pairs(len(met))} at home, as reported"
    findings = few(wrong.values())
    yield compiled.within("contact with itself", float(len(wrong)), 0.0, detail, findings)


def _finding(one: str, other: str, message: str) -> Finding:
    return Finding(f'exclude "{one}" "{other}"', "body1, body2", message)


def _meant(exclude: Exclude, first: int, second: int) -> bool:
    return not exclude.geoms or (first, second) in exclude.geoms


def _pairs(number: int) -> str:
    return f"{count(number, 'pair')} of links {'touches' if number == 1 else 'touch'}"


def _contacts(compiled: CompiledModel, geometry: Geometry, data: Any) -> Iterator[tuple[str, int, str, int]]:
    """The colliders of two links that are in contact: of each, in the order of the links, its link and its
    position among the link's collision shapes."""
    model = compiled.model
    known: dict[int, tuple[int, str, int]] = {}
    colliders = geometry.by_link()
    for place, link in enumerate(compiled.robot.links):
        body = body_index(model, link.name)
        first = int(model.body_geomadr[body])
        every = range(first, first + int(model.body_geomnum[body]))
        solid = [geom for geom in every if model.geom_contype[geom] or model.geom_conaffinity[geom]]
        # Below a root that is the world there is the ground too.
        own = len(colliders[link.name, "collision"])
        known |= {geom: (place, link.name, position) for position, geom in enumerate(solid[:own])}
    for contact in data.contact[: data.ncon]:
        if contact.dist < -DEEP and all(geom in known for geom in contact.geom):
            (_, one, at_one), (_, other, at_other) = sorted(known[geom] for geom in contact.geom)
            yield one, at_one, other, at_other
