"""`linkwright new` on documents and files of all kinds: its file builds as it is, or ends with exactly the
problems that it names."""

import re
from pathlib import Path

import pytest
import yaml

from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.extended_sample import extended_sample
from tests.fake_onshape.gallery import DOCUMENTS as GALLERY
from tests.fake_onshape.prefixed import prefixed
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support import recorded
from tests.support.command import called, environment
from tests.support.other_robots import FILES, is_here

pytestmark = pytest.mark.slow

DOCUMENTS = {
    **GALLERY,
    "extended": extended_sample,
    "prefixed": prefixed,
}
"""Documents of the local Onshape; each is asked over HTTP."""

RECORDED = {
    "kbot": recorded.kbot_bundle,
    "kscale": recorded.kscale_bundle,
    "nb": recorded.nb_bundle,
}
"""Recordings of real documents; each is read from a bundle."""

UNWEIGHED = ("kscale", "nb")
"""Recordings without masses."""


def named_problems(here):
    """The codes and places that the robot's file names."""
    text = (here / "robot" / "it.yaml").read_text(encoding="utf-8")
    comments = re.sub(r"\n#   ", " ", text)
    return sorted(re.findall(r"^# - (E-[A-Z-]+) ([^:]*):", comments, re.MULTILINE))


def ended_with(here, environ):
    """The exit status of the build, and the codes and places of its problems, all of them."""
    done = called(here, "robot=it", "until=graph", "-v", environ=environ)
    return done.returncode, sorted(re.findall(r"^ *(E-[A-Z-]+) ([^:]*):", done.stderr, re.MULTILINE))


def agrees(here, environ):
    """Builds the robot as it is; whether it has no problem."""
    status, problems = ended_with(here, environ)
    assert problems == named_problems(here)
    assert status == (1 if problems else 0)
    return not problems


@pytest.mark.parametrize("name", DOCUMENTS)
def test_a_document_builds_as_its_file_says(tmp_path, name):
    with OnshapeServer(DOCUMENTS[name]()) as server:
        environ = environment(tmp_path, seeded=False, **server.environ)
        called(tmp_path, "new", "--deep", server.document_url(), "it", environ=environ, status=0)
        agrees(tmp_path, environ)


@pytest.mark.parametrize("name", RECORDED)
@recorded.needs_data
def test_a_recording_builds_as_its_file_says(tmp_path, name):
    (tmp_path / "it.zip").write_bytes(RECORDED[name]())
    environ = environment(tmp_path, seeded=False)
    called(tmp_path, "new", "it.zip", environ=environ, status=0)
    assert agrees(tmp_path, environ) == (name not in UNWEIGHED)


@pytest.mark.parametrize("name", FILES)
def test_a_file_builds_as_its_file_says(tmp_path, name):
    if not is_here(name):
        pytest.skip("the robots are not beside this clone")
    environ = environment(tmp_path, seeded=False)
    called(tmp_path, "new", str(FILES[name][1]), "it", environ=environ, status=0)
    assert agrees(tmp_path, environ)


def test_a_bundle_gives_the_same_file_as_its_document(tmp_path):
    (tmp_path / "it.zip").write_bytes(bundle_bytes(sample_document()))
    called(tmp_path, "new", "it.zip", environ=environment(tmp_path, seeded=False), status=0)
    bundle = yaml.safe_load((tmp_path / "robot" / "it.yaml").read_text(encoding="utf-8"))
    with OnshapeServer(sample_document()) as server:
        environ = environment(tmp_path, seeded=False, **server.environ)
        called(tmp_path, "new", "--deep", server.document_url(), "same", environ=environ, status=0)
    document = yaml.safe_load((tmp_path / "robot" / "same.yaml").read_text(encoding="utf-8"))
    sources = bundle.pop("source"), document.pop("source")
    assert sources == ({"path": "it.zip"}, {"url": server.document_url()})
    bundle["defaults"][0] = document["defaults"][0]
    assert bundle == document


@pytest.mark.slow
@pytest.mark.parametrize("name", [*GALLERY, *FILES])
def test_a_whole_build_passes_its_checks(tmp_path, shared_cache, name):
    if name in FILES and not is_here(name):
        pytest.skip("the robots are not beside this clone")
    document = GALLERY.get(name, sample_document)()
    with OnshapeServer(document) as server:
        more = {**server.environ, "LINKWRIGHT_CACHE": str(shared_cache)}
        environ = environment(tmp_path, seeded=False, **more)
        source = str(FILES[name][1]) if name in FILES else server.document_url()
        called(tmp_path, "new", source, "it", environ=environ, status=0)
        # The hull of the delta's frame holds its arms.
        colliders = "ladder" if name == "delta" else "hull"
        called(tmp_path, "robot=it", f"mesh={colliders}", environ=environ, status=0)
    assert Path(tmp_path / "outputs" / "it" / "it.xml").is_file()
