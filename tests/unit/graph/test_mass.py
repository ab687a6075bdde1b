"""What parts and links weigh: CAD's word, the user's in its place, or an estimate of the shape."""

import json
import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import yaml

from linkwright.stages.formats.meshes.body_arrays import Body
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.mass.mass_estimate import shape_of
from linkwright.stages.graph.onshape.mass.part_mass import part_masses
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import AssemblyError, ConfigError
from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame
from tests.support.building import bundle_of, plan_of, robot_of
from tests.support.checked import failures
from tests.support.kit import Kit
from tests.support.reported import codes, notes, only, reports
from tests.support.robots import pose
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_reader import inertial, robot_text
from tests.unit.graph.urdf.test_reader import joint as joint_text
from tests.unit.graph.urdf.test_reader import link as link_text

SIZE = (0.02, 0.03, 0.1)
VOLUME = 0.02 * 0.03 * 0.1


@pytest.fixture
def kit():
    """A large base with material; what else there is has none."""
    kit = Kit()
    kit.root.add(kit.studio.part("Base", solids.box(0.1, 0.1, 0.1), density=1000))
    return kit


def add(kit, name, size=SIZE, count=1, **more):
    part = kit.studio.part(name, solids.box(*size), **more)
    for _ in range(count):
        kit.root.add(part)


def weights(kit, bundle=None, **mass):
    """What each part weighs by title, and the log."""
    bundle = bundle or bundle_of(kit.document)
    assembly = read_assembly(bundle.body(bundle.definition))
    log = Diagnostics()
    by_path = part_masses(assembly, bundle, plan_of(mass=mass).mass, log)
    return {assembly.occurrences[path].title: weight for path, weight in by_path.items()}, log


def box_inertia(mass, x, y, z):
    return mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])


