"""Every fault that is planted in a finished build is found, and named; what is no fault raises no alarm."""

import functools
import random
import shutil
import tempfile
from collections.abc import Callable
from itertools import cycle
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

from linkwright.pipeline.reference import MUTATIONS
from linkwright.stages.validate.checks import MODEL_CHECKS
from tests.fake_onshape.random_document import documents
from tests.support.building import robot_of
from tests.support.faults import BUILD, page
from tests.support.faults.fault import NothingToChange, catches, plant
from tests.support.mutated_builds import FORMATS, Build, built, checks_of, rover, sample

SEED = 20261123
"""The seed of the faults of the default run."""

OTHER_SEEDS = {"sample": 7919, "rover": 104729}

BUILDS = {"sample": sample, "rover": rover}

Builds = Callable[[str], Build]


@pytest.fixture(scope="module")
def builds(tmp_path_factory):
    """The two builds, each made when it is first asked for."""
    made: dict[str, Build] = {}

    def get(name):
        if name not in made:
            made[name] = BUILDS[name](tmp_path_factory.mktemp(name) / "build")
        return made[name]

    return get


@pytest.fixture
def fewer_checks(monkeypatch):
    """Only the checks that name faults: a simulation takes seconds."""
    codes = {code for fault in BUILD for code in fault.codes}
    kept = [check for check in MODEL_CHECKS if check.code in codes]
    monkeypatch.setattr("linkwright.stages.validate.checks.MODEL_CHECKS", kept)


@pytest.mark.slow
@pytest.mark.usefixtures("fewer_checks", "no_score")
@pytest.mark.parametrize("fault", BUILD, ids=lambda fault: fault.title)
def test_a_planted_fault_is_found_and_named(fault, builds, tmp_path):
    """In the sample, or where that lacks the thing in the other robot."""
    if fault.file == "usd":
        pytest.importorskip("pxr")
    try:
        build = builds("sample")
        # What cannot be read must not stop the checks of the other files.
        whole = fault.kind == "XML broken"
        planted = plant(fault, build.folder, build.name, tmp_path / "sample", SEED, whole=whole)
        folder = tmp_path / "sample"
    except NothingToChange:
        build, folder = builds("rover"), tmp_path / "rover"
        planted = plant(fault, build.folder, build.name, folder, SEED)
    checks = checks_of(folder)
    assert catches(fault, planted, checks), (planted, [check for check in checks if not check.passed])


@pytest.mark.slow
@pytest.mark.usefixtures("fewer_checks")
@pytest.mark.parametrize("name", BUILDS)
def test_faults_of_other_seeds_are_found(name, builds, tmp_path, request):
    """Those of the rover in the whole build, of which everything is made that a check makes."""
    build, missed, whole = builds(name), [], name == "rover"
    if not whole:
        request.getfixturevalue("no_score")
    for number, fault in enumerate(BUILD):
        folder = tmp_path / str(number)
        try:
            planted = plant(fault, build.folder, build.name, folder, OTHER_SEEDS[name], whole=whole)
        except NothingToChange:
            continue
        checks = checks_of(folder)
        shutil.rmtree(folder)
        if not catches(fault, planted, checks):
            missed.append((fault.title, planted))
    assert missed == []


def test_there_are_faults_of_every_kind_that_others_plant():
    assert len({fault.title for fault in BUILD}) == len(BUILD) >= 279
    assert {fault.simcheck for fault in BUILD} >= SIMCHECK


SIMCHECK = {
    "millimetre units",
    "too small",
    "reversed axis",
    "zero axis",
    "swapped limits",
    "limits in degrees",
    "zero inertia",
    "inertia against the triangle inequality",
    "negative inertia",
    "grams as kilograms",
    "zero mass",
    "no inertial",
    "missing collision",
    "offset collision",
    "centre of mass off the part",
    "broken mesh path",
    "joint inside its parent",
}
"""What `simcheck bench` of simcheck 0.2.0 plants."""


def test_the_table_of_the_docs_is_true():
    assert MUTATIONS.read_text(encoding="utf-8") == page.markdown(), "run: python -m tests.config.regenerate"


def commented(root, rng):
    for node in rng.sample(list(root.iter("*")), 5):
        if node.getparent() is not None:
            node.addprevious(etree.Comment(" looked at "))


def reordered(root, rng):
    for node in root.iter("*"):
        items = list(node.attrib.items())
        rng.shuffle(items)
        node.attrib.clear()
        node.attrib.update(items)


def painted(root, _):
    """Other names of materials."""
    for node in root.iter("*"):
        for key in ("material", "name") if node.tag == "material" else ("material",):
            if node.get(key):
                node.set(key, f"paint_{node.get(key)}")


def spread(root, rng):
    for node in root.iter("*"):
        node.tail = (node.tail or "") + rng.choice(("\n", "\t ", "  \n\n"))
        if len(node):
            node.text = (node.text or "") + "\n   "


