"""Real assemblies, as recorded: the whole build through the bundle source."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from linkwright.pipeline.run.build import build
from linkwright.stages.robot.errors import Disconnected
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.building import plan_of, write
from tests.support.command import report_of
from tests.support.engines import Mujoco, Pinocchio
from tests.support.recorded import (
    KBOT,
    bundle_in,
    definition_in,
    kbot_bundle,
    kbot_definition,
    kscale_bundle,
    nb_bundle,
    needs_data,
)

pytestmark = [pytest.mark.slow, needs_data]

TOLERANCE = 1e-9

MASS = {"parts": {"*": {"mass": 0.5, "com": [0.01, 0.02, 0.03], "inertia": [1e-3, 1.2e-3, 1.5e-3]}}}
"""What the parts weigh that nobody recorded."""

ASSEMBLIES: Mapping[str, tuple[Any, Mapping[str, Any]]] = {
    "kbot": (kbot_bundle, {}),
    "kscale": (kscale_bundle, {"mass": MASS}),
    "nb": (nb_bundle, {"mass": MASS}),
}

WAYS: Mapping[str, Mapping[str, Any]] = {
    "as drawn": {},
    "saved": {"zero": "saved"},
    "central": {"root": {"select": "central"}},
    "rigid": {"depth": {"max": 0}},
    "peer": {"conventions": "onshape_to_robot", "root": {"disconnected": "weld"}},
}


@pytest.fixture(scope="module")
def kbot(tmp_path_factory):
    """The built folder, and the robot that the graph stage made."""
    from linkwright.stages.fetch import fetch
    from linkwright.stages.fetch.source import FetchContext
    from linkwright.stages.graph import build_robot

    plan = built("kbot", tmp_path_factory.mktemp("kbot"))
    return plan.folder, build_robot(fetch(plan, FetchContext({}, {})).bundle, plan)


def built(name, here, **keys):
    """The plan of a recorded assembly that is built in a folder."""
    make, preset = ASSEMBLIES[name]
    (here / "it.zip").write_bytes(make())
    places = {"output": str(here / "out"), "cache": {"dir": str(here / "cache")}}
    plan = plan_of(
        name=name, source={"kind": "bundle", "path": str(here / "it.zip")}, **places, **preset, **keys
    )
    assert build(plan).exit_status == 0
    return plan


def test_recording_has_twenty_joints_and_reports_what_it_lacks(kbot):
    folder, robot = kbot
    assert (len(robot.joints), len(robot.links), robot.loops, robot.base.fixed) == (20, 21, (), True)
    codes = [diagnostic["code"] for diagnostic in report_of(folder)["diagnostics"]]
    assert codes.count("W-LIMIT") == 20
    assert "W-NO-MESH" in codes


def test_masses_are_the_direct_sum_over_the_recorded_parts(kbot):
    """Sums straight over the JSON, in exact-as-possible order, link by link, in the link's frame."""
    _, robot = kbot
    bodies = {}
    for file in KBOT.glob("part_*_mass_properties.json"):
        metadata = json.loads(file.with_name(file.name.replace("mass_properties", "metadata")).read_text())
        element = metadata["href"].partition("/e/")[2].partition("/")[0]
        for part, body in json.loads(file.read_text())["bodies"].items():
            bodies[element, part] = body
    definition = json.loads(kbot_definition())
    root = definition["rootAssembly"]
    transforms = {tuple(o["path"]): np.reshape(o["transform"], (4, 4)) for o in root["occurrences"]}
    assemblies = (root, *definition["subAssemblies"])
    instances = {instance["id"]: instance for each in assemblies for instance in each["instances"]}
    poses = link_poses(robot, saved_configuration(robot))
    total = 0.0
    for link in robot.links:
        mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        link_from_world = np.linalg.inv(poses[link.name])
        masses = []
        for part in link.parts:
            record = instances[part.path[-1]]
            body = bodies[record["elementId"], record["partId"]]
            pose = link_from_world @ transforms[part.path]
            masses.append((body["mass"][0], pose, np.array(body["centroid"][:3]), body["inertia"][:9]))
        mass = sum(m for m, *_ in masses)
        first = sum(m * (pose @ [*centre, 1])[:3] for m, pose, centre, _ in masses) / mass
        for m, pose, centre, inertia in masses:
            r, arm = pose[:3, :3], (pose @ [*centre, 1])[:3] - first
            second += r @ np.reshape(inertia, (3, 3)) @ r.T
            second += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        assert abs(link.inertial.mass - mass) <= 1e-12 * mass
        assert np.abs(link.inertial.com - first).max() <= 1e-12
        assert np.abs(link.inertial.inertia - second).max() <= 1e-12 * np.abs(second).max()
        total += mass
    assert abs(sum(link.inertial.mass for link in robot.links) - total) <= 1e-12 * total
    assert sum(len(link.parts) for link in robot.links) == 131


def recorded(name, **keys):
    """The robot that the graph stage makes of a recorded assembly."""
    from linkwright.stages.graph import build_robot

    make, preset = ASSEMBLIES[name]
    return build_robot(bundle_in(make()), plan_of(**preset, **keys))


def degrees(robot):
    """The saved value of each hinge."""
    return {dof.name: round(math.degrees(dof.saved), 9) for dof in robot.dofs}


def world_from_parts(robot, q):
    """Where every part is, by the robot's own kinematics."""
    poses = link_poses(robot, q)
    return {
        part.path: robot.world_from_root @ poses[link.name] @ part.link_from_part
        for link in robot.links
        for part in link.parts
    }