def is_box(inertial, mass, size=SIZE):
    """Whether this is a box of this size."""
    assert inertial.mass == pytest.approx(mass, rel=1e-9)
    np.testing.assert_allclose(inertial.com, [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(inertial.inertia, box_inertia(mass, *size), rtol=1e-9, atol=1e-15)


def with_the_base_alone(bundle):
    """The bundle whose replies about masses know only the Base."""
    blobs = dict(bundle.blobs)
    for studio in bundle.studios:
        for digest in studio.mass:
            reply = json.loads(blobs[digest])
            heavy = max(reply["bodies"], key=lambda key: reply["bodies"][key]["mass"][0])
            reply["bodies"] = {heavy: reply["bodies"][heavy]}
            blobs[digest] = json.dumps(reply).encode()
    return replace(bundle, blobs=blobs)


def without_triangles(bundle):
    return replace(bundle, studios=tuple(replace(studio, tessellation=None) for studio in bundle.studios))


SCREW, NUT = (0.01, 0.01, 0.01), (0.02, 0.02, 0.02)
ESTIMATED = "W-MASS-ESTIMATED", "Bar <1> (and 1 more like it)"


WEIGHED = {
    "CAD's own": (1, SIZE, 2000, {}, 2000 * VOLUME, None, ""),
    "dense": (2, SIZE, None, {"missing": "density", "density": 500}, 500 * VOLUME, ESTIMATED, "0.06 kg"),
    "auto small": (2, SCREW, None, {}, 1200e-6, ESTIMATED, ""),
    "auto large": (1, SIZE, None, {}, None, ("E-MASS", "Bar <1>"), ""),
    "auto together": (14, NUT, None, {}, None, ("E-MASS", "Bar <10>"), "14 of them"),  # 0.7 % each
    "error": (1, SCREW, None, {"missing": "error"}, None, ("E-MASS", "Bar <1>"), ""),
    "ignore": (1, SCREW, None, {"missing": "ignore"}, 0, ("W-MASS-IGNORED", "Bar <1>"), ""),
    "the user's": (1, SIZE, None, {"parts": {"Bar": {"mass": 0.3}}}, 0.3, None, ""),
    "weightless": (1, SIZE, 1000, {"parts": {"Bar": {"mass": 0}}}, 0, None, ""),
    "heavy": (3, SIZE, 1000, {"parts": {"Bar": {"mass": 42}}}, 42, ("W-DENSITY", "Bar <1>"), "7e+05 kg/m³"),
    "light": (3, SIZE, 1000, {"parts": {"Bar": {"mass": 1e-5}}}, 1e-5, ("W-DENSITY", "Bar <1>"), "0.1667 kg"),
    "no match": (1, SIZE, 1000, {"parts": {"Nut": {}, "*": {}}}, None, ("E-GLOB", "mass.parts"), "'Nut'"),
}  # fmt: skip
"""Count, size, the density in CAD, the section `mass` → the mass of each [kg], the report and its words."""


@pytest.mark.parametrize("case", WEIGHED)
def test_a_part_weighs(kit, case):
    count, size, density, mass, kilograms, report, words = WEIGHED[case]
    add(kit, "Bar", size, count, density=density)
    masses, log = weights(kit, **mass)
    assert reports(log)[:1] == ([report] if report else [])
    assert not report or words in notes(log)[0].message
    if kilograms is not None:
        assert len(reports(log)) == bool(report)
        for number in range(1, count + 1):
            is_box(masses[f"Bar <{number}>"][0], kilograms, size)
            assert masses[f"Bar <{number}>"][1] == pytest.approx(np.prod(size), rel=1e-12)
        assert masses["Bar <1>"].estimated == (report == ESTIMATED)


def test_an_estimate_is_of_cads_volume_not_of_triangles(kit):
    pin = kit.studio.part("Pin", solids.cylinder(0.01, 0.05, segments=12))
    kit.root.add(pin)
    masses, _ = weights(kit, missing="density", density=1000)
    assert masses["Pin <1>"][0].mass == pytest.approx(1000 * pin.volume, rel=1e-12)


def test_the_hint_to_paste_resolves_every_missing_mass(kit):
    add(kit, "Bar [x]", count=2)
    add(kit, "Rod")
    nested = kit.document.assembly("Sub")
    nested.add(kit.studio.part("Base", solids.box(*SIZE)))
    kit.root.add(nested)
    _, log = weights(kit)
    assert codes(log) == ["E-MASS"] * 3
    (hint,) = [problem.hint for problem in log.problems if "YAML" in problem.hint]
    for text in hint.split("in YAML: ")[1].split("  or each [kg]: "):
        masses, log = weights(kit, **yaml.safe_load(text)["mass"])
        assert log.problems == []
        assert masses["Bar [x] <2>"][0].mass == pytest.approx(1200 * VOLUME, rel=1e-2)
        assert masses["Sub <1>/Base <1>"][0].mass == pytest.approx(1200 * VOLUME, rel=1e-2)
        assert masses["Base <1>"][0].mass == pytest.approx(1.0)


@pytest.mark.parametrize("glob", ["Bar", "Ba*", "Bar <?>", "*", "Bar <2>"])
def test_a_mass_of_the_users_scales_the_inertia(kit, glob):
    add(kit, "Bar", density=1000, count=2)
    masses, log = weights(kit, parts={glob: {"mass": 0.3}})
    assert log.problems == []
    is_box(masses["Bar <2>"][0], 0.3)
    is_box(masses["Bar <1>"][0], 0.3 if glob != "Bar <2>" else 1000 * VOLUME)


INERTIA = [2e-4, 3e-4, 4e-4, 1e-5, -2e-5, 3e-5]


@pytest.mark.parametrize(
    ("entries", "mass", "com", "moments"),
    [
        ({"*": {"density": 7000, "com": [0.1, 0, 0]}, "Bar": {"mass": 0.5}}, 0.5, [0.1, 0, 0], None),
        ({"Bar": {"mass": 0.5}, "*": {"density": 7000}}, 7000 * VOLUME, [0, 0, 0], None),
        ({"Bar": {"inertia": INERTIA}}, 1000 * VOLUME, [0, 0, 0], INERTIA),
    ],
    ids=["mass over density", "density over mass", "inertia"],
)
def test_later_entries_win_value_by_value(kit, entries, mass, com, moments):
    add(kit, "Bar", density=1000)
    inertial = weights(kit, parts=entries)[0]["Bar <1>"][0]
    assert inertial.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(inertial.com, com, atol=1e-12)
    if moments:
        rows, columns = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
        np.testing.assert_array_equal(inertial.inertia[rows, columns], moments)
        np.testing.assert_array_equal(inertial.inertia, inertial.inertia.T)


def test_a_part_that_no_reply_knows_is_weighed_by_its_triangles(kit):
    add(kit, "Bar")
    bundle = with_the_base_alone(bundle_of(kit.document))
    assert "does not know" in weights(kit, bundle)[1].problems[0].message
    masses, _ = weights(kit, bundle, missing="density", density=900)
    assert masses["Bar <1>"][:2] == (masses["Bar <1>"][0], pytest.approx(VOLUME, rel=1e-9))
    is_box(masses["Bar <1>"][0], 900 * VOLUME)
    masses, log = weights(kit, bundle, parts={"Bar": {"mass": 0.2}})
    is_box(masses["Bar <1>"][0], 0.2)
    assert log.problems == []


def test_com_and_inertia_are_asked_for_without_triangles(kit):
    add(kit, "Bar")
    bundle = without_triangles(bundle_of(kit.document))
    _, log = weights(kit, bundle, parts={"Bar": {"mass": 0.2}})
    assert reports(log)[0] == ("E-MASS", "Bar <1>")
    assert "com and inertia" in log.problems[0].hint
    weight = {"mass": 0.2, "com": [0, 0, 0.01], "inertia": [1e-4, 1e-4, 1e-4]}
    masses, log = weights(kit, bundle, parts={"Bar": weight})
    assert (masses["Bar <1>"][0].com[2], log.problems) == (0.01, [])


def test_a_sheet_weighs_nothing_but_what_the_user_says(kit):
    kit.root.add(kit.studio.sheet("Sticker", solids.box(*SIZE)))
    masses, log = weights(kit)
    assert (masses["Sticker <1>"][0].mass, reports(log)) == (0, [("W-BODY-TYPE", "Sticker <1>")])
    masses, log = weights(kit, parts={"Sticker": {"mass": 0.01}})
    assert reports(log) == []
    x, y, z = SIZE
    # A box's walls: each pair of plates by its textbook moments about x.
    areas = np.array([2 * y * z, 2 * x * z, 2 * x * y]) / (2 * (y * z + x * z + x * y))
    about_x = areas @ [(y * y + z * z) / 12, z * z / 12 + y * y / 4, y * y / 12 + z * z / 4]
    assert masses["Sticker <1>"][0].inertia[0, 0] == pytest.approx(0.01 * about_x, rel=1e-9)


def body(points, triangles):
    corners = np.array(triangles, dtype=np.int32).reshape(-1, 3)
    return Body("b", np.array(points, dtype=float), corners, (), np.zeros(len(triangles), dtype=np.uint16))


CORNER = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def test_open_triangles_are_a_ball_at_the_middle_of_their_box():
    shape = shape_of(body(CORNER, FACES[:3]), 1e-4)
    assert (shape.kind, shape.volume, shape.inertial.mass) == ("ball", 1e-4, 1.0)
    np.testing.assert_allclose(shape.inertial.com, [0.05, 0.05, 0.05])
    radius = (1e-4 / (4 / 3 * math.pi)) ** (1 / 3)
    np.testing.assert_allclose(shape.inertial.inertia, 2 / 5 * radius**2 * np.eye(3), rtol=1e-12)


def test_closed_triangles_are_a_solid_but_not_of_another_volume():
    shape = shape_of(body(CORNER, FACES), 0.0)
    assert shape.kind == "solid"
    assert shape.volume == pytest.approx(1e-3 / 6, rel=1e-12)
    np.testing.assert_allclose(shape.inertial.com, [0.025] * 3, rtol=1e-12)
    assert shape_of(body(CORNER, FACES), 1e-3).kind == "ball"
    assert shape_of(body(CORNER, FACES), None).kind == "shell"
    assert shape_of(body(CORNER, FACES[:3]), 0.0).kind == "shell"
    assert shape_of(body(CORNER, []), 1e-3) is None


def test_the_shell_of_one_triangle_is_a_lamina():
    shape = shape_of(body([(0, 0, 0), (0.3, 0, 0), (0, 0.2, 0)], [(0, 1, 2)]), 0.0)
    np.testing.assert_allclose(shape.inertial.com, [0.1, 0.2 / 3, 0], atol=1e-15)
    # A right triangle about its centroid: m h²/18 about each leg's direction, m b h/36 across.
    xx, yy, xy = 0.2**2 / 18, 0.3**2 / 18, 0.3 * 0.2 / 36
    np.testing.assert_allclose(
        shape.inertial.inertia, [[xx, xy, 0], [xy, yy, 0], [0, 0, xx + yy]], rtol=1e-12, atol=1e-15
    )


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"mass": 1, "density": 1}, "a mass or a density, not both"),
        ({"inertia": [1, 1]}, "must be [ixx, iyy, izz] or"),
        ({"inertia": [1, 1, 3]}, "none above the sum of the other two"),
        ({"inertia": [1, 1, 1, 2, 0, 0]}, "positive moments"),
        ({"density": 0}, "greater than 0"),
        ({"com": [1, 2]}, "a list of 3 numbers"),
    ],
)
def test_mass_properties_that_cannot_be_are_refused(entry, message):
    with pytest.raises(ConfigError) as caught:
        plan_of(mass={"parts": {"Bar": entry}})
    assert message in str(caught.value)


