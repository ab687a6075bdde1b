"""What parts and links weigh: CAD's word, the user's in its place, or an estimate of the shape."""

import json
import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import yaml

from linkwright.stages.formats.triangles import Body
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.mass.mass_estimate import shape_of
from linkwright.stages.graph.onshape.mass.part_mass import weighed
from linkwright.stages.graph.passes.link_mass import check_links, with_given_masses
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import ZERO
from linkwright.stages.robot.errors import AssemblyError, ConfigError
from linkwright.stages.robot.model.robot import Inertial, frozen
from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame
from tests.support.building import bundle_of, plan_of, robot_of, write
from tests.support.checked import checked
from tests.support.kit import Kit
from tests.support.robots import joint, pose, robot_with
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_reader import inertial, robot_text
from tests.unit.graph.urdf.test_reader import joint as joint_text
from tests.unit.graph.urdf.test_reader import link as link_text

SIZE = (0.02, 0.03, 0.1)
VOLUME = 0.02 * 0.03 * 0.1


@pytest.fixture
def kit() -> Kit:
    """A large base with material; what else there is has none."""
    kit = Kit()
    kit.root.add(kit.studio.part("Base", solids.box(0.1, 0.1, 0.1), density=1000))
    return kit


def add(kit: Kit, name: str, size=SIZE, count: int = 1, **more) -> None:
    part = kit.studio.part(name, solids.box(*size), **more)
    for _ in range(count):
        kit.root.add(part)


def weights(kit: Kit, bundle=None, **mass):
    """(what each part weighs by title, log)."""
    bundle = bundle or bundle_of(kit.document)
    assembly = read_assembly(bundle.body(bundle.definition))
    log = Diagnostics()
    found = weighed(assembly, bundle, plan_of(mass=mass).mass, log)
    return {assembly.occurrences[path].title: weight for path, weight in found.items()}, log


def told(log: Diagnostics) -> list[tuple[str, str]]:
    return [(one.code, one.where) for one in (*log.problems, *log.found)]


def box_inertia(mass: float, x: float, y: float, z: float) -> np.ndarray:
    return mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])


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
    return replace(bundle, studios=tuple(replace(one, tessellation=None) for one in bundle.studios))


def test_masses_of_cad_are_taken_as_they_are(kit):
    add(kit, "Bar", density=2000)
    found, log = weights(kit)
    inertial, volume, estimated = found["Bar <1>"]
    assert not estimated
    assert inertial.mass == pytest.approx(2000 * VOLUME, rel=1e-12)
    assert volume == pytest.approx(VOLUME, rel=1e-12)
    np.testing.assert_allclose(inertial.inertia, box_inertia(inertial.mass, *SIZE), rtol=1e-9, atol=1e-15)
    assert told(log) == []


def test_a_density_resolves_what_has_none_with_the_inertia_of_its_solid(kit):
    add(kit, "Bar", count=2)
    found, log = weights(kit, missing="density", density=500)
    for title in ("Bar <1>", "Bar <2>"):
        inertial, _, estimated = found[title]
        assert estimated
        assert inertial.mass == pytest.approx(500 * VOLUME, rel=1e-12)
        np.testing.assert_allclose(inertial.com, [0, 0, 0], atol=1e-12)
        expected = box_inertia(inertial.mass, *SIZE)
        np.testing.assert_allclose(inertial.inertia, expected, rtol=1e-9, atol=1e-15)
    assert told(log) == [("W-MASS-ESTIMATED", "Bar <1> (and 1 more like it)")]
    assert f"{2 * 500 * VOLUME:.3g} kg" in log.found[0].message


def test_the_mass_of_an_estimate_is_that_of_cads_volume_not_of_its_coarse_triangles(kit):
    part = kit.studio.part("Pin", solids.cylinder(0.01, 0.05, segments=12))
    kit.root.add(part)
    found, _ = weights(kit, missing="density", density=1000)
    volume = part.volume
    assert found["Pin <1>"][0].mass == pytest.approx(1000 * volume, rel=1e-12)


def test_auto_estimates_what_is_small_and_refuses_what_is_not(kit):
    add(kit, "Screw", (0.01, 0.01, 0.01), count=5)
    add(kit, "Bar")
    found, log = weights(kit)
    assert told(log) == [
        ("E-MASS", "Bar <1>"),
        ("W-MASS-ESTIMATED", "Screw <1> (and 4 more like it)"),
    ]
    assert found["Screw <5>"][0].mass == pytest.approx(1200 * 1e-6, rel=1e-12)


