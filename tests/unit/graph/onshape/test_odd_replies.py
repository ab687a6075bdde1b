"""Replies that are not as they should be: one error that says where, or what was left out; never less."""

import json
import random
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import AssemblyError, LinkwrightError, ProtocolError
from linkwright.stages.robot.model.robot import Robot
from tests.fake_onshape.document import ORIGIN, Occurrence
from tests.fake_onshape.frames import frame
from tests.support.building import bundle_of, plan_of
from tests.support.kit import OFF, ON, SIDE, TOP, Kit
from tests.unit.graph.onshape.test_limits import arm_replies, recorded

GONE = object()
VALUES = (GONE, None, "x", [], {}, -1, 1e9, True)


@pytest.fixture
def kit() -> Kit:
    return Kit()


def arm(kit: Kit) -> tuple[Occurrence, Occurrence]:
    """A base with an arm on a hinge."""
    base, one = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (one, ON), (base, SIDE), limits=(-1, 1))
    return base, one


def rich(kit: Kit) -> Bundle:
    """A bundle with something of every kind that a definition can hold."""
    root = kit.root
    base = kit.place("Base", fixed=True)
    leg = kit.document.assembly("Leg")
    thigh, foot = kit.place("Thigh", leg), kit.place("Foot", leg)
    leg.revolute("Knee", (foot, OFF), (thigh, ON), value=0.2, limits=(-1, 1))
    leg.connector("tip", foot, TOP)
    hips = []
    for number, side in enumerate((ON, TOP)):
        hips.append(root.add(leg))
        ends = (hips[-1] / thigh, OFF), (base, side)
        root.revolute(f"Hip {number}", *ends, value=0.3 - 0.6 * number, limits=(-1, 1))
    root.gear("Gear", root.features[0], root.features[1])
    wheel = kit.place("Wheel")
    root.cylindrical("Axle", (wheel, OFF), (base, SIDE), value=(0.01, 0.02), limits=((-1, 1), (None, 1)))
    root.pattern("Row", [wheel], [frame((0, 0.3, 0))])
    root.mirror("Twin", [hips[0]], frame((0.5, 0, 0), x=(0, 1, 0), z=(1, 0, 0)))
    root.ball("Socket", (kit.place("Head"), OFF), (base, ON), limits=1.0)
    root.group("Group", [(base, np.eye(4)), (kit.place("Screw"), TOP)])
    root.connector("link_body", base, TOP)
    return bundle_of(kit.document)


def places(node: Any, at: tuple = ()) -> Iterator[tuple]:
    """The way to every value in a JSON tree."""
    inside = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in inside:
        yield (*at, key)
        yield from places(value, (*at, key))


def changed(tree: Any, at: tuple, value: object) -> bytes:
    tree = deepcopy(tree)
    *above, last = at
    node = tree
    for key in above:
        node = node[key]
    if value is GONE:
        del node[last]
    else:
        node[last] = value
    return json.dumps(tree).encode()


def with_body(bundle: Bundle, digest: str, body: bytes) -> Bundle:
    return replace(bundle, blobs={**bundle.blobs, digest: body})


def is_sound(robot: Robot) -> bool:
    """Whether all numbers are finite and all frames rigid."""
    poses = np.array([joint.parent_from_joint for joint in robot.joints])
    rotations = poses[:, :3, :3]
    numbers = [array for link in robot.links for array in (link.inertial.com, link.inertial.inertia)]
    return bool(
        all(np.isfinite(one).all() for one in (poses, *numbers))
        and np.allclose(rotations @ rotations.transpose(0, 2, 1), np.eye(3), atol=1e-5)
    )


def hurt(bundle: Bundle, digest: str, times: int) -> None:
    """Breaks a reply in so many ways, one at a time: each is refused, or gives a sound robot."""
    tree = json.loads(bundle.body(digest))
    every = [(at, value) for at in places(tree) for value in VALUES]
    for at, value in random.Random(0).sample(every, min(times, len(every))):
        try:
            robot = build_robot(with_body(bundle, digest, changed(tree, at, value)), plan_of())
        except LinkwrightError:
            continue
        except Exception as error:
            raise AssertionError((at, value)) from error
        assert is_sound(robot), (at, value)


@pytest.mark.slow
def test_a_definition_broken_anywhere_is_refused_or_understood(kit: Kit) -> None:
    bundle = rich(kit)
    hurt(bundle, bundle.definition, 500)


@pytest.mark.slow
def test_mass_properties_broken_anywhere_are_refused_or_understood(kit: Kit) -> None:
    bundle = rich(kit)
    hurt(bundle, bundle.studios[0].mass[0], 200)


@pytest.mark.slow
def test_features_and_variables_broken_anywhere_are_refused_or_understood() -> None:
    bundle = recorded(*arm_replies())
    for features in bundle.features:
        for digest in filter(None, (features.features, features.variables)):
            hurt(bundle, digest, 300)


def edited(bundle: Bundle, at: tuple, value: object) -> Bundle:
    return with_body(
        bundle, bundle.definition, changed(json.loads(bundle.body(bundle.definition)), at, value)
    )


