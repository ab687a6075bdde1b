"""Variants of a robot: what is drawn, that bodies stay solid, and that every machine makes the same bytes."""

import hashlib
import io
import json
import os
import subprocess
import sys
import zipfile

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.export.actuators.motors import kinds_of
from linkwright.stages.export.variants.draws import draws
from linkwright.stages.export.variants.inertials import moved_inertials, spread_factor
from linkwright.stages.export.variants.shares import SHARE_BY_ORIGIN
from linkwright.stages.formats.npz import NotNpz, arrays_of, npz
from linkwright.stages.robot.errors import AssemblyError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import from_parts, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Dynamics, Inertial, Primitive, frozen
from tests.support.drawn import each
from tests.support.exports import compiled, exported
from tests.support.places import PROJECT
from tests.support.robots import EVERY, at, joint, loop, robot_with

BALL = Primitive("sphere", (0.01,), frozen(np.eye(4)))


def ball(link, contact=None):
    """A collider of a link."""
    return Shape(link, "collision", None, None, 0, 0, 0.0, 0.0, BALL, contact)


MOVED = Dynamics(damping=0.2, friction=0.05, armature=0.01, effort=30.0)


def hinges(**more):
    """Two hinges below a fixed base, whose inertias any version of MuJoCo reads alike."""
    plain = Inertial(2.0, frozen([0.1, 0.2, 0.3]), frozen(np.diag([0.03, 0.02, 0.015])))
    joints = [
        joint("revolute", "base", "one", dynamics=MOVED),
        joint("revolute", "one", "two", place=at(0.3, 0, 0)),
    ]
    return robot_with(joints, inertials=dict.fromkeys(("base", "one", "two"), plain), **more)


def arrays_in(outcome):
    return dict(np.load(io.BytesIO(outcome.files["variants.npz"])))


def varied(robot, ranges="auto", *, n=64, seed=7, **keys):
    return arrays_in(exported(robot, variants={"n": n, "seed": seed, "ranges": ranges}, **keys))


def codes_at(outcome, place):
    return [(note.code, note.where) for note in outcome.diagnostics if note.where.startswith(place)]


def shares_in(robot, **keys):
    """By quantity of robot.json that varies: where it comes from, and by how much it varies."""
    files = exported(robot, **({"variants": {"n": 2}} | keys)).files
    rows = json.loads(files["robot.json"])["variants"]["varied"]
    return {row["quantity"]: (row["origin"], row["share"]) for row in rows}


def test_draw_is_the_hash_of_its_seed_quantity_and_variant():
    columns = draws(7, "links.arm.mass", 3, 2)
    for variant in range(3):
        text = f"7\nlinks.arm.mass\n{variant}".encode()
        whole = np.frombuffer(hashlib.blake2b(text, digest_size=16).digest(), "<u8")
        for column, bits in zip(columns, whole.tolist(), strict=True):
            assert column[variant] == (bits >> 11) / 2**52 - 1


def test_draws_are_spread_evenly():
    columns = draws(0, "joints.hip.damping", 20_000, 8)
    for column in columns:
        assert abs(column.mean()) < 0.02
        assert abs(column.std() - 1 / np.sqrt(3)) < 0.01
        counts, _ = np.histogram(column, 20, (-1, 1))
        assert counts.min() > 850
        assert counts.max() < 1150
    assert np.abs(np.corrcoef(columns) - np.eye(8)).max() < 0.03
    assert np.abs(np.corrcoef(columns[0][1:], columns[0][:-1])[0, 1]) < 0.03


def pseudo(mass, com, moments, quat):
    """The pseudo-inertia (4, 4) of a body."""
    axes = rotation_from_quat(np.asarray(quat, float))
    inertia = axes @ np.diag(moments) @ axes.T
    spread = np.trace(inertia) / 2 * np.eye(3) - inertia + mass * np.outer(com, com)
    first = mass * np.asarray(com)
    return np.block([[spread, first[:, None]], [first[None, :], np.array([[mass]])]])


