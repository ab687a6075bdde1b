"""A real humanoid, as recorded: the whole build through the bundle source."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.build import build
from pipeline.plan import Plan
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Robot
from tests.recorded import KBOT, kbot_bundle, kbot_definition, needs_data

pytestmark = needs_data


@pytest.fixture(scope="module")
def kbot(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict, Robot]:
    """The built folder, its report, and the robot that the graph stage made."""
    from stages.fetch import fetch
    from stages.graph import build_robot

    here = tmp_path_factory.mktemp("kbot")
    (here / "kbot.zip").write_bytes(kbot_bundle())
    plan = Plan.parse(
        {
            "name": "kbot",
            "source": {"kind": "bundle", "path": str(here / "kbot.zip")},
            "output": str(here / "out"),
            "cache": {"dir": str(here / "cache")},
        }
    )
    report = build(plan)
    assert report.exit_status == 0
    robot = build_robot(fetch(plan, {}, {}, lambda _: None).bundle, plan)
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


def test_all_mate_frames_coincide_at_the_saved_pose(kbot: tuple[Path, dict, Robot]) -> None:
    """Every mate of the recording, FASTENED ones too, through the robot's own kinematics."""
    from stages.graph.onshape.definition import read_assembly

    _, _, robot = kbot
    poses = link_poses(robot, saved_configuration(robot))
    world_from_part = {
        part.path: poses[link.name] @ part.link_from_part for link in robot.links for part in link.parts
    }
    mates = read_assembly(kbot_definition()).mates
    assert len(mates) == 130
    for mate in mates:
        first, second = (world_from_part[e.path] @ e.occurrence_from_frame for e in mate.entities)
        assert np.abs(first[:3, 3] - second[:3, 3]).max() < 1e-9
        assert np.abs(first[:3, 2] - second[:3, 2]).max() < 1e-9
