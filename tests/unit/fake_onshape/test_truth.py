"""The documents' own kinematics and dynamics: right by closed forms, differences and definition."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.fake_onshape import solids
from tests.fake_onshape.definition import definition
from tests.fake_onshape.differences import differences_hold
from tests.fake_onshape.document import ORIGIN, Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.mates import joined, motion
from tests.fake_onshape.random_document import documents
from tests.fake_onshape.sample import sample_document

QUICK = settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))


def pendulum(length=0.4, value=0.3):
    """A rod that hangs on a post and turns about the world's y; at 0 it points along x."""
    document = Document("Pendulum")
    studio = document.studio("Parts")
    post = studio.part("Post", solids.box(0.1, 0.1, 0.1), 1000)
    rod = studio.part("Rod", solids.box(length, 0.02, 0.02, at=(length / 2, 0, 0)), 2000)
    assembly = document.assembly("Pendulum")
    base, arm = assembly.add(post, fixed=True), assembly.add(rod)
    across = frame(x=(1, 0, 0), z=(0, 1, 0))
    assembly.revolute("Swing", (arm, across), (base, across), value)
    return document


def random_values(truth, seed):
    rng = np.random.default_rng(seed)
    return {joint.name: float(rng.uniform(-1.5, 1.5)) for joint in truth.tree_joints}


def entity_frames(owner, mate, poses):
    """World frames of a mate's two entities, read from the definition as a client would."""
    found = []
    for entity in mate["featureData"]["matedEntities"]:
        cs, made = entity["matedCS"], np.eye(4)
        made[:3] = np.column_stack([cs["xAxis"], cs["yAxis"], cs["zAxis"], cs["origin"]])
        found.append(poses.get((*owner, *entity["matedOccurrence"]), np.eye(4)) @ made)
    return found


def mates(document, **options):
    """(owner path, mate feature) of every mate of the definition, each use of a sub-assembly apart."""
    made = definition(document, **options)
    subs = {sub["elementId"]: sub for sub in made["subAssemblies"]}

    def walk(assembly, owner):
        for feature in assembly["features"]:
            if feature["featureType"] == "mate":
                yield owner, feature
        for instance in assembly["instances"]:
            if instance.get("type") == "Assembly" and not instance["suppressed"]:
                yield from walk(subs[instance["elementId"]], (*owner, instance["id"]))

    return list(walk(made["rootAssembly"], ()))


def test_a_pendulum_has_the_closed_form_mass_matrix_and_gravity_torque():
    truth = pendulum(0.4).truth
    mass = 2000 * 0.4 * 0.02 * 0.02
    for value in (-1.0, 0.0, 0.7):
        # About the end: m(l²/3 + h²/12); +y turns x towards −z, so gravity helps at q > −90°.
        assert truth.mass_matrix({"Swing": value})[0, 0] == pytest.approx(mass * (0.4**2 / 3 + 0.02**2 / 12))
        torque = truth.gravity_torque({"Swing": value})
        assert torque[0] == pytest.approx(-mass * 9.81 * 0.2 * np.cos(value))


def test_a_slider_carries_its_whole_mass_and_weight():
    document = Document("Lift")
    studio = document.studio("Parts")
    block = studio.part("Block", solids.box(0.1, 0.1, 0.1), 1000)
    assembly = document.assembly("Lift")
    base, cabin = assembly.add(block, fixed=True), assembly.add(block)
    assembly.slider("Lift", (base, frame()), (cabin, frame()), 0.2)
    truth = document.truth
    # The first entity stands still here, so a positive value lowers the cabin.
    assert truth.poses()[cabin.path][2, 3] == pytest.approx(-0.2)
    assert truth.mass_matrix()[0, 0] == pytest.approx(1.0)
    assert truth.gravity_torque()[0] == pytest.approx(-9.81)


@QUICK
@given(documents(), st.integers(0, 2**32 - 1))
def test_mate_frames_differ_by_the_joint_value_alone(document, seed):
    truth = document.truth
    values = random_values(truth, seed)
    poses = truth.poses(values)
    for owner, mate in mates(document):
        one, two = entity_frames(owner, mate, poses)
        apart = np.linalg.inv(two) @ one
        kind = mate["featureData"]["mateType"]
        q = 0.0 if kind == "FASTENED" else values[truth.joint((owner, mate["id"])).name]
        expected = np.eye(4)
        if kind == "REVOLUTE":
            expected[:2, :2] = [[np.cos(q), -np.sin(q)], [np.sin(q), np.cos(q)]]
        expected[2, 3] = q if kind == "SLIDER" else 0.0
        assert apart == pytest.approx(expected, abs=1e-12)


