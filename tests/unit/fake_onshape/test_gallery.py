"""The robots of the gallery: their shipped bundles are those of the documents."""

import hashlib
import io
import json
import zipfile

import pytest

from linkwright.pipeline.config.presets import OURS
from linkwright.stages.fetch.bundle.sample.section import SampleSourceSection
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.gallery import DOCUMENTS, FOLDER

LARGEST = 150_000
"""Size limit of a bundle [bytes]."""


@pytest.fixture(scope="module", params=DOCUMENTS)
def robot(request):
    """(name, document) of a robot."""
    return request.param, DOCUMENTS[request.param]()


def contents(data):
    """{request: parsed reply} of a bundle."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        return manifest, {
            request: json.loads(archive.read(f"replies/{digest}"))
            for request, digest in manifest["requests"].items()
        }


def leaves(value, path="", skip=""):
    """(path, leaf) of all leaves of a reply, without those under the key `skip`."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        if key != skip:
            yield from leaves(inner, f"{path}/{key}", skip)
    if not isinstance(value, dict | list):
        yield path, value


def test_the_source_offers_the_robots_that_are_shipped():
    names = SampleSourceSection.model_fields["robot"].annotation.__args__
    assert sorted(names) == sorted(path.stem for path in FOLDER.glob("*.zip")) == sorted(DOCUMENTS)
    assert set(names) <= {path.stem for path in (OURS / "robot").glob("*.yaml")}


def test_the_shipped_bundle_is_up_to_date(robot):
    name, document = robot
    shipped_bytes = (FOLDER / f"{name}.zip").read_bytes()
    (fresh, replies), (shipped, kept) = contents(bundle_bytes(document)), contents(shipped_bytes)
    hint = "run: python -m tests.fake_onshape.gallery"
    assert (fresh["root"], replies.keys()) == (shipped["root"], kept.keys()), hint
    for request in replies:
        # An eigenvector's last digits depend on the processor's linear algebra.
        ours, theirs = (dict(leaves(both[request], skip="principalAxes")) for both in (replies, kept))
        assert ours == pytest.approx(theirs, abs=1e-12), f"{request}: {hint}"


def test_the_bundle_is_small_and_the_same_at_each_writing(robot):
    name, document = robot
    data = bundle_bytes(document)
    assert data == bundle_bytes(DOCUMENTS[name]())
    assert len(data) <= LARGEST
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.namelist() == sorted(archive.namelist())
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            if entry.filename != "manifest.json":
                digest = hashlib.sha256(archive.read(entry)).hexdigest()
                assert entry.filename == f"replies/{digest}"


def test_parts_are_closed_and_their_colours_name_real_faces(robot):
    """Every edge is shared by two triangles in opposite directions."""
    _, document = robot
    parts = [part for home in document.homes for studio in home.studios for part in studio.parts]
    for part in parts:
        assert set(part.face_colours) <= {face.name for face in part.solid.faces}, part.name
        directed = [edge for a, b, c in part.solid.triangles.tolist() for edge in ((a, b), (b, c), (c, a))]
        assert len(directed) == len(set(directed)), part.name
        assert {(b, a) for a, b in directed} == set(directed), part.name
        assert part.solid.properties.volume > 0