def solid_body(rng, flat):
    """Mass, centre, moments and axes of eight masses; with `flat` of its extents 0."""
    points = rng.normal(size=(8, 3)) * np.append(rng.uniform(0.01, 1, 3 - flat), [0.0] * flat)
    masses = rng.uniform(0.1, 1, 8)
    com = masses @ points / masses.sum()
    spread = ((points - com).T * masses) @ (points - com)
    moments, axes = np.linalg.eigh(np.trace(spread) * np.eye(3) - spread)
    axes[:, 2] *= np.linalg.det(axes)
    return float(masses.sum()), com, moments, quat_from_rotation(axes)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 1), st.sampled_from([0.01, 0.3, 0.95]))
def test_moved_body_is_a_congruence_of_the_body(seed, flat, share):
    rng = np.random.default_rng(seed)
    (mass, com, moments, quat), n = solid_body(rng, flat), 16
    factor, shift = rng.uniform(1 - share, 1 + share, n), share * rng.uniform(-1, 1, (3, n))
    turned = np.tril(rng.uniform(-1, 1, (n, 3, 3)) * share) + np.eye(3)
    a = spread_factor([*map(float, moments)], [*map(float, quat)], mass)
    rows = [[turned[:, i, j] for j in range(3)] for i in range(3)]
    bodies = moved_inertials(mass * factor, [*map(float, com)], a, [*shift], rows)
    lever = np.array(a)
    for i in range(n):
        own = [[column[i] for column in columns] for columns in (bodies.com, bodies.moments, bodies.quat)]
        # Every mass at c + A y is moved to c + A (t + T y).
        linear = lever @ turned[i] @ np.linalg.pinv(lever)
        move = from_parts(linear, com + lever @ shift[:, i] - linear @ com)
        expected = factor[i] * move @ pseudo(mass, com, moments, quat) @ move.T
        got = pseudo(bodies.mass[i], *own)
        assert np.allclose(got, expected, atol=1e-9 * np.abs(expected).max())
        assert np.linalg.eigvalsh(got).min() >= -1e-12 * np.abs(got).max()
        assert np.isclose(np.linalg.norm(own[2]), 1.0, atol=1e-12)
        largest, middle, smallest = own[1]
        assert largest >= middle >= smallest >= 0
        assert largest <= (middle + smallest) * (1 + 1e-12)


def test_variants_of_a_robot_are_solid_and_near_it():
    robot, share = hinges(), 0.3
    nominal, arrays = compiled(exported(robot)), varied(robot, {"links.*": share}, n=200)
    mass = arrays["body_mass"][:, 1:] / nominal.body_mass[1:]
    assert (abs(mass - 1) <= share + 1e-12).all()
    assert 0.9 < mass.mean() < 1.1
    assert mass.std() > 0.15
    inertia = arrays["body_inertia"][:, 1:]
    assert (inertia > 0).all()
    assert (2 * inertia.max(axis=2) <= inertia.sum(axis=2) * (1 + 1e-11)).all()
    spread = (nominal.body_inertia.sum(axis=1) / 2 / nominal.body_mass.clip(1e-9)) ** 0.5
    off = np.linalg.norm(arrays["body_ipos"] - nominal.body_ipos, axis=2)
    assert (off <= share * np.sqrt(3) * spread + 1e-12).all()
    assert off[:, 1:].max() > 0.5 * share * spread[1:].max()


def test_mass_alone_is_a_density():
    robot = hinges()
    nominal, arrays = compiled(exported(robot)), varied(robot, {"*.mass": 0.2})
    assert set(arrays["fields"]) == {"body_mass", "body_inertia"}
    factor = arrays["body_mass"][:, 1:] / nominal.body_mass[1:]
    assert np.allclose(arrays["body_inertia"][:, 1:], nominal.body_inertia[1:] * factor[..., None])


