"""Real assemblies, as recorded: the whole build through the bundle source."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from linkwright.stages.robot.errors import Disconnected
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Configuration, Robot
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from tests.support.building import plan_of, write
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
def kbot(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict, Robot]:
    """The built folder, its report, and the robot that the graph stage made."""
    from linkwright.stages.fetch import fetch
    from linkwright.stages.fetch.source import FetchContext
    from linkwright.stages.graph import build_robot

    here = tmp_path_factory.mktemp("kbot")
    (here / "kbot.zip").write_bytes(kbot_bundle())
    plan = Plan.parse(
        {
            "name": "kbot",
            "source": {"kind": "bundle", "path": str(here / "kbot.zip")},
            "output": str(here / "out"),
            "cache": {"dir": str(here / "cache")},
            "mesh": {"collider": "hull"},
            "contact": {"self": "none"},
        }
    )
    report = build(plan)
    assert report.exit_status == 0
    robot = build_robot(fetch(plan, FetchContext({}, {})).bundle, plan)
    return here / "out", json.loads((here / "out" / "report.json").read_text()), robot


def test_it_has_twenty_joints_and_a_fixed_base(kbot: tuple[Path, dict, Robot]) -> None:
    _, _, robot = kbot
    assert len(robot.joints) == 20
    assert len(robot.links) == 21
    assert not robot.loops
    assert robot.base.fixed


def test_what_was_not_recorded_is_reported(kbot: tuple[Path, dict, Robot]) -> None:
    _, report, _ = kbot
    codes = [diagnostic["code"] for diagnostic in report["diagnostics"]]
    assert codes.count("W-LIMIT") == 20
    assert "W-NO-MESH" in codes


def test_masses_are_the_direct_sum_over_the_recorded_parts(kbot: tuple[Path, dict, Robot]) -> None:
    """Sums straight over the JSON, in exact-as-possible order, link by link, in the link's frame."""
    _, _, robot = kbot
    bodies = {}
    for file in KBOT.glob("part_*_mass_properties.json"):
        metadata = json.loads(file.with_name(file.name.replace("mass_properties", "metadata")).read_text())
        element = metadata["href"].partition("/e/")[2].partition("/")[0]
        for part, body in json.loads(file.read_text())["bodies"].items():
            bodies[element, part] = body
    definition = json.loads(kbot_definition())
    root = definition["rootAssembly"]
    transforms = {tuple(o["path"]): np.reshape(o["transform"], (4, 4)) for o in root["occurrences"]}
    instances = {
        instance["id"]: instance
        for assembly in (root, *definition["subAssemblies"])
        for instance in assembly["instances"]
    }
    poses = link_poses(robot, saved_configuration(robot))
    total = 0.0
    for link in robot.links:
        mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        link_from_world = np.linalg.inv(poses[link.name])
        found = []
        for part in link.parts:
            record = instances[part.path[-1]]
            body = bodies[record["elementId"], record["partId"]]
            pose = link_from_world @ transforms[part.path]
            found.append((body["mass"][0], pose, np.array(body["centroid"][:3]), body["inertia"][:9]))
        mass = sum(m for m, *_ in found)
        first = sum(m * (pose @ [*centre, 1])[:3] for m, pose, centre, _ in found) / mass
        for m, pose, centre, inertia in found:
            r, arm = pose[:3, :3], (pose @ [*centre, 1])[:3] - first
            second += r @ np.reshape(inertia, (3, 3)) @ r.T
            second += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        assert abs(link.inertial.mass - mass) <= 1e-12 * mass
        assert np.abs(link.inertial.com - first).max() <= 1e-12
        assert np.abs(link.inertial.inertia - second).max() <= 1e-12 * np.abs(second).max()
        total += mass
    assert abs(sum(link.inertial.mass for link in robot.links) - total) <= 1e-12 * total
    assert sum(len(link.parts) for link in robot.links) == 131


def recorded(name: str, **keys: Any) -> Robot:
    """The robot that the graph stage makes of a recorded assembly."""
    from linkwright.stages.graph import build_robot

    make, given = ASSEMBLIES[name]
    return build_robot(bundle_in(make()), plan_of(**given, **keys))


def degrees(robot: Robot) -> dict[str, float]:
    """The saved value of each hinge."""
    return {dof.name: round(math.degrees(dof.saved), 9) for dof in robot.dofs}


def world_from_parts(robot: Robot, q: Configuration) -> dict[tuple[str, ...], np.ndarray]:
    """Where every part is, by the robot's own kinematics."""
    poses = link_poses(robot, q)
    return {
        part.path: robot.world_from_root @ poses[link.name] @ part.link_from_part
        for link in robot.links
        for part in link.parts
    }