@QUICK
@given(documents(loops=True), st.integers(0, 2**32 - 1))
def test_swapped_entities_negate_values_and_limits(document, seed):
    truth = document.truth
    swap = {joint.name.split("/")[-1] for joint in truth.joints[::2]}
    poses = truth.poses()
    plain, swapped = mates(document), mates(document, swap=swap, shuffle=seed)
    found = {(owner, mate["id"]): mate for owner, mate in swapped}
    assert set(found) == {(owner, mate["id"]) for owner, mate in plain}
    for owner, mate in plain:
        other = found[owner, mate["id"]]
        sign = -1 if mate["featureData"]["name"] in swap else 1
        ends = mate["featureData"]["matedEntities"][::sign]
        assert other["featureData"]["matedEntities"] == ends
        limits, others = mate["featureData"]["mateLimits"], other["featureData"]["mateLimits"]
        names = {True: ("Max", "Min"), False: ("Min", "Max")}[sign < 0]
        renamed = {key[:-3] + names[key.endswith("Max")]: sign * value for key, value in limits.items()}
        assert others == (renamed if sign < 0 else limits)
        one, two = entity_frames(owner, other, poses)
        if mate["featureData"]["mateType"] == "REVOLUTE":
            turned = np.linalg.inv(two) @ one
            q = np.arctan2(turned[1, 0], turned[0, 0])
            assert q == pytest.approx(sign * truth.saved[truth.joint((owner, mate["id"])).name], abs=1e-9)


def test_swapping_one_mate_of_a_gear_turns_its_direction_about():
    document = sample_document()

    def reversed_in(swap):
        made = definition(document, swap=swap)
        features = [f for a in [made["rootAssembly"], *made["subAssemblies"]] for f in a["features"]]
        return [f["featureData"]["reverseDirection"] for f in features if f["featureType"] == "mateRelation"]

    assert reversed_in(()) == [False]
    assert reversed_in(["Left finger"]) == [True]
    assert reversed_in(["Left finger", "Right finger"]) == [False]


@QUICK
@given(documents(fixed=True), st.integers(0, 2**32 - 1))
def test_dynamics_agree_with_differences_of_energy(document, seed):
    truth = document.truth
    values, names = random_values(truth, seed), [joint.name for joint in truth.tree_joints]
    step, gravity = 1e-5, np.array([0.3, -0.2, -9.81])

    def state(index=None, by=0.0):
        shifted = dict(values)
        if index is not None:
            shifted[names[index]] += by
        return truth.poses(shifted)

    def potential(poses):
        total = 0.0
        for path in truth.leaves:
            mass, com, _ = truth.places[path].instance.source.inertial()
            total -= mass * gravity @ (poses[path] @ [*com, 1])[:3]
        return total

    slopes = [
        (potential(state(i, step)) - potential(state(i, -step))) / (2 * step) for i in range(len(names))
    ]
    scale = truth.total_mass() + 1
    assert truth.gravity_torque(values, gravity) == pytest.approx(np.array(slopes), abs=1e-6 * scale)

    speeds = np.random.default_rng(seed).normal(size=len(names))
    moved = {name: values[name] + step * v for name, v in zip(names, speeds, strict=True)}
    back = {name: values[name] - step * v for name, v in zip(names, speeds, strict=True)}
    ahead, behind = truth.poses(moved), truth.poses(back)
    kinetic = 0.0
    for path in truth.leaves:
        mass, com, inertia = truth.places[path].instance.source.inertial()
        v = ((ahead[path] - behind[path]) @ [*com, 1])[:3] / (2 * step)
        spin = truth.poses(values)[path][:3, :3].T @ (ahead[path] - behind[path])[:3, :3] / (2 * step)
        w = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        kinetic += (mass * v @ v + w @ inertia @ w) / 2
    assert speeds @ truth.mass_matrix(values) @ speeds / 2 == pytest.approx(kinetic, rel=1e-5, abs=1e-9)


@QUICK
@given(documents(), st.integers(0, 2**32 - 1), st.data())
def test_another_root_keeps_its_pose_and_all_relative_poses(document, seed, data):
    truth = document.truth
    root = data.draw(st.sampled_from(truth.leaves))
    values = random_values(truth, seed)
    usual, other = truth.poses(values), truth.poses(values, root)
    assert other[root] == pytest.approx(truth.poses()[root], abs=1e-12)
    move = other[root] @ np.linalg.inv(usual[root])
    for path in truth.leaves:
        assert other[path] == pytest.approx(move @ usual[path], abs=1e-12)


@QUICK
@given(documents(loops=True))
def test_a_random_document_closes_its_loops_keeps_its_gears_and_counts_its_bodies(document):
    truth = document.truth
    assert 2 <= len(truth.bodies) <= 12
    assert len(truth.bodies) == len(truth.tree_joints) + 1
    for error in truth.loop_errors().values():
        assert np.abs(error).max() < 1e-9
    for relation in truth.relations:
        assert truth.saved[relation.follower] == pytest.approx(
            relation.multiplier * truth.saved[relation.driver], abs=1e-12
        )
    for joint in truth.tree_joints:
        low, high = joint.limits
        assert low is None or low < joint.value
        assert high is None or joint.value < high
    parts = [path for body in truth.bodies for path in body.parts]
    assert sorted(parts) == sorted(truth.leaves)