@pytest.mark.parametrize(("kind", "gains", "column", "back"), [
    ("position", "kp", 0, 1), ("velocity", "kv", 0, 2), ("motor", "gain", 0, None), ("damper", "kv", 2, None),
])  # fmt: skip
def test_gains_move_together(kind, gains, column, back):
    """`column` of the gains varies, and that of the bias alike."""
    drives = {"*": {"type": kind, "ctrlrange": [0, 1]} if kind == "damper" else kind}
    nominal = compiled(exported(hinges(), actuators=drives))
    arrays = varied(hinges(), {f"actuators.*.{gains}": 0.4}, actuators=drives)
    gain = arrays["actuator_gainprm"]
    factor = gain[:, :, column] / nominal.actuator_gainprm[:, column]
    assert (abs(factor - 1) <= 0.4).all()
    assert factor.std() > 0.1
    if back is not None:
        assert (arrays["actuator_biasprm"][:, :, back] == -gain[:, :, 0]).all()
    constant = np.delete(np.arange(gain.shape[2]), column)
    assert (gain[:, :, constant] == nominal.actuator_gainprm[:, constant]).all()


def test_damping_of_a_servo_moves_alone():
    damping = varied(hinges(), {"actuators.*.kv": 0.4}, actuators={"*": "position"})
    assert set(damping["fields"]) == {"actuator_biasprm"}
    servos = compiled(exported(hinges(), actuators={"*": "position"}))
    assert (damping["actuator_biasprm"][:, :, 1] == servos.actuator_biasprm[:, 1]).all()


def test_zeros_and_unnamed_quantities_do_not_vary():
    arrays = varied(hinges(), {"joints.*": 0.3})
    assert set(arrays["fields"]) == {"dof_damping", "dof_frictionloss", "dof_armature", "jnt_actfrcrange"}
    assert (arrays["dof_damping"][:, 1] == 0).all()
    assert arrays["dof_damping"][:, 0].std() > 0
    ends = arrays["jnt_actfrcrange"]
    assert (ends[:, :, 0] == -ends[:, :, 1]).all()


def test_friction_is_that_of_all_colliders_of_a_link():
    balls = [ball("one"), ball("one"), ball("two", ContactProperties(friction=(0.5, 0.01, 0.001)))]
    geometry = Geometry(tuple(balls), {})
    result = exported(hinges(), geometry, variants={"n": 50})
    arrays = arrays_in(result)
    model = compiled(result)
    factor = arrays["geom_friction"] / model.geom_friction
    assert np.allclose(factor, factor[:, :, :1])
    assert np.allclose(factor[:, 0], factor[:, 1])
    assert (abs(factor - 1).max(axis=(0, 2)) <= [0.5, 0.5, 0.1]).all()
    assert (factor.std(axis=0)[:, 0] > [0.2, 0.2, 0.04]).all()


@pytest.mark.parametrize("kind", EVERY)
def test_joints_of_any_type_vary(kind):
    robot = robot_with([joint(kind, "base", "one", dynamics=MOVED)])
    nominal, arrays = compiled(exported(robot)), varied(robot, "auto", n=4)
    assert arrays["joint_names"].tolist() == [nominal.joint(k).name for k in range(nominal.njnt)]
    assert arrays["body_names"].tolist() == [nominal.body(k).name for k in range(nominal.nbody)]
    held = np.flatnonzero(nominal.jnt_type != mujoco.mjtJoint.mjJNT_FREE)
    names = {name.split(".")[1] for name in shares_in(robot) if name.startswith("joints.")}
    assert names == {nominal.joint(k).name for k in held}
    for field in {"dof_damping", "dof_armature"} & arrays.keys():
        before = getattr(nominal, field)
        assert ((arrays[field] != before).any(axis=0) == (before != 0)).all()


def test_body_of_a_loops_joint_weighs_its_share_of_the_link():
    robot = robot_with(
        [joint("revolute", "base", "a"), joint("revolute", "base", "b", place=at(0.2, 0, 0))],
        loops=[loop("prismatic", "a", "b", at(0.1, 0, 0), at(-0.1, 0, 0))],
    )
    nominal, arrays = compiled(exported(robot)), varied(robot, {"links.*": 0.2})
    link, carrier = nominal.body("a").id, nominal.body("loop_carrier").id
    assert nominal.body_mass[link] == nominal.body_mass[carrier]
    assert (arrays["body_mass"][:, link] == arrays["body_mass"][:, carrier]).all()
    assert arrays["body_mass"][:, link].std() > 0
    assert not any("carrier" in name for name in shares_in(robot))


