"""The sample robot: what it shows, and that the shipped bundle is this document's."""

import hashlib
import io
import json
import zipfile

import numpy as np
import pytest

from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.sample import BUNDLE, sample_document


@pytest.fixture(scope="module")
def document():
    return sample_document()


def contents(data):
    """{request: parsed reply} of a bundle."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        return manifest, {
            request: json.loads(archive.read(f"replies/{digest}"))
            for request, digest in manifest["requests"].items()
        }


def assert_alike(one, two, where=""):
    """Equal but for the last digits of numbers."""
    assert type(one) is type(two), where
    if isinstance(one, dict):
        assert one.keys() == two.keys(), where
        for key in one:
            assert_alike(one[key], two[key], f"{where}/{key}")
    elif isinstance(one, list):
        assert len(one) == len(two), where
        for index, (a, b) in enumerate(zip(one, two, strict=True)):
            assert_alike(a, b, f"{where}/{index}")
    elif isinstance(one, float):
        assert one == pytest.approx(two, abs=1e-12), where
    else:
        assert one == two, where


def test_the_shipped_bundle_is_up_to_date(document):
    fresh, shipped = contents(bundle_bytes(document)), contents(BUNDLE.read_bytes())
    assert fresh[0]["root"] == shipped[0]["root"]
    hint = "run: python -m tests.fake_onshape.sample"
    assert fresh[0]["requests"].keys() == shipped[0]["requests"].keys(), hint
    for request, reply in fresh[1].items():
        # An eigenvector's last digits depend on the processor's linear algebra.
        for made in (reply, shipped[1][request]):
            for body in made.get("bodies", {}).values() if isinstance(made.get("bodies"), dict) else ():
                axes = np.array([[axis[k] for k in "xyz"] for axis in body.pop("principalAxes")])
                assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-9)
        assert_alike(reply, shipped[1][request], f"{request}: {hint}")


def test_the_bundle_is_small_dated_1980_and_named_by_its_contents(document):
    data = bundle_bytes(document)
    assert data == bundle_bytes(sample_document())
    assert len(data) < 300_000
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.namelist() == sorted(archive.namelist())
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            if entry.filename != "manifest.json":
                digest = hashlib.sha256(archive.read(entry)).hexdigest()
                assert entry.filename == f"replies/{digest}"


def test_the_sample_shows_what_a_robot_can_have(document):
    truth = document.truth
    assert len(truth.leaves) == 28
    assert len(truth.bodies) == 11
    kinds = [joint.type for joint in truth.tree_joints]
    assert (kinds.count("REVOLUTE"), kinds.count("SLIDER")) == (9, 1)
    assert [edge.name for edge in truth.closings] == ["Rod upper pivot"]
    assert [relation.multiplier for relation in truth.relations] == [-1.0]
    sources = [place.instance.source for place in truth.places.values() if not place.instance.is_part]
    uses = {source.name: sources.count(source) for source in sources}
    assert uses == {"Servo": 2, "Gripper": 1, "Finger": 2}
    assert max(len(path) for path in truth.leaves) == 3
    assert any(home.linked for home in document.homes)


def test_every_joint_of_the_tree_has_limits_that_hold_its_saved_value(document):
    for joint in document.truth.tree_joints:
        low, high = joint.limits
        assert low < joint.value < high
        assert joint.value != 0.0


def test_the_loop_is_closed_and_masses_are_those_of_a_desk_arm(document):
    truth = document.truth
    assert max(np.abs(error).max() for error in truth.loop_errors().values()) < 1e-12
    assert 2.0 < truth.total_mass() < 5.0
    assert all(truth.inertial(body.parts).mass > 0.03 for body in truth.bodies)
    assert [body.fixed for body in truth.bodies].count(True) == 1


def test_colours_name_real_faces(document):
    for home in document.homes:
        for studio in home.studios:
            for part in studio.parts:
                assert set(part.face_colours) <= {face.name for face in part.solid.faces}, part.name
