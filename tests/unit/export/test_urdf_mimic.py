"""Loops of a URDF: what is exactly linear is a <mimic>, certified by the loop that MuJoCo closes."""

import json
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.model.robot import Limits, Relation, frozen
from linkwright.stages.robot.motion.loop_lines import linear_couplings
from linkwright.stages.robot.motion.start_pose import home
from tests.fake_onshape.frames import frame
from tests.support.building import plan_of, robot_of, sample_robot, write
from tests.support.checked import checked
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import failing, messages_of
from tests.support.kit import Kit, four_bar
from tests.support.robots import at, joint, loop, robot_with
from tests.support.states import pose_of


def uneven(crank=0.1, coupler=0.24, rocker=0.2, base=0.25):
    """A four-bar of hinges about z whose rocker turns by no line, assembled by the law of cosines."""
    drive = 1.0
    tip = np.array([crank * np.cos(drive), crank * np.sin(drive)])
    off = np.array([base, 0.0]) - tip
    far = float(np.hypot(*off))
    inner = np.arccos((coupler**2 + far**2 - rocker**2) / (2 * coupler * far))
    heading = np.arctan2(off[1], off[0]) + inner
    end = tip + coupler * np.array([np.cos(heading), np.sin(heading)])
    swing = np.arctan2(end[1], end[0] - base)
    limits = {"crank_joint": Limits(0.4, 1.6)}
    rows = [
        joint("revolute", "base", "crank", [drive], limits=limits),
        joint("revolute", "crank", "coupler", [heading - drive], place=at(crank, 0, 0)),
        joint("revolute", "base", "rocker", [swing], place=at(base, 0, 0)),
    ]
    shut = loop("revolute", "coupler", "rocker", at(coupler, 0, 0), at(rocker, 0, 0), [heading - swing])
    return robot_with(rows, loops=[shut])


def swing_of(drive, crank=0.1, coupler=0.24, rocker=0.2, base=0.25):
    """The rocker's angle in closed form, by Freudenstein's equation."""
    a = base - crank * np.cos(drive)
    b = -crank * np.sin(drive)
    c = (coupler**2 - a**2 - b**2 - rocker**2) / (2 * rocker)
    return float(np.arctan2(b, a) + np.arccos(c / np.hypot(a, b)))


def parallelogram(**keys):
    kit = Kit()
    four_bar(kit, **keys)
    return robot_of(kit.document)


def mimics(text):
    """Follower → driver, multiplier and offset."""
    numbers = "multiplier", "offset"
    return {
        node.getparent().get("name"): (node.get("joint"), *(float(node.get(key, 0)) for key in numbers))
        for node in parse(text).iterfind("joint/mimic")
    }


def test_parallelogram_of_the_sample_is_minus_the_shoulder(tmp_path):
    outcome = write(sample_robot(), tmp_path)
    couplings = mimics(outcome.files["robot.urdf"])
    assert couplings["rod_lower_pivot"] == couplings["elbow_plate_pivot"] == ("shoulder", -1.0, 0.0)
    table = json.loads(outcome.files["robot.json"])
    assert [entry["name"] for entry in table["loops"] if entry["mimic"]] == ["rod_upper_pivot"]
    coupling = table["couplings"][0]
    assert (coupling["driver"], coupling["multiplier"]) == ("shoulder", -1)
    assert (coupling["range"], coupling["error"]) == ([-0.5, 1.1], 0)
    assert failing(tmp_path, outcome, plan_of()) == []


@pytest.mark.parametrize("kind", ["sample", "kit"])
def test_mimics_put_links_where_the_loop_of_the_mjcf_does(kind, tmp_path):
    """MuJoCo's own solver closes the loop of the MJCF; Pinocchio reads the URDF, whose followers follow."""
    robot = sample_robot() if kind == "sample" else parallelogram(limits=True)
    exported = write(robot, tmp_path)
    text = exported.files[f"{robot.name}.urdf"]
    follow = mimics(text)
    pinocchio, engine = Pinocchio(text), Mujoco(tmp_path / f"{robot.name}.xml")
    driver = next(iter(follow.values()))[0]
    low, high = engine.model.joint(driver).range
    # Where the parallelogram lies flat, at 0, it can go on in several ways.
    for value in np.linspace(low, high, 8):
        q = {dof.name: 0.0 for dof in robot.dofs} | {driver: float(value)}
        q |= {name: slope * q[by] + offset for name, (by, slope, offset) in follow.items()}
        expected = closed_by_mujoco(engine, q, list(follow))
        actual = pinocchio.poses(q)
        for link in robot.links:
            assert np.abs(actual[link.name] - expected[link.name]).max() < 1e-9, (value, link.name)