SHARES = {
    "links.one.mass": ("source", 0.1), "links.two.mass": ("given", 0.1),
    "joints.one_joint.damping": ("source", 0.1), "joints.two_joint.armature": ("measured", 0.05),
    "joints.two_joint.damping": ("datasheet", 0.2), "actuators.two_joint.kp": ("datasheet", 0.2),
    "actuators.two_joint.kv": ("estimated", 0.3), "actuators.one_joint.kp": ("estimated", 0.3),
}  # fmt: skip


def test_auto_is_by_where_a_value_comes_from():
    values = {
        "armature": (0.02, "a; bench (2 May)", "measured"), "damping": (0.1, "fit", "identified"),
        "back_emf": (0.1, "page", "datasheet"), "kp": (20, "page", "datasheet"),
    }  # fmt: skip
    keys = ("value", "source", "kind")
    table = {name: dict(zip(keys, row, strict=True)) for name, row in values.items()}
    inertials = {"two": Inertial(1.0, frozen([0, 0, 0.1]), frozen(np.diag([0.01, 0.01, 0.01])))}
    shares = shares_in(
        hinges(given=inertials),
        motors={"mine": {"title": "Mine", "values": table}},
        actuators={"two_joint": {"motor": "mine"}, "one_joint": "position"},
    )
    assert {name: shares[name] for name in SHARES} == SHARES
    assert {share for _, share in shares.values()} <= set(SHARE_BY_ORIGIN.values())


def test_later_globs_win_and_auto_is_a_share_too():
    ranges = {"*": "auto", "*.mass": 0.02, "links.two.*": 0}
    shares = shares_in(hinges(), variants={"n": 2, "ranges": ranges})
    assert (shares["links.one.mass"][1], shares["links.one.com"][1]) == (0.02, 0.1)
    assert not any(name.startswith("links.two.") for name in shares)


def test_glob_that_matches_nothing_is_an_error():
    with pytest.raises(AssemblyError) as caught:
        varied(hinges(), {"*.masss": 0.1, "joints.three_joint.*": 0.1, "*.mass": 0.1})
    problems = [(problem.code, problem.where) for problem in caught.value.problems]
    assert problems == [("E-GLOB", "variants.ranges")] * 2
    assert all("links.one.mass" in problem.hint for problem in caught.value.problems)


def test_variants_without_an_mjcf_are_told():
    outcome = exported(hinges(), variants={"n": 4}, export={"urdf": {}})
    assert "variants.npz" not in outcome.files
    assert "variants" not in json.loads(outcome.files["robot.json"])
    assert codes_at(outcome, "variants") == [("W-VARIANTS", "variants")]


@pytest.mark.parametrize(("keys", "idle"), [
    ({"seed": 7, "ranges": {"*.mass": 0.1}}, ["variants.seed", "variants.ranges"]),
    ({}, []), ({"ranges": "auto"}, []), ({"n": 2, "seed": 7}, []),
])  # fmt: skip
def test_keys_of_variants_without_any_are_idle(keys, idle):
    outcome = exported(hinges(), variants=keys)
    assert ("variants.npz" in outcome.files) == ("n" in keys)
    notes = [note for note in codes_at(outcome, "variants") if note[0] == "I-IDLE-KEY"]
    assert notes == [("I-IDLE-KEY", place) for place in idle]


def test_body_that_floats_alone_keeps_its_axes():
    body = Inertial(1.0, frozen([0, 0, 0]), frozen(np.diag([0.03, 0.02, 0.015])))
    robot = robot_with([], fixed=False, inertials={"base": body})
    result = exported(robot, variants={"n": 16, "ranges": {"*": 0.2}})
    arrays = arrays_in(result)
    assert set(arrays["fields"]) == {"body_mass", "body_inertia"}
    inertia = arrays["body_inertia"][:, 1]
    assert (2 * inertia.max(axis=1) <= inertia.sum(axis=1) * (1 + 1e-11)).all()
    assert codes_at(result, "variants") == [("I-VARIANTS", "variants")]