@pytest.mark.slow
@QUICK
@given(st.booleans().flatmap(lambda loops: documents(everything=True, loops=loops)), st.data())
def test_a_random_document_with_everything_holds_together(document, data):
    truth = document.truth
    truth.check()
    poses = truth.poses()
    drawn = {edge.key[:2] for edge in (*truth.tree.edges, *truth.redundant) if edge.feature}
    for owner, mate in mates(document):
        assert (owner, mate["id"]) in drawn
        edge = truth.joint((owner, mate["id"]))
        one, two = entity_frames(owner, mate, poses)
        if np.linalg.det(one[:3, :3]) < 0:
            one, two = one @ np.diag([1, 1, -1, 1]), two @ np.diag([1, 1, -1, 1])
        value = joined(edge.type, tuple(truth.saved[dof.name] for dof in edge.dofs))
        expected = motion(edge.type, value, edge.mirrored)
        assert np.linalg.inv(two) @ one == pytest.approx(expected, abs=1e-9)
    for dof in truth.dofs:
        if dof.kind != "ball":
            low, high = dof.limits
            assert low is None or low < dof.value
            assert high is None or dof.value < high
    other = truth.cut_at({edge.name for edge in truth.closings})
    for path, pose in other.poses().items():
        assert pose == pytest.approx(poses[path], abs=1e-9)
    root = data.draw(st.sampled_from(truth.leaves))
    differences_hold(truth, truth.values(), roots=(root,))


def test_each_use_of_a_sub_assembly_has_joint_values_of_its_own():
    document = Document("Two arms")
    part = document.studio("Parts").part("Bar", solids.box(0.1, 0.02, 0.02), 1000)
    arm = document.assembly("Arm")
    lower, upper = arm.add(part), arm.add(part)
    bend = arm.revolute("Bend", (upper, frame()), (lower, frame()), 0.1)
    both = document.assembly("Both")
    document.root = both
    left, right = both.add(arm, fixed=True), both.add(arm)
    both.fasten("Together", (right / lower, frame()), (left / lower, frame((0, 1, 0))))
    document.set_value(right, bend, -0.4)
    assert document.truth.saved == {"Arm <1>/Bend": 0.1, "Arm <2>/Bend": -0.4}
    poses = document.truth.poses()
    assert poses[(right / upper).path][1, 0] == pytest.approx(np.sin(-0.4))
    assert poses[(left / upper).path][1, 0] == pytest.approx(np.sin(0.1))
    assert document.truth.joint((right.path, bend.id)).name == "Arm <2>/Bend"


def test_a_gear_turns_the_other_way_unless_reversed():
    document = pendulum()
    assembly = document.root
    post = assembly.features[0].entities[1][0]
    wheel = assembly.add(document.studios[0].parts[0])
    second = assembly.revolute("Wheel", (wheel, frame()), (post, frame()), -0.6)
    assembly.gear("Gear", assembly.features[0], second, 2.0)
    assert document.truth.relations[0].multiplier == -2.0
    document.truth.check()
    assembly.features[-1].reverse = True
    document.changed()
    assert document.truth.relations[0].multiplier == 2.0
    with pytest.raises(ValueError, match="'Gear' is off"):
        document.truth.check()


def test_a_loop_must_be_declared():
    document = pendulum()
    (arm, _), (base, _) = document.root.features[0].entities
    document.root.revolute("Again", (arm, frame()), (base, frame()))
    with pytest.raises(ValueError, match="'Again' closes a loop"):
        _ = document.truth


def test_a_mate_to_the_origin_holds_the_part_there():
    document = Document("Held")
    part = document.studio("Parts").part("Block", solids.box(0.1, 0.1, 0.1), 1000)
    assembly = document.assembly("Held")
    block = assembly.add(part)
    assembly.fasten("To the origin", (block, frame()), (ORIGIN, frame((1, 2, 3))))
    assert document.truth.poses()[block.path][:3, 3] == pytest.approx([1, 2, 3])
    assert document.truth.bodies[0].fixed


def test_the_linkage_of_the_sample_closes_wherever_the_shoulder_goes():
    truth = sample_document().truth
    for shoulder in (-0.3, 0.9):
        closed = truth.close({"Shoulder": shoulder}, held=["Shoulder"], steps=3)
        assert closed["Elbow plate pivot"] == pytest.approx(-shoulder, abs=1e-6)
        assert closed["Rod lower pivot"] == pytest.approx(-shoulder, abs=1e-6)
        assert max(np.abs(error).max() for error in truth.loop_errors(closed).values()) < 1e-9


def test_loops_can_be_cut_at_another_mate_and_the_saved_pose_stays():
    truth = sample_document().truth
    other = truth.cut_at({"Elbow plate pivot"})
    assert {joint.name for joint in other.closings} == {"Elbow plate pivot"}
    for path, pose in truth.poses().items():
        assert other.poses()[path] == pytest.approx(pose, abs=1e-12)