def closed_by_mujoco(engine, q, followers):
    """Poses with the equalities closed by Gauss-Newton steps on MuJoCo's own residuals, but for the
    followers all held, from beside where the mimics put these."""
    model, data = engine.model, engine.data
    mujoco.mj_resetData(model, data)
    for name, value in q.items():
        beside = 1e-3 * (-1) ** followers.index(name) if name in followers else 0.0
        data.qpos[model.joint(name).qposadr[0]] = value + beside
    columns = [int(model.joint(name).dofadr[0]) for name in followers]
    for _ in range(20):
        mujoco.mj_fwdPosition(model, data)
        rows = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        dense = np.zeros((data.nefc, model.nv))
        if mujoco.mj_isSparse(model):
            mujoco.mju_sparse2dense(
                dense, data.efc_J.ravel(), data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind.ravel()
            )
        else:
            dense = data.efc_J.reshape(data.nefc, model.nv)
        step = np.linalg.lstsq(dense[rows][:, columns], -data.efc_pos[: data.nefc][rows], rcond=1e-9)[0]
        speed = np.zeros(model.nv)
        speed[columns] = step
        mujoco.mj_integratePos(model, data.qpos, speed, 1.0)
    mujoco.mj_kinematics(model, data)
    return {model.body(index).name: pose_of(data.body(index)) for index in range(model.nbody)}


def test_nonlinear_coupling_has_the_best_line_and_its_error(tmp_path):
    robot = uneven()
    couplings = {coupling.follower: coupling for coupling in linear_couplings(robot, home(robot))}
    rocker = couplings["rocker_joint"]
    assert not rocker.exact
    assert rocker.driver == "crank_joint"
    assert (rocker.low, rocker.high) == pytest.approx((0.4, 1.6))
    drives = np.linspace(0.4, 1.6, 65)
    swings = np.array([swing_of(drive) for drive in drives])
    slope, height = np.polyfit(drives, swings, 1)
    assert (rocker.multiplier, rocker.offset) == pytest.approx((slope, height), abs=1e-9)
    assert rocker.error == pytest.approx(np.abs(swings - slope * drives - height).max(), rel=1e-6)
    exported = write(robot, tmp_path)
    assert mimics(exported.files["robot.urdf"]) == {}
    (message,) = messages_of(exported, "I-URDF-LOOP")
    assert re.search(r"rocker_joint = \S+ crank_joint \+ \S+, off by up to 0\.\d+", message)
    table = json.loads(exported.files["robot.json"])
    assert [entry["mimic"] for entry in (*table["loops"], *table["couplings"])] == [False] * 3


def test_line_that_is_off_by_a_millionth_is_not_exact():
    robot = parallelogram(limits=True)
    (shut,) = robot.loops
    bent = shut.a_from_frame @ frame((1e-6, 0, 0))
    robot = replace(robot, loops=(replace(shut, a_from_frame=frozen(bent)),))
    couplings = linear_couplings(robot, home(robot))
    assert couplings
    assert not any(coupling.exact for coupling in couplings)
    assert all(1e-9 < coupling.error < 0.1 for coupling in couplings)


def test_parallelogram_that_lies_flat_is_not_certified():
    robot = parallelogram(value=0.0)
    assert linear_couplings(robot, home(robot)) == ()
    form = urdf_form(robot)
    assert (form.mimics, form.closed) == ((), ())


def test_first_dof_drives_followers_of_followers():
    robot = parallelogram(limits=True)
    names = sorted(dof.name for dof in robot.dofs)
    for first in names:
        form = urdf_form(robot, preferred_drivers=[first])
        assert {mimic.driver for mimic in form.mimics} == {first}
        assert {mimic.follower for mimic in form.mimics} == set(names) - {first}
        assert form.closed == tuple(loop.name for loop in robot.loops)
    links = (*robot.links, replace(robot.links[0], name="wheel", parts=()))
    joints = (*robot.joints, joint("revolute", "base", "wheel"))
    gear = Relation("gear", "wheel_joint", names[0], 2.0, 0.1)
    geared = replace(robot, links=links, joints=joints, relations=(gear,))
    form = urdf_form(geared, preferred_drivers=[names[1]])
    (line,) = (mimic for mimic in form.mimics if mimic.follower == names[0])
    relations = {row.name: row for row in Written(geared, urdf_form=form).as_urdf.robot.relations}
    relation = relations["gear"]
    assert (relation.driver, relation.multiplier) == (names[1], pytest.approx(2 * line.multiplier))
    assert relation.offset == pytest.approx(2 * line.offset + 0.1)


def test_wrong_mimic_fails_the_check(tmp_path):
    robot = parallelogram(limits=True)
    exported = write(robot, tmp_path)
    first = exported.written.urdf_form.couplings[0]
    couplings = (replace(first, multiplier=1.1), *exported.written.urdf_form.couplings[1:])
    wrong = replace(exported.written.urdf_form, couplings=couplings)
    failed = [check.name for check in checked(tmp_path, robot, plan_of(), urdf_form=wrong) if check.fails]
    assert failed == ["robot.urdf: relations", "robot.urdf: loops"]