def as_recorded(name):
    root = json.loads(definition_in(ASSEMBLIES[name][0]()))["rootAssembly"]
    return {tuple(o["path"]): np.reshape(o["transform"], (4, 4)) for o in root["occurrences"]}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASSEMBLIES)
def test_a_recorded_assembly_builds_whichever_way(name, way, tmp_path):
    folder = built(name, tmp_path, **WAYS[way]).folder
    assert {f"{name}.urdf", f"{name}.xml"} <= {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASSEMBLIES)
def test_engines_agree_with_recorded_poses_and_each_other(name, way, tmp_path):
    """At the saved values every part is where it was recorded; at random ones, where the other engine
    has it."""
    robot = recorded(name, **WAYS[way])
    exported = write(robot, tmp_path)
    engines = Pinocchio(exported.files["robot.urdf"]), Mujoco(tmp_path / "robot.xml")
    random = np.random.default_rng(7)
    # Every zero is the saved pose's own there.
    saved = dict.fromkeys(degrees(robot), 0.0) if way in ("saved", "peer") else saved_configuration(robot)
    there = as_recorded(name)
    for engine in engines:
        poses = engine.poses(saved)
        world_from_root = robot.world_from_root @ inverse(poses[robot.root.name])
        for link in robot.links:
            for part in link.parts:
                stands = world_from_root @ poses[link.name] @ part.link_from_part
                assert np.abs(stands - there[part.path]).max() < TOLERANCE
    for _ in range(3):
        q = {dof.name: float(random.uniform(-3, 3)) for dof in robot.dofs}
        first, second = (engine.poses(q) for engine in engines)
        for link in robot.links:
            assert np.abs(first[link.name] - second[link.name]).max() < TOLERANCE


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_every_link_can_be_the_root(name):
    """No name changes, and values mean the same: parts stand to each other as with any other root."""
    usual = recorded(name)
    random = np.random.default_rng(3)
    q = {dof.name: float(random.uniform(-3, 3)) for dof in usual.dofs}
    wanted = world_from_parts(usual, q)
    held = usual.root.parts[0].path
    for link in usual.links if name != "kbot" else usual.links[::5]:
        robot = recorded(name, root={"select": link.name})
        assert robot.root.name == link.name
        assert {link.name for link in robot.links} == {link.name for link in usual.links}
        assert degrees(robot) == degrees(usual)
        parts = world_from_parts(robot, q)
        moved = wanted[held] @ inverse(parts[held])
        for path, pose in wanted.items():
            assert np.abs(moved @ parts[path] - pose).max() < TOLERANCE


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_all_recorded_mate_frames_coincide(name):
    """FASTENED frames wholly, those of hinges but for the turn, through the robot's own kinematics."""
    from linkwright.stages.graph.onshape.definition import read_assembly

    robot = recorded(name)
    world_from_part = world_from_parts(robot, saved_configuration(robot))
    mates = read_assembly(definition_in(ASSEMBLIES[name][0]())).mates
    assert len(mates) == {"kbot": 130, "kscale": 17, "nb": 8}[name]
    for mate in mates:
        first, second = (world_from_part[e.path] @ e.occurrence_from_frame for e in mate.entities)
        same = [2, 3] if mate.ref.type == "REVOLUTE" else [0, 1, 2, 3]
        assert np.abs(first[:3, same] - second[:3, same]).max() < TOLERANCE


def test_the_recorded_gears_drive_as_they_were_measured():
    """−30° drives +45° by 1.5, and 60° drives −60° by 1."""
    robot = recorded("kscale")
    assert len(robot.links) == 5
    assert not robot.loops
    left, right = "test_assembly_rmd_x8_p6_assem", "test_assembly_2_rmd_x8_p6_assem"
    values = {f"{left}_dof_x8": -30, f"{right}_dof_x8": 45, f"{left}_2_dof_x8": 60, f"{right}_2_dof_x8": -60}
    assert degrees(robot) == values
    assert {(r.name, r.driver, r.follower, r.multiplier, r.offset) for r in robot.relations} == {
        ("gear_1", f"{left}_dof_x8", f"{right}_dof_x8", -1.5, 0),
        ("gear_2", f"{left}_2_dof_x8", f"{right}_2_dof_x8", -1, 0),
    }
    # Not by believing the pose against the drawing: the rule of signs is the measured one.
    assert not [diagnostic.code for diagnostic in robot.diagnostics if "RELATION" in diagnostic.code]
    assert (robot.mobility.coordinates, robot.mobility.dof) == (4, 2)


def test_a_recorded_sub_assembly_used_twice_has_a_joint_in_each_place():
    robot = recorded("nb")
    assert len(robot.links) == 9
    assert not robot.loops
    assert not robot.relations
    turned = {"assembly_2_revolute_1": 90, "assembly_1_2_revolute_1": -90}
    straight = ("revolute_{}", "assembly_2_revolute_{}")
    names = [*(name.format(number) for name in straight for number in (1, 2, 3)), "assembly_1_revolute_1"]
    assert degrees(robot) == dict.fromkeys(names, 0) | turned


def test_unconnected_parts_are_reported_with_their_ignored_mates():
    with pytest.raises(Disconnected) as caught:
        recorded("nb", conventions="onshape_to_robot")
    shown = [problem for problem in caught.value.problems if problem.code == "W-PEER-MATE"]
    assert any("dof_NAME" in problem.hint for problem in shown)
