"""Replies that are not as they should be: one error that says where, or what was left out; never less."""

import json
import random
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.errors import AssemblyError, LinkwrightError, ProtocolError
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import frame
from tests.support.building import bundle_of, plan_of
from tests.support.kit import OFF, ON, SIDE, TOP
from tests.support.reported import only, reports
from tests.unit.graph.onshape.test_limits import arm_replies, recorded

GONE = object()
VALUES = (GONE, None, "x", [], {}, -1, 1e9, True)


def rich(kit):
    """A bundle with something of every kind that a definition can hold."""
    root = kit.root
    base, wheel, head, screw = kit.based("Wheel", "Head", "Screw")
    leg = kit.document.assembly("Leg")
    thigh, foot = kit.place("Thigh", leg), kit.place("Foot", leg)
    leg.revolute("Knee", (foot, OFF), (thigh, ON), value=0.2, limits=(-1, 1))
    leg.connector("tip", foot, TOP)
    hips = [root.add(leg), root.add(leg)]
    for number, (hip, side) in enumerate(zip(hips, (ON, TOP), strict=True)):
        ends = (hip / thigh, OFF), (base, side)
        root.revolute(f"Hip {number}", *ends, value=0.3 - 0.6 * number, limits=(-1, 1))
    root.gear("Gear", root.features[0], root.features[1])
    root.cylindrical("Axle", (wheel, OFF), (base, SIDE), value=(0.01, 0.02), limits=((-1, 1), (None, 1)))
    root.pattern("Row", [wheel], [frame((0, 0.3, 0))])
    root.mirror("Twin", [hips[0]], frame((0.5, 0, 0), x=(0, 1, 0), z=(1, 0, 0)))
    root.ball("Socket", (head, OFF), (base, ON), limits=1.0)
    root.group("Group", [(base, np.eye(4)), (screw, TOP)])
    root.connector("link_body", base, TOP)
    return bundle_of(kit.document)


def places(node, at=()):
    """The way to every value in a JSON tree."""
    inside = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in inside:
        yield (*at, key)
        yield from places(value, (*at, key))


def changed(tree, at, value):
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


def with_body(bundle, digest, body):
    return replace(bundle, blobs={**bundle.blobs, digest: body})


def is_sound(robot):
    """Whether all numbers are finite and all frames rigid."""
    poses = np.array([joint.parent_from_joint for joint in robot.joints])
    rotations = poses[:, :3, :3]
    numbers = [array for link in robot.links for array in (link.inertial.com, link.inertial.inertia)]
    return bool(
        all(np.isfinite(number).all() for number in (poses, *numbers))
        and np.allclose(rotations @ rotations.transpose(0, 2, 1), np.eye(3), atol=1e-5)
    )


def hurt(bundle, digest, times):
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
@pytest.mark.parametrize(("reply", "times"), [("definition", 500), ("masses", 200), ("lists", 300)])
def test_replies_broken_anywhere_are_refused_or_understood(kit, reply, times):
    bundle = recorded(*arm_replies()) if reply == "lists" else rich(kit)
    lists = [digest for f in bundle.features for digest in (f.features, f.variables) if digest]
    masses = bundle.studios[0].mass[:1]
    for digest in {"definition": [bundle.definition], "masses": masses, "lists": lists}[reply]:
        hurt(bundle, digest, times)


def edited(bundle, at, value):
    return with_body(
        bundle, bundle.definition, changed(json.loads(bundle.body(bundle.definition)), at, value)
    )


def reported_of(bundle, **keys):
    """The reports on the robot of a bundle."""
    return reports(build_robot(bundle, plan_of(**keys)))


ROOT, FEATURE = ("rootAssembly",), ("rootAssembly", "features", 0)
DATA = (*FEATURE, "featureData")