def rewritten(root, rng):
    """Other digits for the same numbers."""
    for node in root.iter("*"):
        for key, value in node.attrib.items():
            if key != "version":
                node.set(key, redrawn(value, rng))
        if not len(node):
            node.text = redrawn(node.text or "", rng)


def redrawn(text, rng):
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text
    # Whole numbers are counts: MuJoCo takes no others for some.
    style = rng.choice((".17g", ".16e", "+.17g"))
    return "  ".join(f"{number:{style}}" for number in numbers) if "." in text else text


HARMLESS = {
    "comments": commented,
    "the order of attributes": reordered,
    "names of materials": painted,
    "white space": spread,
    "digits": rewritten,
}


@functools.cache
def warned(folder):
    """The checks that warn of a build as it was made."""
    return frozenset(check.name for check in checks_of(folder) if check.warns)


@pytest.mark.usefixtures("fewer_checks", "no_score")
@pytest.mark.parametrize("edit", ["all", *(pytest.param(kind, marks=pytest.mark.slow) for kind in HARMLESS)])
@pytest.mark.parametrize("name", BUILDS)
def test_what_means_nothing_raises_no_alarm(edit, name, builds, tmp_path):
    build = builds(name)
    folder = shutil.copytree(build.folder, tmp_path / "edited")
    rng = random.Random(f"{edit} {SEED}")
    kinds = list(HARMLESS) if edit == "all" else [edit]
    for file in (*(f"{build.name}.{ending}" for ending in ("urdf", "xml", "sdf", "srdf")), "scene.xml"):
        root = etree.parse(folder / file).getroot()
        for kind in kinds:
            # SDF and SRDF have no names of materials.
            if kind != "names of materials" or not file.endswith(("sdf", "srdf")):
                before = etree.tostring(root)
                HARMLESS[kind](root, rng)
                assert etree.tostring(root) != before
        (folder / file).write_bytes(etree.tostring(root))
    checks = checks_of(folder)
    assert [check for check in checks if check.fails] == []
    assert {check.name for check in checks if check.warns} == warned(build.folder)


ADDED = {
    "a table": '<body name="table" pos="2 0 0.2"><geom type="box" size="0.3 0.3 0.2"/></body>',
    "a ball": '<body name="ball" pos="2 0 0.05"><freejoint/><geom size="0.05" mass="0.2"/></body>',
    "a cupboard": '<body name="cupboard" pos="2 0 0.5"><body name="door"><joint axis="0 0 1"/>'
    '<geom type="box" size="0.3 0.02 0.3" mass="1"/></body></body>',
    "a wall": '<geom type="box" size="0.02 1 1" pos="2 0 1"/>',
    "lights and cameras": '<light pos="1 1 2"/><camera name="above" pos="0 0 3"/>',
    "a mark": '<site name="goal" pos="1 0 0"/><geom type="box" size="1 1 1" contype="0" conaffinity="0"/>',
}


@pytest.mark.slow
@pytest.mark.parametrize(("thing", "name"), [*zip(ADDED, cycle(BUILDS))])
def test_what_is_put_beside_the_robot_raises_no_alarm(thing, name, builds, tmp_path):
    """By all checks, with the ground moved along itself, under another name and look; also in the copy of the
    scene that the Python package has."""
    build = builds(name)
    folder = shutil.copytree(build.folder, tmp_path / "edited")
    root = etree.parse(folder / "scene.xml").getroot()
    world = root.find("worldbody")
    world.extend(etree.fromstring(f"<worldbody>{ADDED[thing]}</worldbody>"))
    floor = world.find("geom[@name='floor']")
    floor.attrib.update(
        {"name": "meadow", "pos": "1 2 0", "euler": "0 0 1", "rgba": "0 1 0 1", "size": "9 9 1"}
    )
    root.find("visual/headlight").set("ambient", "1 1 1")
    for scene in folder.rglob("scene.xml"):
        scene.write_bytes(etree.tostring(root))
    assert odd(folder) == odd(build.folder)


@functools.cache
def odd(folder):
    """(name, code) of the checks that a folder does not pass."""
    return frozenset((check.name, check.code) for check in checks_of(folder) if not check.passed)


@pytest.mark.slow
@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(st.booleans().flatmap(lambda loops: documents(everything=True, loops=loops)), st.booleans())
def test_random_good_documents_raise_no_alarm(document, free):
    held = robot_of(document).root.name == "world"
    base = "free" if free and not held else "auto"
    # Parts that are drawn anywhere may stand in the ground, which is rightly an error.
    keys = {"root": {"base": base}, "actuators": {"*": {"type": "motor"}}, "ground": {"kind": "none"}}
    keys["export"] = FORMATS
    with tempfile.TemporaryDirectory() as place:
        build = built(document, Path(place) / "build", keys)
        assert [check for check in checks_of(build.folder) if check.fails] == []