def test_auto_refuses_small_ones_that_are_much_together(kit):
    add(kit, "Screw", (0.02, 0.02, 0.02), count=14)  # 0.7 % each, 10 % of all
    assert told(weights(kit)[1])[0][0] == "E-MASS"
    assert "14 of them" in weights(kit)[1].problems[0].message


def test_error_refuses_all_and_ignore_none(kit):
    add(kit, "Screw", (0.01, 0.01, 0.01))
    assert told(weights(kit, missing="error")[1]) == [("E-MASS", "Screw <1>")]
    found, log = weights(kit, missing="ignore")
    assert found["Screw <1>"][0].mass == 0
    assert told(log) == [("W-MASS-IGNORED", "Screw <1>")]


def test_what_is_to_be_pasted_resolves_every_missing_mass(kit):
    add(kit, "Bar [x]", count=2)
    add(kit, "Rod")
    nested = kit.document.assembly("Sub")
    nested.add(kit.studio.part("Base", solids.box(*SIZE)))
    kit.root.add(nested)
    _, log = weights(kit)
    assert [code for code, _ in told(log)] == ["E-MASS"] * 3
    hints = [one.hint for one in log.problems if "YAML" in one.hint]
    assert len(hints) == 1
    first, each = hints[0].split("in YAML: ")[1].split("  or each [kg]: ")
    for text in (first, each):
        found, log = weights(kit, **yaml.safe_load(text)["mass"])
        assert log.problems == []
        assert found["Bar [x] <2>"][0].mass == pytest.approx(1200 * VOLUME, rel=1e-2)
        assert found["Sub <1>/Base <1>"][0].mass == pytest.approx(1200 * VOLUME, rel=1e-2)
        assert found["Base <1>"][0].mass == pytest.approx(1.0)


@pytest.mark.parametrize("glob", ["Bar", "Ba*", "Bar <?>", "*", "Bar <2>"])
def test_a_mass_of_the_users_scales_the_inertia(kit, glob):
    add(kit, "Bar", density=1000, count=2)
    found, log = weights(kit, parts={glob: {"mass": 0.3}})
    assert log.problems == []
    inertial = found["Bar <2>"][0]
    assert inertial.mass == 0.3
    np.testing.assert_allclose(inertial.inertia, box_inertia(0.3, *SIZE), rtol=1e-9, atol=1e-15)
    assert found["Bar <1>"][0].mass == (0.3 if glob != "Bar <2>" else pytest.approx(1000 * VOLUME))


def test_a_mass_of_the_users_resolves_a_part_without_material(kit):
    add(kit, "Bar")
    found, log = weights(kit, parts={"Bar": {"mass": 0.3}})
    expected = box_inertia(0.3, *SIZE)
    np.testing.assert_allclose(found["Bar <1>"][0].inertia, expected, rtol=1e-9, atol=1e-15)
    assert told(log) == []


def test_later_entries_win_value_by_value_and_mass_and_density_are_one_value(kit):
    add(kit, "Bar", density=1000)
    entries = {"*": {"density": 7000, "com": [0.1, 0, 0]}, "Bar": {"mass": 0.5}}
    inertial = weights(kit, parts=entries)[0]["Bar <1>"][0]
    assert (inertial.mass, *inertial.com) == (0.5, 0.1, 0, 0)
    entries = {"Bar": {"mass": 0.5}, "*": {"density": 7000}}
    assert weights(kit, parts=entries)[0]["Bar <1>"][0].mass == pytest.approx(7000 * VOLUME)


def test_an_inertia_of_the_users_is_taken_about_the_centre_that_is_there(kit):
    add(kit, "Bar", density=1000)
    values = [2e-4, 3e-4, 4e-4, 1e-5, -2e-5, 3e-5]
    inertial = weights(kit, parts={"Bar": {"inertia": values}})[0]["Bar <1>"][0]
    expected = [[2e-4, 1e-5, -2e-5], [1e-5, 3e-4, 3e-5], [-2e-5, 3e-5, 4e-4]]
    np.testing.assert_array_equal(inertial.inertia, expected)
    assert inertial.mass == pytest.approx(1000 * VOLUME)


def test_a_mass_of_zero_weighs_nothing(kit):
    add(kit, "Label", density=1000)
    found, log = weights(kit, parts={"Label": {"mass": 0}})
    assert found["Label <1>"][0].mass == 0
    assert told(log) == []


def test_a_glob_without_a_match_lists_the_parts(kit):
    _, log = weights(kit, parts={"Nut": {"mass": 1}, "*": {}})
    (problem,) = log.problems
    assert (problem.code, problem.where) == ("E-GLOB", "mass.parts")
    assert "'Nut'" in problem.message
    assert problem.hint == "parts are: Base"