@pytest.mark.parametrize(
    ("at", "value", "where"),
    [
        ((*ROOT, "occurrences", 1, "transform", 3), None, "Arm <1>"),
        ((*ROOT, "occurrences", 1, "transform", 12), 1.0, "Arm <1>"),
        ((*ROOT, "occurrences", 0, "transform"), [1.0] * 12, ""), ((*ROOT, "instances"), 7, ""),
        ((*ROOT, "instances", 1, "partId"), GONE, "Arm <1>"), (FEATURE, None, ""), (DATA, None, ""),
        ((*DATA, "mateLimits"), "none", ""), ((*DATA, "mateLimits", "limitAxialZMax"), True, ""),
        ((*DATA, "matedEntities", 0), {}, ""), ((*DATA, "matedEntities", 0, "matedCS", "zAxis", 2), None, ""),
        ((*DATA, "matedEntities", 0, "matedCS", "zAxis", 2), 2.0, ""),
        ((*DATA, "matedEntities", 0, "matedCS", "xAxis"), [1.0], ""),
    ],
)  # fmt: skip
def test_malformed_numbers_and_frames_are_refused(kit, at, value, where):
    kit.elbow(limits=(-1, 1))
    with pytest.raises(ProtocolError, match="unknown format") as caught:
        reported_of(edited(bundle_of(kit.document), at, value))
    assert caught.value.where == where or not where


def test_features_and_instances_of_one_id_are_refused(kit):
    kit.elbow()
    bundle = bundle_of(kit.document)
    root = json.loads(bundle.body(bundle.definition))["rootAssembly"]
    for key, message in (
        ("features", "two features have the id"),
        ("instances", "another instance has the same id"),
    ):
        with pytest.raises(ProtocolError, match=message):
            reported_of(edited(bundle, (*ROOT, key), [*root[key], root[key][0]]))


def test_a_mate_whose_sides_are_null_is_broken(kit):
    kit.elbow()
    broken = edited(bundle_of(kit.document), (*DATA, "matedEntities"), None)
    assert ("W-MATE-BROKEN", "Elbow") in reported_of(broken, root={"disconnected": "weld"})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        *(({"centroid": value}, "unknown format") for value in (None, [0.0], [0.0, None, 0.0], {}, "far")),
        ({"inertia": [1, 2]}, "unknown format"),
        ({"mass": {"a": 1}}, "unknown format"),
        ({"mass": [-1.0] * 3}, "E-MASS Arm <1>: its mass is -1 kg"),
        ({"inertia": [1e-3, 0, 0, 0, 1e-6, 0, 0, 0, 1e-6]}, "E-INERTIA Arm <1>"),
    ],
    ids=str,
)
def test_mass_properties_that_no_part_has_are_refused(kit, change, message):
    kit.elbow()
    bundle = bundle_of(kit.document)
    (digest,) = bundle.studios[0].mass
    tree = json.loads(bundle.body(digest))
    for part in tree["bodies"].values():
        part.update(change)
    with pytest.raises((ProtocolError, AssemblyError), match=message):
        reported_of(with_body(bundle, digest, json.dumps(tree).encode()))


def test_unknown_limits_are_reported_for_the_mate_in_their_place(kit):
    base, arm = kit.elbow(limits=(-1, 1))
    kit.root.revolute("Second", (arm, TOP), (base, SIDE), limits=(-0.5, 0.5), redundant=True)
    at = (*ROOT, "features", 1, "featureData", "mateLimits")
    note = only(build_robot(edited(bundle_of(kit.document), at, GONE), plan_of()), "W-LIMIT")
    assert (note.where, "Second" in note.message) == ("elbow", True)


def test_a_connector_that_would_name_the_origin_is_reported(kit):
    arm_path = kit.place("Arm")
    kit.root.revolute("Elbow", (arm_path, ON), (ORIGIN, SIDE), limits=(-1, 1))
    kit.root.connector("link_ground", ORIGIN, np.eye(4))
    robot = build_robot(bundle_of(kit.document), plan_of())
    assert [link.name for link in robot.links] == ["world", "arm"]
    assert reports(robot) == [("W-NAME", "link_ground")]


def test_a_very_long_name_still_names_a_file(kit):
    base = kit.place("Base", fixed=True)
    for letter in "ab":
        part = kit.root.add(kit.bar("x" * 300 + letter))
        kit.root.revolute("y" * 300 + letter, (part, ON), (base, SIDE), limits=(-1, 1))
    robot = build_robot(bundle_of(kit.document), plan_of())
    assert [link.name for link in robot.links] == ["base", "x" * 80, "x" * 80 + "_2"]
    assert [joint.name for joint in robot.joints] == ["y" * 80, "y" * 80 + "_2"]