def test_a_glob_without_a_match_lists_what_there_is(kit):
    assert only(weights(kit, parts={"Nut": {"mass": 1}})[1]).hint == "parts are: Base"


def test_an_estimate_is_in_the_parts_own_frame():
    kit = Kit()
    part = kit.studio.part("Bar", solids.box(*SIZE, at=(0.5, 0.0, 0.0)))
    kit.root.add(part, pose=pose(np.random.default_rng(0)))
    inertial = weights(kit, missing="density")[0]["Bar <1>"][0]
    np.testing.assert_allclose(inertial.com, [0.5, 0, 0], rtol=1e-12, atol=1e-12)


def test_a_robot_two_millimetres_long_gets_the_least_inertia(tmp_path):
    kit = Kit()
    sizes = {"Base": 2e-3, "Link": 5e-4, "Tip": 1e-4}
    base, link, tip = (kit.root.add(kit.bar(name, (size, size, size))) for name, size in sizes.items())
    kit.root.revolute("Hinge", (link, np.eye(4)), (base, frame((0, 0, 2e-3))), limits=(-1, 1))
    kit.root.revolute("Wrist", (tip, np.eye(4)), (link, frame((0, 0, 5e-4))), limits=(-1, 1))
    robot = robot_of(kit.document)
    least = [("W-INERTIA-LEAST", "link"), ("W-INERTIA-LEAST", "tip")]
    assert [report for report in reports(robot) if "INERTIA" in report[0]] == least
    assert failures(tmp_path, robot) == []
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    for size, name in ((5e-4, "link"), (1e-4, "tip")):
        assert 1e-14 <= model.body(name).inertia.min() <= model.body(name).inertia.max() < 1.01e-14
        assert model.body(name).mass[0] == pytest.approx(1000 * size**3)