def test_a_part_that_no_reply_knows_is_weighed_by_its_triangles(kit):
    add(kit, "Bar")
    bundle = with_the_base_alone(bundle_of(kit.document))
    assert "does not know" in weights(kit, bundle)[1].problems[0].message
    found, log = weights(kit, bundle, missing="density", density=900)
    assert found["Bar <1>"][0].mass == pytest.approx(900 * VOLUME, rel=1e-9)
    assert found["Bar <1>"][1] == pytest.approx(VOLUME, rel=1e-9)
    found, log = weights(kit, bundle, parts={"Bar": {"mass": 0.2}})
    expected = box_inertia(0.2, *SIZE)
    np.testing.assert_allclose(found["Bar <1>"][0].inertia, expected, rtol=1e-9, atol=1e-15)
    assert log.problems == []


def test_without_triangles_com_and_inertia_are_asked_for(kit):
    add(kit, "Bar")
    bundle = without_triangles(bundle_of(kit.document))
    _, log = weights(kit, bundle, parts={"Bar": {"mass": 0.2}})
    assert [(p.code, p.where) for p in log.problems] == [("E-MASS", "Bar <1>")]
    assert "com and inertia" in log.problems[0].hint
    given = {"mass": 0.2, "com": [0, 0, 0.01], "inertia": [1e-4, 1e-4, 1e-4]}
    found, log = weights(kit, bundle, parts={"Bar": given})
    assert log.problems == []
    assert found["Bar <1>"][0].com[2] == 0.01


def test_a_sheet_weighs_nothing_but_what_the_user_says(kit):
    kit.root.add(kit.studio.sheet("Sticker", solids.box(*SIZE)))
    found, log = weights(kit)
    assert found["Sticker <1>"][0].mass == 0
    assert told(log) == [("W-BODY-TYPE", "Sticker <1>")]
    found, log = weights(kit, parts={"Sticker": {"mass": 0.01}})
    assert told(log) == []
    x, y, z = SIZE
    # A box's walls: each pair of plates by its textbook moments about x.
    areas = np.array([2 * y * z, 2 * x * z, 2 * x * y]) / (2 * (y * z + x * z + x * y))
    about_x = areas @ [
        (y * y + z * z) / 12,
        z * z / 12 + y * y / 4,
        y * y / 12 + z * z / 4,
    ]
    assert found["Sticker <1>"][0].inertia[0, 0] == pytest.approx(0.01 * about_x, rel=1e-9)


def test_a_density_that_no_solid_has_is_reported_once_for_a_kind(kit):
    add(kit, "Bar", density=1000, count=3)
    _, log = weights(kit, parts={"Bar": {"mass": 42}})
    assert told(log) == [("W-DENSITY", "Bar <1>")]
    assert "7e+05 kg/m³" in log.found[0].message
    _, log = weights(kit, parts={"Bar": {"mass": 1e-5}})
    assert told(log) == [("W-DENSITY", "Bar <1>")]


def body(solid_points, triangles) -> Body:
    count = len(triangles)
    points = np.array(solid_points, dtype=float)
    return Body(
        "b", points, np.array(triangles, dtype=np.int32).reshape(-1, 3), (), np.zeros(count, dtype=np.uint16)
    )


CORNER = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def test_open_triangles_are_a_ball_of_the_volume_at_the_middle_of_their_box():
    shape = shape_of(body(CORNER, FACES[:3]), 1e-4)
    assert (shape.kind, shape.volume, shape.inertial.mass) == ("ball", 1e-4, 1.0)
    np.testing.assert_allclose(shape.inertial.com, [0.05, 0.05, 0.05])
    radius = (1e-4 / (4 / 3 * math.pi)) ** (1 / 3)
    np.testing.assert_allclose(shape.inertial.inertia, 2 / 5 * radius**2 * np.eye(3), rtol=1e-12)


def test_closed_triangles_are_a_solid_but_not_of_a_volume_that_is_another():
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


def given(robot, **links):
    log = Diagnostics()
    return with_given_masses(robot, plan_of(mass={"links": links}).mass.links, log), log


def arm(**more):
    return robot_with([joint("revolute", "base", "arm", [0.2])], **more)


def test_a_links_mass_scales_the_sum_of_its_parts():
    robot = arm()
    before = robot.link("arm").inertial
    made, log = given(robot, **{"a*": {"mass": 2 * before.mass}})
    link = made.link("arm")
    assert told(log) == []
    assert link.inertial is link.given
    np.testing.assert_array_equal(link.inertial.com, before.com)
    np.testing.assert_allclose(link.inertial.inertia, 2 * before.inertia, rtol=1e-15)
    assert made.link("base") is robot.link("base")


