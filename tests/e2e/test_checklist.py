"""The points that a model made by hand meets (`tests.support.checklist`), on robots of every source."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from lxml import etree

from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.gallery import DOCUMENTS
from tests.fake_onshape.random_document import documents
from tests.support.checklist import Built, compiled, simulated, text
from tests.support.command import called, environment
from tests.support.other_robots import FILES, is_here, source_of

pytestmark = pytest.mark.slow

STILL = (*text.POINTS, *compiled.POINTS)
"""Points for any robot, also for one that cannot hold itself."""

POINTS = (*STILL, *simulated.POINTS)

BASES = {"so101": "fixed", "duck": "free", "reachy2": "fixed"}

LIGHT = ("mesh=hull", "mesh.visual.max_faces=2000000")
"""The colliders of the robots of others cost minutes, and have tests of their own."""


SHOULDERS = "[l_shoulder_ball_link,l_elbow_ball_link],[r_shoulder_ball_link,r_elbow_ball_link]"
SETTLED = {"reachy2": [f"contact.exclude=[{SHOULDERS}]"]}
"""The findings of a build that are settled as it says: as one hull each, these two overlap at home."""


def built(name, folder, cache):
    mass: float | None = None
    if name in DOCUMENTS:
        mass, typed = DOCUMENTS[name]().truth.total_mass(), [f"robot={name}"]
    else:
        typed = [
            *source_of(name),
            f"root={BASES[name]}",
            "actuators=position",
            *LIGHT,
            *SETTLED.get(name, ()),
        ]
        if FILES[name][0] == "urdf":
            mass = sum(
                float(element.get("value")) for element in etree.parse(str(FILES[name][1])).iter("mass")
            )
    environ = environment(folder, seeded=False, LINKWRIGHT_CACHE=str(cache))
    done = called(folder, *typed, "output=out", environ=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    return Built(folder / "out", mass, cad=name not in FILES)


@pytest.fixture(
    scope="module",
    params=[*DOCUMENTS, *(pytest.param(name, marks=pytest.mark.slow) for name in FILES)],
)
def robot(request, tmp_path_factory, shared_cache):
    if not is_here(request.param):
        pytest.skip("needs the robots of others")
    return built(request.param, tmp_path_factory.mktemp(request.param), shared_cache)


UNSTABLE = {"C-TRIAL", "C-TIME-STEP"}
"""What a random mechanism may fail: it starts deep in the ground, or needs steps below 2 ms."""


@pytest.mark.slow
@settings(max_examples=10, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(st.booleans().flatmap(lambda loops: documents(everything=True, loops=loops)))
def test_random_documents_meet_the_points_of_files(document):
    with TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "random.zip").write_bytes(bundle_bytes(document))
        typed = ["source=bundle", "source.path=random.zip", "mesh=hull", "contact.self=none", "output=out"]
        done = called(folder, *typed)
        assert done.returncode in {0, 3}, done.stdout + done.stderr
        checks = json.loads((folder / "out/report.json").read_text())["checks"]
        failed = {it["code"] for it in checks if not it["passed"] and it["level"] == "error"}
        assert failed <= UNSTABLE, done.stdout
        made = Built(folder / "out", document.truth.total_mass())
        assume(made.model.nq)
        assert [(point.__name__, fault) for point in STILL for fault in point(made)] == []


@pytest.mark.parametrize("point", POINTS, ids=lambda it: it.__name__)
def test_a_point_of_the_checklist(robot, point):
    assert list(point(robot)) == []