def as_recorded(name: str) -> dict[tuple[str, ...], np.ndarray]:
    root = json.loads(definition_in(ASSEMBLIES[name][0]()))["rootAssembly"]
    return {tuple(o["path"]): np.reshape(o["transform"], (4, 4)) for o in root["occurrences"]}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASSEMBLIES)
def test_a_recorded_assembly_builds_whichever_way(name: str, way: str, tmp_path: Path) -> None:
    make, given = ASSEMBLIES[name]
    (tmp_path / "it.zip").write_bytes(make())
    tree = {
        "name": name,
        "source": {"kind": "bundle", "path": str(tmp_path / "it.zip")},
        "output": str(tmp_path / "out"),
        "cache": {"dir": str(tmp_path / "cache")},
        "mesh": {"collider": "hull"},
        "contact": {"self": "none"},
    }
    report = build(Plan.parse({**tree, **given, **WAYS[way]}))
    assert report.exit_status == 0
    assert (tmp_path / "out" / f"{name}.urdf").exists()
    assert (tmp_path / "out" / f"{name}.xml").exists()


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ASSEMBLIES)
def test_two_engines_agree_with_the_recorded_poses_and_with_each_other(
    name: str, way: str, tmp_path: Path
) -> None:
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
                found = world_from_root @ poses[link.name] @ part.link_from_part
                assert np.abs(found - there[part.path]).max() < TOLERANCE
    for _ in range(3):
        q = {dof.name: float(random.uniform(-3, 3)) for dof in robot.dofs}
        first, second = (engine.poses(q) for engine in engines)
        for link in robot.links:
            assert np.abs(first[link.name] - second[link.name]).max() < TOLERANCE


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_every_link_can_be_the_root(name: str) -> None:
    """No name changes, and values mean the same: parts stand to each other as with any other root."""
    usual = recorded(name)
    random = np.random.default_rng(3)
    q = {dof.name: float(random.uniform(-3, 3)) for dof in usual.dofs}
    wanted = world_from_parts(usual, q)
    held = usual.root.parts[0].path
    for link in usual.links if name != "kbot" else usual.links[::5]:
        robot = recorded(name, root={"select": link.name})
        assert robot.root.name == link.name
        assert {one.name for one in robot.links} == {one.name for one in usual.links}
        assert degrees(robot) == degrees(usual)
        found = world_from_parts(robot, q)
        moved = wanted[held] @ inverse(found[held])
        for path, pose in wanted.items():
            assert np.abs(moved @ found[path] - pose).max() < TOLERANCE


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_all_recorded_mate_frames_coincide(name: str) -> None:
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


def test_the_recorded_gears_drive_as_they_were_measured() -> None:
    """−30° drives +45° by 1.5, and 60° drives −60° by 1."""
    robot = recorded("kscale")
    assert len(robot.links) == 5
    assert not robot.loops
    one, two = "test_assembly_rmd_x8_p6_assem", "test_assembly_2_rmd_x8_p6_assem"
    values = {f"{one}_dof_x8": -30, f"{two}_dof_x8": 45, f"{one}_2_dof_x8": 60, f"{two}_2_dof_x8": -60}
    assert degrees(robot) == values
    assert {(r.name, r.driver, r.follower, r.multiplier, r.offset) for r in robot.relations} == {
        ("gear_1", f"{one}_dof_x8", f"{two}_dof_x8", -1.5, 0),
        ("gear_2", f"{one}_2_dof_x8", f"{two}_2_dof_x8", -1, 0),
    }
    # Not by believing the pose against the drawing: the rule of signs is the measured one.
    assert not [one.code for one in robot.diagnostics if "RELATION" in one.code]
    assert (robot.mobility.coordinates, robot.mobility.dof) == (4, 2)


def test_a_recorded_sub_assembly_used_twice_has_a_joint_in_each_place() -> None:
    robot = recorded("nb")
    assert len(robot.links) == 9
    assert not robot.loops
    assert not robot.relations
    assert degrees(robot) == {
        "revolute_1": 0,
        "revolute_2": 0,
        "revolute_3": 0,
        "assembly_2_revolute_1": 90,
        "assembly_2_revolute_2": 0,
        "assembly_2_revolute_3": 0,
        "assembly_1_revolute_1": 0,
        "assembly_1_2_revolute_1": -90,
    }


def test_parts_that_are_not_connected_by_the_peers_rules_is_reported_with_the_mates_that_did_not_count() -> (
    None
):
    with pytest.raises(Disconnected) as caught:
        recorded("nb", conventions="onshape_to_robot")
    shown = [problem for problem in caught.value.problems if problem.code == "W-PEER-MATE"]
    assert any("dof_NAME" in problem.hint for problem in shown)