FEATURE = ("rootAssembly", "features", 0)


@pytest.mark.parametrize(
    ("at", "value", "where"),
    [
        (("rootAssembly", "occurrences", 1, "transform", 3), None, "Arm <1>"),
        (("rootAssembly", "occurrences", 1, "transform", 12), 1.0, "Arm <1>"),
        ((*FEATURE, "featureData", "matedEntities", 0, "matedCS", "zAxis", 2), None, ""),
        ((*FEATURE, "featureData", "matedEntities", 0, "matedCS", "zAxis", 2), 2.0, ""),
        ((*FEATURE, "featureData", "matedEntities", 0, "matedCS", "xAxis"), [1.0], ""),
        ((*FEATURE, "featureData", "mateLimits", "limitAxialZMax"), True, ""),
        (("rootAssembly", "instances", 1, "partId"), GONE, "Arm <1>"),
        (("rootAssembly", "features", 0), None, ""),
    ],
)
def test_what_is_no_number_and_no_frame_is_not_taken_for_one(
    kit: Kit, at: tuple, value: object, where: str
) -> None:
    arm(kit)
    with pytest.raises(ProtocolError, match="unknown format") as caught:
        build_robot(edited(bundle_of(kit.document), at, value), plan_of())
    assert caught.value.where == where or not where


def test_features_and_instances_of_one_id_are_refused(kit: Kit) -> None:
    arm(kit)
    bundle = bundle_of(kit.document)
    root = json.loads(bundle.body(bundle.definition))["rootAssembly"]
    for key, what in (
        ("features", "two features have the id"),
        ("instances", "another instance has the same id"),
    ):
        twice = edited(bundle, ("rootAssembly", key), [*root[key], root[key][0]])
        with pytest.raises(ProtocolError, match=what):
            build_robot(twice, plan_of())


def test_a_mate_whose_sides_are_null_is_broken(kit: Kit) -> None:
    arm(kit)
    broken = edited(bundle_of(kit.document), (*FEATURE, "featureData", "matedEntities"), None)
    robot = build_robot(broken, plan_of(root={"disconnected": "weld"}))
    assert ("W-MATE-BROKEN", "Elbow") in [(found.code, found.where) for found in robot.diagnostics]


@pytest.mark.parametrize("centroid", [None, [0.0], [0.0, None, 0.0], {}])
def test_a_mass_without_a_centre_is_refused(kit: Kit, centroid: object) -> None:
    arm(kit)
    bundle = bundle_of(kit.document)
    (digest,) = bundle.studios[0].mass
    tree = json.loads(bundle.body(digest))
    part = next(name for name in tree["bodies"] if name != "-all-")
    body = changed(tree, ("bodies", part, "centroid"), centroid)
    with pytest.raises(ProtocolError, match="mass properties has an unknown format"):
        build_robot(with_body(bundle, digest, body), plan_of())


def test_a_negative_mass_names_the_part(kit: Kit) -> None:
    arm(kit)
    bundle = bundle_of(kit.document)
    (digest,) = bundle.studios[0].mass
    tree = json.loads(bundle.body(digest))
    for part in tree["bodies"].values():
        part["mass"] = [-1.0, -1.0, -1.0]
    with pytest.raises(AssemblyError, match="E-MASS Arm <1>: its mass is -1 kg"):
        build_robot(with_body(bundle, digest, json.dumps(tree).encode()), plan_of())


def test_limits_that_are_not_known_are_reported_for_the_mate_that_stands_for_theirs(kit: Kit) -> None:
    base, one = arm(kit)
    kit.root.revolute("Second", (one, ON), (base, SIDE), limits=(-0.5, 0.5), redundant=True)
    at = ("rootAssembly", "features", 1, "featureData", "mateLimits")
    robot = build_robot(edited(bundle_of(kit.document), at, GONE), plan_of())
    (told,) = [found for found in robot.diagnostics if found.code == "W-LIMIT"]
    assert told.where == "elbow"
    assert "Second" in told.message


def test_a_connector_that_would_name_the_origin_is_reported(kit: Kit) -> None:
    one = kit.place("Arm")
    kit.root.revolute("Elbow", (one, ON), (ORIGIN, SIDE), limits=(-1, 1))
    kit.root.connector("link_ground", ORIGIN, np.eye(4))
    robot = build_robot(bundle_of(kit.document), plan_of())
    assert [link.name for link in robot.links] == ["world", "arm"]
    assert [(one.code, one.where) for one in robot.diagnostics] == [("W-NAME", "link_ground")]


def test_a_very_long_name_still_names_a_file(kit: Kit) -> None:
    base = kit.place("Base", fixed=True)
    for letter in "ab":
        part = kit.root.add(kit.bar("x" * 300 + letter))
        kit.root.revolute("y" * 300 + letter, (part, ON), (base, SIDE), limits=(-1, 1))
    robot = build_robot(bundle_of(kit.document), plan_of())
    assert [link.name for link in robot.links] == ["base", "x" * 80, "x" * 80 + "_2"]
    assert [joint.name for joint in robot.joints] == ["y" * 80, "y" * 80 + "_2"]
