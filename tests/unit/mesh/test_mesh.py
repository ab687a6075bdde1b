"""The stage: a robot's links get their shapes, each made once for its content."""

import json
import math
from dataclasses import replace
from hashlib import sha256
from io import BytesIO

import numpy as np
import pytest
import trimesh

from linkwright.stages.fetch.onshape.triangles.faces import compact
from linkwright.stages.mesh import make_geometry, part_mesh
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model import robot as model
from linkwright.stages.robot.model.geom_form import GeomForm
from linkwright.stages.robot.model.geometry import NEUTRAL
from linkwright.stages.robot.model.robot import Inertial, Link, MeshRef, Part, Primitive, Robot, frozen
from tests.support.touching import Memory

INERTIAL = Inertial(1.0, frozen([0.25, 0.25, 0.25]), frozen(np.eye(3)))
"""Inside of every block."""
FLAT = replace(INERTIAL, com=frozen([0.25, 0.25, 0.0]))
RED, BLUE = [255, 0, 0], [0, 0, 255]
X, Y, Z = np.diag([1.0, 2.0, 3.0]).tolist()
ORIGIN = [0.0, 0.0, 0.0]
LENGTHS = (0.6, 0.4, 0.2)


def body(name, triangles, colour=None, top=None):
    """A body of a reply; `top` is the colour of its faces at z = 1."""
    faces = []
    for triangle in triangles:
        facet = {"vertices": [dict(zip("xyz", map(float, corner), strict=True)) for corner in triangle]}
        upper = top and min(corner[2] for corner in triangle) == 1
        faces.append({"facets": [facet]} | ({"appearance": {"color": top}} if upper else {}))
    return {"id": name, "faces": faces} | ({"appearance": {"color": colour}} if colour else {})


def block(*size):
    return trimesh.creation.box(bounds=[(0, 0, 0), size]).triangles


BODIES = [
    body("A", block(1, 1, 1), RED),
    body("B", block(0.5, 0.5, 2), BLUE),
    body("C", block(1, 1, 1), RED, top=BLUE),
    body("P", [[(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)]]),  # an open square
    body("S", [(ORIGIN, Y, X), (ORIGIN, X, Z), (ORIGIN, Z, Y), (X, Y, Z)]),  # a tetrahedron
    body("E", trimesh.creation.icosphere(4).apply_scale(np.array(LENGTHS) / 2).triangles, RED),
]
REPLY = compact(json.dumps({"bodies": BODIES}).encode())
DIGEST = sha256(REPLY).hexdigest()
BUNDLE = OnshapeBundle("onshape", {}, "", {}, {DIGEST: REPLY}, api="v16", studios=())


def at(x=0.0, y=0.0, z=0.0, mirror=False):
    transform = np.diag([-1.0 if mirror else 1.0, 1, 1, 1])
    transform[:3, 3] = [x, y, z]
    return frozen(transform)


def part(part_id, where=None, name=None, reply=DIGEST, volume=0.0, inertial=None):
    name = name or f"{part_id} <1>"
    ref = MeshRef(reply, part_id) if reply else None
    where = at() if where is None else where
    inertial = inertial or (FLAT if part_id == "P" else INERTIAL)
    return Part((name,), name, part_id, ref, where, where, inertial, volume)


def robot(**links):
    return of_links(*(link_of(name, *parts) for name, parts in links.items()))


def link_of(name, *parts, inertial=None, shapes=()):
    total = merged([moved(part.inertial, part.link_from_part) for part in parts])
    return Link(name, inertial or total, parts, (name,), inertial, shapes)


def of_links(*links):
    fixed = model.Base(True, "fixed in CAD"), frozen(np.eye(4)), model.Mobility(0, 0, 0, ())
    return Robot("r", links, (), (), (), (), *fixed, model.Provenance("d", "e", "m", "default"))


def geometry(robot, memo=None, target=(), **mesh):
    tree = {"mesh": {"collider": "hull", **mesh}, "contact": {"self": "none"}}
    keys = MeshSections.model_validate(tree | {"target": {name: {} for name in target}})
    return make_geometry(robot, BUNDLE, keys, memo or Memory())


def load(result, file):
    return trimesh.load(BytesIO(result.files[file]), file_type="stl")