def test_kinds_of_a_motors_value_are_those_of_its_sources():
    text = "motor a: bench (2 May); fit (identified); page (datasheet)"
    assert kinds_of(text) == ["identified", "datasheet"]
    assert kinds_of("given") == []


@pytest.mark.parametrize("count", [5, pytest.param(15, marks=pytest.mark.slow)])
def test_variant_is_the_same_whatever_else_is_asked(count):
    def is_same(seed, n, more):
        few = varied(hinges(), {"*.mass": 0.1, "joints.*": 0.2}, n=n, seed=seed)
        many = varied(hinges(), {"joints.*": 0.2, "*.mass": 0.1, "*.com": 0.3}, n=n + more, seed=seed)
        for field in ("body_mass", "dof_damping", "dof_armature"):
            assert (few[field] == many[field][:n]).all()

    each(is_same, count, st.integers(0, 2**64 - 1), st.integers(1, 20), st.integers(1, 20))


@pytest.mark.parametrize("seed", [0, 1])
def test_other_seeds_give_other_variants(seed):
    assert (varied(hinges(), seed=seed)["body_mass"] != varied(hinges(), seed=2)["body_mass"])[:, 1:].all()


KNOWN = "079dddb11e34dc5e1a8c13f0e8d512a52140bde7bba087f7b04439af8186a54a"


def digest():
    """The digest of all that varies in the variants of the hinges, in their bodies and joints alone:
    actuators have more parameters in newer MuJoCos."""
    arrays = varied(hinges(), {"*": 0.2}, n=100)
    hashed = hashlib.sha256()
    for field in arrays["fields"]:
        hashed.update(field.encode() + arrays[field].tobytes())
    return hashed.hexdigest()


def test_bytes_are_known():
    assert digest() == KNOWN


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["0", "77"])
def test_bytes_do_not_depend_on_the_order_of_sets(seed):
    code = "from tests.unit.export.test_variants import digest; print(digest())"
    environ = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-c", code]
    assert subprocess.check_output(command, env=environ, cwd=PROJECT, text=True).strip() == KNOWN


def test_file_is_stored_without_times():
    arrays = {
        "a": np.arange(6.0).reshape(2, 3), "names": np.array(["ä", "bc"]), "seed": np.array(2**63, "u8"),
    }  # fmt: skip
    data = npz(arrays)
    assert hashlib.sha256(data).hexdigest() == NPZ
    for read in (dict(np.load(io.BytesIO(data))), arrays_of(data)):
        assert list(read) == list(arrays)
        for name, array in arrays.items():
            assert read[name].dtype == array.dtype
            assert (read[name] == array).all()


def test_array_by_columns_is_read_as_it_is():
    array = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    data = io.BytesIO()
    np.savez(data, a=array)
    assert (arrays_of(data.getvalue())["a"] == array).all()


def npz_of_header(header):
    """An npz of a single array without values."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        array = np.lib.format.magic(1, 0) + len(header).to_bytes(2, "little") + header.encode()
        archive.writestr("a.npy", array)
    return data.getvalue()


NPZ = "2d8a6b45333525e2c875f98b069c2fc1bfc44e979213cd5e68c9b1626e2056ab"


def test_other_files_are_refused():
    packed, huge = io.BytesIO(), npz({"a": np.zeros(2)}).replace(b"(2,)", b"(9,)")
    np.savez_compressed(packed, a=np.zeros(1000))
    objects = io.BytesIO()
    np.savez(objects, a=np.array([{}], object))
    for data in (
        b"",
        b"PK",
        packed.getvalue(),
        huge,
        objects.getvalue(),
        npz({"a": np.zeros(9)})[:-40],
        *map(npz_of_header, ("((((", "  1\n 2", "{[]: 1}")),
    ):
        with pytest.raises(NotNpz):
            arrays_of(data)