def test_a_links_com_and_inertia_are_taken_as_given():
    robot = arm()
    made, _ = given(robot, arm={"com": [1, 2, 3]}, **{"*m": {"inertia": [1, 1, 1.5]}})
    link = made.link("arm")
    assert link.inertial.mass == robot.link("arm").inertial.mass
    np.testing.assert_array_equal(link.inertial.com, [1, 2, 3])
    np.testing.assert_array_equal(link.inertial.inertia, np.diag([1, 1, 1.5]))


def test_a_link_without_mass_must_be_given_all():
    robot = arm(inertials={"arm": ZERO})
    _, log = given(robot, arm={"mass": 1})
    assert told(log) == [("E-MASS", "arm")]
    assert "com and inertia must be given" in log.problems[0].message
    made, log = given(robot, arm={"mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]})
    assert told(log) == []
    check_links(made, log)
    assert told(log) == []


def test_a_glob_on_links_without_a_match_lists_the_links():
    _, log = given(arm(), leg={"mass": 1})
    assert [(p.code, p.hint) for p in log.problems] == [("E-GLOB", "links are: arm, base")]


@pytest.mark.parametrize(
    ("massless", "fixed", "lacking"),
    [
        ({"base"}, True, []),
        ({"base"}, False, ["base"]),
        ({"arm"}, True, []),
        ({"arm", "tip"}, True, ["arm"]),
        ({"tip"}, True, []),
        ({"arm", "tip"}, False, ["arm"]),
    ],
)
def test_only_what_moves_as_a_whole_needs_mass(massless, fixed, lacking):
    joints = [joint("revolute", "base", "arm"), joint("fixed", "arm", "tip")]
    robot = robot_with(joints, fixed=fixed, inertials=dict.fromkeys(massless, ZERO))
    log = Diagnostics()
    check_links(robot, log)
    assert told(log) == [("E-MASS", name) for name in lacking]


NEEDLE = np.diag([1e-3, 1e-6, 1e-6])


def test_an_inertia_that_no_solid_can_have_names_the_part():
    needle = Inertial(1.0, frozen([0, 0, 0]), frozen(NEEDLE))
    log = Diagnostics()
    check_links(arm(inertials={"arm": needle}), log)
    assert told(log) == [("E-INERTIA", "arm")]


def test_an_impossible_part_in_a_possible_link_is_reported_once_for_its_kind():
    robot = arm()
    link = robot.link("arm")
    (part,) = link.parts
    bad = Inertial(1e-6, frozen([0, 0, 0]), frozen(1e-6 * NEEDLE))
    others = tuple(
        replace(part, name=f"wire <{n}>", inertial=bad, link_from_part=pose(np.random.default_rng(n)))
        for n in (1, 2)
    )
    robot = replace(robot, links=(robot.links[0], replace(link, parts=(part, *others))))
    log = Diagnostics()
    check_links(robot, log)
    assert told(log) == [("W-INERTIA", "wire <1>")]
    settled, _ = given(robot, arm={"mass": 1})
    log = Diagnostics()
    check_links(settled, log)
    assert told(log) == []


def test_an_estimate_is_in_the_parts_own_frame():
    kit = Kit()
    part = kit.studio.part("Bar", solids.box(*SIZE, at=(0.5, 0.0, 0.0)))
    kit.root.add(part, pose=pose(np.random.default_rng(0)))
    inertial = weights(kit, missing="density")[0]["Bar <1>"][0]
    np.testing.assert_allclose(inertial.com, [0.5, 0, 0], rtol=1e-12, atol=1e-12)


def test_a_robot_two_millimetres_long_gets_the_least_inertia_and_is_reported(tmp_path) -> None:
    kit = Kit()
    sizes = {"Base": 2e-3, "Link": 5e-4, "Tip": 1e-4}
    parts = (kit.bar(name, (size, size, size)) for name, size in sizes.items())
    base, link, tip = (kit.root.add(part) for part in parts)
    kit.root.revolute("Hinge", (link, np.eye(4)), (base, frame((0, 0, 2e-3))), limits=(-1, 1))
    kit.root.revolute("Wrist", (tip, np.eye(4)), (link, frame((0, 0, 5e-4))), limits=(-1, 1))
    robot = robot_of(kit.document)
    assert [(one.where, one.code) for one in robot.diagnostics if "INERTIA" in one.code] == [
        ("link", "W-INERTIA-LEAST"),
        ("tip", "W-INERTIA-LEAST"),
    ]
    write(robot, tmp_path)
    assert [check for check in checked(tmp_path, robot, plan_of()) if check.fails] == []
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    for size, name in ((5e-4, "link"), (1e-4, "tip")):
        assert model.body(name).inertia.min() >= 1e-14
        assert model.body(name).inertia.max() < 1.01e-14
        assert model.body(name).mass[0] == pytest.approx(1000 * size**3)


@pytest.mark.parametrize("moments", [(1e-16, 1e-16, 1e-16), (1e-20, 1e-9, 1e-9), (1e-18, 3e-4, 3e-4)])
@pytest.mark.parametrize("policy", ["refuse", "project"])
def test_a_speck_in_a_urdf_gets_the_least_too(moments, policy, tmp_path) -> None:
    text = robot_text(link_text("a"), link_text("b", inertial(1e-15, *moments)), joint_text("j", "a", "b"))
    robot = urdf_robot(text, policy=policy)
    assert [one.where for one in robot.diagnostics if one.code == "W-INERTIA-LEAST"] == ["b"]
    write(robot, tmp_path)
    assert [check for check in checked(tmp_path, robot, plan_of()) if check.fails] == []
    assert robot.link("b").inertial.mass == 1e-14


def robot_with_screws(**mass):
    """A base of 1 kg, and an arm with two screws without material."""
    kit = Kit()
    base = kit.root.add(kit.studio.part("Base", solids.box(0.1, 0.1, 0.1), density=1000))
    arm = kit.root.add(kit.studio.part("Arm", solids.box(*SIZE), density=2000))
    screw = kit.studio.part("Screw", solids.box(0.01, 0.01, 0.01))
    screws = [kit.root.add(screw) for _ in range(2)]
    kit.root.revolute("Hinge", (arm, frame()), (base, frame((0, 0, 0.1))), limits=(-1, 1))
    for number, one in enumerate(screws):
        kit.root.fasten(f"Screwed {number}", (one, frame()), (arm, frame((0.01 * number, 0, 0.02))))
    return robot_of(kit.document, plan_of(mass=mass))


def test_a_total_scales_what_is_estimated_with_its_inertia_and_nothing_else():
    plain, whole = robot_with_screws(), robot_with_screws(total=1.15)
    (before, after) = (
        {part.name: part for link in one.links for part in link.parts} for one in (plain, whole)
    )
    assert sum(link.inertial.mass for link in whole.links) == pytest.approx(1.15, rel=1e-12)
    known = 1.0 + 2000 * VOLUME
    factor = (1.15 - known) / (2 * 1200 * 1e-6)
    for name, part in after.items():
        times = factor if name.startswith("Screw") else 1.0
        assert part.inertial.mass == pytest.approx(before[name].inertial.mass * times, rel=1e-12)
        np.testing.assert_allclose(part.inertial.inertia, before[name].inertial.inertia * times, rtol=1e-12)
    # The arm by the parallel axis theorem, from its parts alone.
    (link,) = (one for one in whole.links if any(part.name == "Arm <1>" for part in one.parts))
    com = (
        sum(p.inertial.mass * (p.link_from_part @ [*p.inertial.com, 1])[:3] for p in link.parts)
        / link.inertial.mass
    )
    np.testing.assert_allclose(link.inertial.com, com, atol=1e-12)
    inertia = np.zeros((3, 3))
    for part in link.parts:
        turned, arm = part.link_from_part[:3, :3], (part.link_from_part @ [*part.inertial.com, 1])[:3] - com
        inertia += turned @ part.inertial.inertia @ turned.T
        inertia += part.inertial.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(link.inertial.inertia, inertia, rtol=1e-9, atol=1e-15)
    (told_so,) = (one for one in whole.diagnostics if one.code == "I-MASS-TOTAL")
    assert f"scaled by {factor:.4g}" in told_so.message


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        (
            {"total": 1.05},
            "1.05 kg is too little: beside 2 parts with estimated masses, it weighs 1.12 kg",
        ),
        (
            {"total": 2, "parts": {"Screw": {"mass": 0.1}}},
            "the robot weighs 1.32 kg, and no mass is estimated",
        ),
        ({"total": 2, "links": {"arm": {"mass": 0.5}}}, "the robot weighs 1.5 kg, and no mass is estimated"),
    ],
)
def test_a_total_that_cannot_be_is_an_error(mass, message):
    with pytest.raises(AssemblyError, match=message):
        robot_with_screws(**mass)
