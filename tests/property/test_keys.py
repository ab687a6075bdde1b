"""Nothing that a user writes is without effect and without a word: keys at random, on a small robot."""

import functools

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.pipeline.config.plan import Plan, section
from linkwright.pipeline.reference.key_entries import entries
from linkwright.stages.export import export
from linkwright.stages.export.section import ExportSections
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.errors import LinkwrightError
from tests.fake_onshape.frames import frame, turn
from tests.support.building import bundle_of
from tests.support.drawn import SLOWLY
from tests.support.kit import SIDE, TOP, Kit

STAGES = (GraphSections, MeshSections, ExportSections)
"""The stages that make the robot's files."""

BASE = {
    "name": "robot",
    "source": {"kind": "sample"},
    "mesh": {"collider": "hull"},
    "contact": {"self": "none"},
    "actuators": {"*": "position"},
}
PARTS = ("Upper arm", "Palm", "Left finger", "Right finger", "Foot", "Cover")

AS_IT_IS = {
    "root.select": "the base is the root", "root.disconnected": "all parts are connected",
    "depth.max": "there are no sub-assemblies", "hidden": "nothing is hidden", "zero": "it was saved at zero",
    "mirror": "nothing is mirrored", "names.links": "the link has the name",
    "mass.missing": "all parts have masses", "frames.include": "tool is the only frame",
    "joints.<glob>.invert": "false is as it is", "relations.<glob>.invert": "false is as it is",
    "relations.<glob>.drop": "false is as it is", "mesh.colliders.<glob>.make": "hull is as it is",
    "mesh.min_size": "no part is so small", "mesh.visual.max_faces": "boxes have twelve faces",
    "target.mjwarp.integrator": "implicitfast is the default",
    "target.mujoco.version": "the files have no newer word",
    "loops.solref": "the example is the default of all but an MJCF",
    "scene.option.integrator": "the example is the default of all but an MJCF",
    "scene.surroundings": "only an MJCF has any",
}  # fmt: skip
"""Keys whose value may leave this robot as it is, since it asks for what is so already."""


@functools.cache
def bundle():
    """An arm with a gripper of two geared fingers, a foot, a cover and a frame."""
    kit = Kit()
    base = kit.place("Base plate", fixed=True)
    arm, palm, left, right, foot, cover = (kit.place(name) for name in PARTS)
    kit.root.revolute("Elbow", (arm, turn((1, 0, 0), 0.4)), (base, TOP), limits=(-1, 1))
    kit.root.slider("Wrist", (palm, np.eye(4)), (arm, frame((0.2, 0, 0.1))), limits=(-0.1, 0.2))
    first = kit.root.revolute("Left", (left, TOP), (palm, SIDE), limits=(-3, 3))
    second = kit.root.revolute("Right", (right, TOP), (palm, turn((1, 0, 0), 1, (0, 0.3, 0))), limits=(-3, 3))
    kit.root.gear("Gears", first, second, 1.5)
    kit.root.fasten("Sole", (foot, np.eye(4)), (base, np.eye(4)))
    kit.root.fasten("Lid", (cover, np.eye(4)), (palm, TOP))
    kit.root.connector("tool", palm, SIDE)
    return bundle_of(kit.document)


def merged(tree, keys):
    """A configuration with further keys, mapping by mapping."""
    candidate = dict(tree)
    for name, value in keys.items():
        below = candidate.get(name)
        both = isinstance(value, dict) and isinstance(below, dict)
        candidate[name] = merged(below, value) if both else value
    return candidate


def outcome(keys):
    """The parts of the stages, the files, and what is reported; or the error."""
    try:
        plan = Plan.parse(merged(BASE, keys))
        parts = [section(plan, stage) for stage in STAGES]
        robot = build_robot(bundle(), plan)
        geometry = make_geometry(robot, bundle(), plan, lambda kind, key, make: make())
        exported = export(robot, geometry, plan)
    except LinkwrightError as error:
        return None, str(error)
    said = (*robot.diagnostics, *geometry.diagnostics, *exported.diagnostics)
    return parts, exported.files, sorted(map(str, said))


AS_BEFORE = functools.cache(lambda: outcome({}))


def values_of(entry):
    """What the reference gives for a key as an example, once for each word of a choice; a glob is "*"."""
    example = yaml.safe_load(entry.example)
    words = [yaml.safe_load(word) if word.isdigit() else word for word in entry.words] or [None]
    if entry.words == ("false", "true"):
        words = [False, True]
    by_key = []
    for word in words:
        path = []
        value = example
        for name in entry.names:
            (own,) = [own for own in value if own == name or name.startswith("<")][:1]
            path.append(
                "*" if name == "<glob>" and entry.names[0] in ("joints", "actuators", "geoms") else own
            )
            value = value[own]
        value = value if word is None else word
        for name in reversed(path):
            value = {name: value}
        by_key.append(value)
    return by_key


HEADS = {field.alias or name for stage in STAGES for name, field in stage.model_fields.items()}
CASES = [
    (entry.key, value)
    for entry in entries()
    if entry.names[0] in HEADS - {"name"} and entry.example and not (entry.is_section or entry.later)
    for value in values_of(entry)
]


def is_without_effect(key, value):
    """Whether a key that differs from what the robot has changes no file, and no word is said of it."""
    parts, *rest = outcome(value)
    before, *as_before = AS_BEFORE()
    return parts != before and rest == as_before and key not in AS_IT_IS


def test_there_are_many_keys_and_the_exceptions_are_keys():
    assert len(CASES) > 300
    assert {key for key, _ in CASES} >= AS_IT_IS.keys()


@settings(max_examples=12, deadline=None, **SLOWLY)
@given(st.sampled_from(CASES))
def test_a_key_at_random_changes_a_file_or_is_reported(case):
    assert not is_without_effect(*case)


@pytest.mark.slow
def test_each_key_changes_a_file_or_is_reported():
    assert [(key, value) for key, value in CASES if is_without_effect(key, value)] == []