def test_link_has_a_visual_a_colour_and_its_hull_in_its_frame():
    result = geometry(robot(base=[part("A", at(1)), part("B", at(1, 0, 1)), part("A", at(3), "A <2>")]))
    assert result.diagnostics == ()
    assert [(shape.role, shape.file, shape.colour, shape.faces) for shape in result.shapes] == [
        ("collision", "base_collision.stl", None, result.shapes[0].faces),
        ("visual", "base_1.stl", (0.0, 0.0, 1.0, 1.0), 12),
        ("visual", "base_2.stl", (1.0, 0.0, 0.0, 1.0), 24),
    ]
    assert sorted(result.files) == sorted(shape.file for shape in result.shapes)
    assert result.shapes[2].volume == pytest.approx(2)
    assert load(result, "base_2.stl").bounds.tolist() == [[1, 0, 0], [4, 1, 1]]
    hull = load(result, "base_collision.stl")
    assert hull.is_watertight
    assert hull.is_convex
    assert hull.bounds.tolist() == [[1, 0, 0], [4, 1, 3]]


def test_coloured_face_is_a_visual_of_its_own():
    result = geometry(robot(base=[part("C")]))
    top, rest = (shape for shape in result.shapes if shape.role == "visual")
    assert (top.colour, top.faces, rest.faces) == ((0.0, 0.0, 1.0, 1.0), 4, 10)
    assert load(result, top.file).bounds[:, 2] == pytest.approx([1, 1], abs=2e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_mirrored_part_is_the_mirror_image(axis):
    signs = np.ones(3)
    signs[axis] = -1.0
    where = np.diag([*signs, 1.0])
    where[:3, 3] = [0.5, -2, 4]
    result = geometry(robot(base=[part("S", frozen(where))]))
    expected = np.array([ORIGIN, X, Y, Z]) * signs + where[:3, 3]
    slope = math.sqrt(2**2 * 3**2 + 3**2 + 2**2) / 2
    for shape in result.shapes:
        mesh = load(result, shape.file)
        assert sorted(mesh.vertices.tolist()) == sorted(expected.tolist())
        assert mesh.is_watertight
        assert mesh.volume == shape.volume == pytest.approx(1, rel=1e-12)
        assert shape.area == pytest.approx(1 + 1.5 + 3 + slope, rel=1e-12)
        # The slope faces away from the corner, in the file's own normals too.
        rows = np.frombuffer(result.files[shape.file][84:], dtype=np.uint8).reshape(4, 50)
        normals = rows[:, :12].copy().view("<f4")
        towards = normals @ (np.array([1, 1 / 2, 1 / 3]) * signs) > 0
        assert sorted(towards) == [False, False, False, True]
    assert result.diagnostics == ()


BOX = Primitive("box", (0.2, 0.4, 0.6), at(0.1), (0.0, 1.0, 0.0, 1.0))
POST = Primitive("cylinder", (0.1, 0.5), at(), visual=False)
PILL = Primitive("capsule", (0.1, 0.5), at(), collision=False)
BALL = Primitive("sphere", (0.3,), at())


def test_primitives_follow_their_links_meshes_with_their_figures():
    tool, tip = link_of("tool", part("A"), shapes=(POST, BOX)), link_of("tip", shapes=(PILL, BALL))
    result = geometry(of_links(tool, tip, link_of("end", part("A"))))
    assert [(shape.link, shape.role, shape.file, shape.primitive) for shape in result.shapes] == [
        ("tool", "collision", "tool_collision.stl", None),
        ("tool", "visual", "tool.stl", None),
        ("tool", "collision", None, POST),
        ("tool", "collision", None, BOX),
        ("tool", "visual", None, BOX),
        ("tip", "visual", None, PILL),
        ("tip", "collision", None, BALL),
        ("tip", "visual", None, BALL),
        ("end", "collision", "tool_collision.stl", None),
        ("end", "visual", "tool.stl", None),
    ]
    assert set(result.files) == {"tool.stl", "tool_collision.stl"}
    post, _, box, pill, _, ball = (shape for shape in result.shapes if shape.primitive)
    assert (box.colour, ball.colour, post.colour) == (BOX.colour, NEUTRAL, None)
    assert {(shape.vertices, shape.faces) for shape in (post, box, pill, ball)} == {(0, 0)}
    assert [(shape.area, shape.volume) for shape in (box, ball, post, pill)] == [
        pytest.approx((0.88, 0.048)),
        pytest.approx((4 * math.pi * 0.09, 4 / 3 * math.pi * 0.027)),
        pytest.approx((2 * math.pi * 0.1 * (0.5 + 0.1), math.pi * 0.01 * 0.5)),
        pytest.approx((2 * math.pi * 0.1 * (0.5 + 0.2), math.pi * 0.01 * (0.5 + 4 / 3 * 0.1))),
    ]


@pytest.mark.parametrize("colliders", [{}, {"*": "cylinder"}])
def test_mjx_gets_no_cylinder_from_file_or_key(colliders):
    robot = of_links(link_of("tool", part("A"), shapes=(POST, BOX)), link_of("tip", shapes=(POST,)))
    memo = Memory()
    for target in ("mujoco", "mjx"):
        result = geometry(robot, memo, [target], colliders=colliders)
        kinds = [shape.primitive.kind for shape in result.shapes if shape.primitive]
        assert ("cylinder" in kinds) == (target == "mujoco")
        assert result.files == geometry(robot, None, [target], colliders=colliders).files
    for shape in [shape for shape in result.shapes if shape.role == "collision" and shape.file][-2:]:
        mesh = load(result, shape.file)
        assert mesh.is_convex
        assert mesh.volume == pytest.approx(math.pi * 0.01 * 0.5, rel=1e-5)
        assert mesh.extents == pytest.approx([0.2, 0.2, 0.5], rel=0.014)
        assert len(mesh.vertices) == 32


def for_targets(*targets, **mesh):
    """The geometry for targets of a robot with a cylinder and an ellipsoid, and the hints of I-TARGET by
    message."""
    ellipsoid = replace(part("E", at(3)), form=GeomForm(ellipsoid=LENGTHS))
    robot = of_links(link_of("tool", part("A"), ellipsoid, shapes=(POST,)), link_of("tip", part("B")))
    result = geometry(robot, None, targets, **mesh)
    return result, {row.message: row.hint for row in result.diagnostics if row.code == "I-TARGET"}


def test_change_of_a_shape_is_reported_with_its_targets():
    tip = {"tip": {"make": "hull", "max_vertices": 40}}
    result, hints = for_targets("mjx", "newton", "drake", colliders=tip)
    (error,) = (text for text in hints if "ellipsoid" in text)
    by_mjx, by_drake = (f"for {name}; without it this stays as it is" for name in ("mjx", "drake"))
    assert hints == {
        "1 collider that is a cylinder → prisms of 16 sides and the same volume, whose corners stand out by "
        "1.3 % of the radius": by_mjx,
        error: by_mjx,
        "hulls and convex pieces have fewer vertices: mesh.max_vertices (64 → 32), "
        "mesh.colliders.tip.max_vertices (40 → 32)": by_mjx,
        f"{len(result.files)} meshes in STL → OBJ": by_drake,
    }


def test_error_of_the_hull_of_an_ellipsoid_is_reported():
    result, hints = for_targets("mjx")
    (error,) = (text for text in hints if "ellipsoid" in text)
    # Along many directions, of the hull as the file has it.
    (shape,) = (shape for shape in result.shapes if shape.form.ellipsoid)
    hull = load(result, shape.file)
    rays = trimesh.creation.icosphere(subdivisions=4).vertices
    units = (hull.triangles_center - [3, 0, 0]) / (np.array(LENGTHS) / 2)
    normals = hull.face_normals * (np.array(LENGTHS) / 2)
    reach = (units * normals).sum(axis=1) / np.maximum(rays @ normals.T, 1e-12)
    measured = np.abs(reach.min(axis=1) - 1).max()
    reported = float(error.partition("at most ")[2].partition(" %")[0]) / 100
    assert measured == pytest.approx(reported, abs=0.006)
    assert measured <= reported + 6e-4
    assert len(hull.vertices) <= 32


@pytest.mark.parametrize(("maker", "solids"), [("none", []), ("box", ["box"]), ("hull", ["mesh"])])
def test_ellipsoid_has_the_collider_that_is_chosen_for_it(maker, solids):
    result, _ = for_targets(colliders={"E": maker})
    assert not any(shape.ellipsoid for shape in result.shapes)
    assert solids == [
        shape.primitive.kind if shape.primitive else "mesh"
        for shape in result.shapes
        if shape.link == "tool" and shape.collider == 1
    ]


def test_nothing_is_reported_where_no_target_asks():
    assert for_targets()[1] == for_targets("newton", "mjwarp")[1] == {}
    assert len(for_targets("mjx", max_vertices=32)[1]) == 2
    assert not any("OBJ" in text for text in for_targets("drake", format="obj")[1])
    assert not any("hull" in text for text in for_targets("drake", collider="raw")[1])


def test_mesh_as_it_is_becomes_a_hull_where_a_target_limits_it():
    hints = for_targets("mjx", "drake", collider="raw")[1]
    change = "2 colliders that are meshes as they are → hulls of at most 32 vertices"
    assert hints[change].startswith("for mjx;")


def test_prism_has_16_sides_whatever_hulls_have():
    result, hints = for_targets("mjx", max_vertices=8)
    assert any("16 sides" in text for text in hints)
    files = [shape.file for shape in result.shapes if shape.role == "collision" and shape.file]
    radii = [np.hypot(*load(result, file).vertices[:, :2].T) for file in files]
    (prism,) = (distances for distances in radii if np.ptp(distances) < 1e-6)
    assert len(prism) == 32
    assert prism == pytest.approx(0.1 * 1.013, rel=1e-3)


def test_order_of_instances_does_not_change_a_byte():
    parts = [part("A", at(index), f"A <{index}>") for index in range(4)] + [part("B", at(0, 3))]
    assert geometry(robot(base=parts)) == geometry(robot(base=parts[::-1]))


def test_rename_makes_no_link_again_and_a_move_only_its_own():
    memo = Memory()
    before = geometry(robot(base=[part("A")], arm=[part("B", at(1))]), memo)
    assert memo.made == 6
    renamed = geometry(robot(torso=[part("A", name="Torso <1>")], arm=[part("B", at(1))]), memo)
    assert memo.made == 6
    assert renamed.files["torso.stl"] == before.files["base.stl"]
    geometry(robot(base=[part("A")], arm=[part("B", at(np.nextafter(1, 2)))]), memo)
    assert memo.made == 9


def test_memo_gives_the_same_geometry_and_reads_each_reply_once(monkeypatch):
    reads = []
    real = part_mesh.decode_meshes
    monkeypatch.setattr(
        part_mesh, "decode_meshes", lambda body, parts: reads.append(parts) or real(body, parts)
    )
    memo = Memory()
    whole = robot(base=[part("A")], arm=[part("B"), part("A", at(2))], leg=[part("A", at(7))])
    assert geometry(whole, memo) == geometry(whole, memo)
    assert reads == [{"A", "B"}]
    memo = Memory()
    lacking = robot(base=[part("A"), part("gone")], arm=[part("B")], leaf=[part("P")])
    assert geometry(lacking, memo) == geometry(lacking, memo) == geometry(lacking)
    assert memo.made == 9


NOWHERE = part("X", reply=None)
BARE = [part(str(index), reply=None) for index in range(3)]


@pytest.mark.parametrize(
    ("links", "expects", "shapes"),
    [
        (
            {"base": [part("A"), part("gone"), NOWHERE], "arm": [NOWHERE]},
            [
                ("W-NO-MESH", "base", "no triangles for 2 of 3 parts: X <1>, gone <1>"),
                ("W-NO-MESH", "arm", "no triangles for 1 of 1 part: X <1>"),
            ],
            {"base": 2},
        ),
        ({"base": BARE[:1], "arm": BARE[1:]}, [("W-NO-MESH", "source", "any of 3 parts")], {}),
        ({"base": [part("A")], "leaf": [part("P")]}, [("W-FLAT", "leaf", "flat")], {"base": 2, "leaf": 1}),
        ({"base": [part("A")], "origin": []}, [], {"base": 2}),
        (
            {
                "base": [part("A", volume=1.019), part("B", at(2), volume=0.6)],
                "arm": [part("B", at(2), "B <2>", volume=0.6), part("P", volume=3.0)],
            },
            [("W-MESH-VOLUME", "B <1>", "16.7% apart")],
            {"base": 3, "arm": 3},
        ),
    ],
    ids=["missing", "recording without triangles", "flat", "no parts", "volume"],
)
def test_parts_without_a_sound_mesh_are_reported_once(links, expects, shapes):
    result = geometry(robot(**links))
    assert [(row.code, row.where) for row in result.diagnostics] == [row[:2] for row in expects]
    assert all(text in row.message for row, (*_, text) in zip(result.diagnostics, expects, strict=True))
    assert {
        link: len(result.shapes_of(link, "visual") + result.shapes_of(link, "collision")) for link in links
    } == {
        **dict.fromkeys(links, 0),
        **shapes,
    }