@pytest.mark.parametrize("moments", [(1e-16, 1e-16, 1e-16), (1e-20, 1e-9, 1e-9), (1e-18, 3e-4, 3e-4)])
def test_a_speck_in_a_urdf_gets_the_least_too(moments, tmp_path):
    text = robot_text(link_text("a"), link_text("b", inertial(1e-15, *moments)), joint_text("j", "a", "b"))
    for policy in ("refuse", "project"):
        robot = urdf_robot(text, policy=policy)
        assert only(robot, "W-INERTIA-LEAST").where == "b"
        assert robot.link("b").inertial.mass == 1e-14
    assert failures(tmp_path, robot) == []


def robot_with_screws(**mass):
    """A base of 1 kg, and an arm with two screws without material."""
    kit = Kit()
    base = kit.root.add(kit.studio.part("Base", solids.box(0.1, 0.1, 0.1), density=1000))
    arm = kit.root.add(kit.studio.part("Arm", solids.box(*SIZE), density=2000))
    screw = kit.studio.part("Screw", solids.box(0.01, 0.01, 0.01))
    screws = [kit.root.add(screw) for _ in range(2)]
    kit.root.revolute("Hinge", (arm, frame()), (base, frame((0, 0, 0.1))), limits=(-1, 1))
    for number, screw in enumerate(screws):
        kit.root.fasten(f"Screwed {number}", (screw, frame()), (arm, frame((0.01 * number, 0, 0.02))))
    return robot_of(kit.document, plan_of(mass=mass))


def test_a_total_scales_what_is_estimated_and_nothing_else():
    plain, whole = robot_with_screws(), robot_with_screws(total=1.15)
    (before, after) = (
        {part.name: part for link in robot.links for part in link.parts} for robot in (plain, whole)
    )
    assert sum(link.inertial.mass for link in whole.links) == pytest.approx(1.15, rel=1e-12)
    factor = (1.15 - (1.0 + 2000 * VOLUME)) / (2 * 1200 * 1e-6)
    for name, part in after.items():
        times = factor if name.startswith("Screw") else 1.0
        assert part.inertial.mass == pytest.approx(before[name].inertial.mass * times, rel=1e-12)
        np.testing.assert_allclose(part.inertial.inertia, before[name].inertial.inertia * times, rtol=1e-12)
    # The arm by the parallel axis theorem, from its parts alone.
    (link,) = (link for link in whole.links if any(part.name == "Arm <1>" for part in link.parts))
    centres = [(part.link_from_part @ [*part.inertial.com, 1])[:3] for part in link.parts]
    com = np.average(centres, axis=0, weights=[part.inertial.mass for part in link.parts])
    np.testing.assert_allclose(link.inertial.com, com, atol=1e-12)
    inertia = np.zeros((3, 3))
    for part, centre in zip(link.parts, centres, strict=True):
        turned, arm = part.link_from_part[:3, :3], centre - com
        inertia += turned @ part.inertial.inertia @ turned.T
        inertia += part.inertial.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(link.inertial.inertia, inertia, rtol=1e-9, atol=1e-15)
    assert f"scaled by {factor:.4g}" in only(whole, "I-MASS-TOTAL").message


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        ({"total": 1.05}, "without its 2 parts of estimated mass, the robot already weighs 1.12 kg"),
        ({"total": 2, "parts": {"Screw": {"mass": 0.1}}}, "weighs 1.32 kg, and no mass is estimated"),
        ({"total": 2, "links": {"arm": {"mass": 0.5}}}, "weighs 1.5 kg, and no mass is estimated"),
    ],
)
def test_a_total_that_cannot_be_is_an_error(mass, message):
    with pytest.raises(AssemblyError, match=message):
        robot_with_screws(**mass)
