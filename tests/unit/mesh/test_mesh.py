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
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.dynamics.inertia import merged, moved
from linkwright.stages.robot.model.geometry import NEUTRAL
from linkwright.stages.robot.model.robot import (
    Base,
    Inertial,
    Link,
    MeshRef,
    Mobility,
    Part,
    Primitive,
    Provenance,
    Robot,
    frozen,
)

KEYS = MeshSections.model_validate({"mesh": {"collider": "hull"}, "contact": {"self": "none"}})
INERTIAL = Inertial(1.0, frozen([0.25, 0.25, 0.25]), frozen(np.eye(3)))
"""Inside of every block."""
FLAT = replace(INERTIAL, com=frozen([0.25, 0.25, 0.0]))
RED, BLUE = [255, 0, 0], [0, 0, 255]


def block(name, colour, size=(1.0, 1.0, 1.0), top=None):
    """A box from the origin as a body of a reply; `top` is the colour of its upper face."""
    mesh = trimesh.creation.box(bounds=[(0, 0, 0), size])
    faces = []
    for triangle, normal in zip(mesh.triangles, mesh.face_normals, strict=True):
        facet = {"vertices": [dict(zip("xyz", map(float, corner), strict=True)) for corner in triangle]}
        upper = {"appearance": {"color": top}} if top and normal[2] > 0.5 else {}
        faces.append({"facets": [facet], **upper})
    return {"id": name, "appearance": {"color": colour}, "faces": faces}


def spike(name):
    """The tetrahedron between the origin and 1, 2 and 3 m along x, y and z."""
    x, y, z = np.diag([1.0, 2.0, 3.0]).tolist()
    triangles = [(0, 0, 0), y, x], [(0, 0, 0), x, z], [(0, 0, 0), z, y], [x, y, z]
    facets = [{"vertices": [dict(zip("xyz", map(float, c), strict=True)) for c in t]} for t in triangles]
    return {"id": name, "faces": [{"facets": facets}]}


def plate(name):
    """An open square."""
    corners = [[(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)]]
    facets = [{"vertices": [dict(zip("xyz", map(float, c), strict=True)) for c in row]} for row in corners]
    return {"id": name, "faces": [{"facets": facets}]}


_JSON = json.dumps(
    {
        "bodies": [
            block("A", RED),
            block("B", BLUE, (0.5, 0.5, 2.0)),
            block("C", RED, top=BLUE),
            plate("P"),
            spike("S"),
        ]
    }
).encode()
REPLY = compact(_JSON)
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


def link_of(name, *parts, given=None, shapes=()):
    total = merged([moved(part.inertial, part.link_from_part) for part in parts])
    return Link(name, given or total, parts, (name,), given, shapes)


def of_links(*links):
    nowhere = Provenance("d", "e", "m", "default")
    fixed = Base(True, "fixed in CAD"), frozen(np.eye(4)), Mobility(0, 0, 0, ())
    return Robot("r", links, (), (), (), (), *fixed, nowhere)


class Memory:
    """A memo that counts what it had to make."""

    def __init__(self):
        self.kept, self.made = {}, 0

    def __call__(self, kind, key, make):
        name = json.dumps([kind, key])
        if name not in self.kept:
            self.made += 1
            self.kept[name] = make()
        return self.kept[name]


def geometry(value, memo=None, bundle=BUNDLE, keys=KEYS):
    return make_geometry(value, bundle, keys, memo or Memory())


def load(result, file):
    return trimesh.load(BytesIO(result.files[file]), file_type="stl")


def test_a_link_gets_a_visual_a_colour_and_its_hull_in_its_own_frame():
    result = geometry(robot(base=[part("A", at(1)), part("B", at(1, 0, 1)), part("A", at(3), "A <2>")]))
    assert result.diagnostics == ()
    assert [(s.role, s.file, s.colour, s.faces) for s in result.shapes] == [
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


def test_shapes_follow_the_links_and_one_colour_needs_no_number():
    result = geometry(robot(tip=[part("A")], base=[part("B")]))
    assert [shape.file for shape in result.shapes] == [
        "tip_collision.stl",
        "tip.stl",
        "base_collision.stl",
        "base.stl",
    ]
    assert [shape.link for shape in result.of("base", "visual")] == ["base"]


def test_a_coloured_face_is_a_visual_of_its_own():
    result = geometry(robot(base=[part("C")]))
    top, rest = (shape for shape in result.shapes if shape.role == "visual")
    assert top.colour == (0.0, 0.0, 1.0, 1.0)
    assert (top.faces, rest.faces) == (4, 10)
    assert load(result, top.file).bounds[:, 2] == pytest.approx([1, 1], abs=2e-6)


def test_a_mirrored_part_keeps_its_outside_outside():
    result = geometry(robot(base=[part("C", at(1, mirror=True)), part("A", at(5, mirror=True))]))
    red = next(shape for shape in result.shapes if shape.colour == (1.0, 0.0, 0.0, 1.0))
    mesh = load(result, red.file)
    solid = mesh.split(only_watertight=True)[0]
    assert solid.volume == pytest.approx(1)
    assert solid.bounds.tolist() == [[4, 0, 0], [5, 1, 1]]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_mirrored_part_is_the_mirror_image(axis):
    signs = np.ones(3)
    signs[axis] = -1.0
    where = np.diag([*signs, 1.0])
    where[:3, 3] = [0.5, -2, 4]
    result = geometry(robot(base=[part("S", frozen(where))]))
    expected = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]]) * signs + where[:3, 3]
    slope = math.sqrt(2**2 * 3**2 + 3**2 + 2**2) / 2
    for shape in result.shapes:
        mesh = load(result, shape.file)
        assert sorted(mesh.vertices.tolist()) == sorted(expected.tolist())
        assert mesh.is_watertight
        assert mesh.volume == shape.volume == pytest.approx(1, rel=1e-12)
        assert shape.area == pytest.approx(1 + 1.5 + 3 + slope, rel=1e-12)
        # The slope faces away from the corner, in the file's own normals too.
        normal = stored_normals(result.files[shape.file]) @ (np.array([1, 1 / 2, 1 / 3]) * signs)
        assert sorted(normal > 0) == [False, False, False, True]
    assert result.diagnostics == ()


def stored_normals(data):
    count = int.from_bytes(data[80:84], "little")
    return np.frombuffer(data[84:], dtype=np.uint8).reshape(count, 50)[:, :12].copy().view("<f4")


BOX = Primitive("box", (0.2, 0.4, 0.6), at(0.1), (0.0, 1.0, 0.0, 1.0))
POST = Primitive("cylinder", (0.1, 0.5), at(), visual=False)
PILL = Primitive("capsule", (0.1, 0.5), at(), collision=False)
BALL = Primitive("sphere", (0.3,), at())


def test_primitives_follow_the_meshes_of_their_link_with_their_own_figures():
    made_up = link_of("tool", part("A"), shapes=(POST, BOX))
    result = geometry(of_links(made_up, link_of("tip", shapes=(PILL, BALL)), link_of("end", part("A"))))
    assert [(s.link, s.role, s.file, s.primitive) for s in result.shapes] == [
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
    figures = [(shape.area, shape.volume) for shape in (box, ball, post, pill)]
    assert figures == [
        pytest.approx((0.88, 0.048)),
        pytest.approx((4 * math.pi * 0.09, 4 / 3 * math.pi * 0.027)),
        pytest.approx((2 * math.pi * 0.1 * (0.5 + 0.1), math.pi * 0.01 * 0.5)),
        pytest.approx((2 * math.pi * 0.1 * (0.5 + 0.2), math.pi * 0.01 * (0.5 + 4 / 3 * 0.1))),
    ]


@pytest.mark.parametrize("colliders", [{}, {"*": "cylinder"}])
def test_mjx_gets_no_cylinder_from_file_or_key(colliders):
    value = of_links(link_of("tool", part("A"), shapes=(POST, BOX)), link_of("tip", shapes=(POST,)))
    memo = Memory()
    for target in ("mujoco", "mjx"):
        section = {"collider": "hull", "colliders": colliders, "target": target}
        keys = MeshSections.model_validate({"mesh": section, "contact": {"self": "none"}})
        result = geometry(value, memo, keys=keys)
        kinds = [shape.primitive.kind for shape in result.shapes if shape.primitive]
        assert ("cylinder" in kinds) == (target == "mujoco")
        assert result.files == geometry(value, keys=keys).files
    posts = [shape for shape in result.shapes if shape.role == "collision" and shape.file][-2:]
    for shape in posts:
        mesh = load(result, shape.file)
        assert mesh.is_convex
        assert mesh.volume == pytest.approx(math.pi * 0.01 * 0.5, rel=1e-5)
        assert mesh.extents == pytest.approx([0.2, 0.2, 0.5], rel=0.005)
        assert len(mesh.vertices) == 64


def test_the_order_of_instances_does_not_change_a_byte():
    parts = [part("A", at(index), f"A <{index}>") for index in range(4)] + [part("B", at(0, 3))]
    one = geometry(robot(base=parts))
    other = geometry(robot(base=parts[::-1]))
    assert other == one


def test_a_rename_makes_no_link_again_and_a_move_only_its_own():
    memo = Memory()
    before = geometry(robot(base=[part("A")], arm=[part("B", at(1))]), memo)
    assert memo.made == 6
    renamed = geometry(robot(torso=[part("A", name="Torso <1>")], arm=[part("B", at(1))]), memo)
    assert memo.made == 6
    assert renamed.files["torso.stl"] == before.files["base.stl"]
    geometry(robot(base=[part("A")], arm=[part("B", at(np.nextafter(1, 2)))]), memo)
    assert memo.made == 9


def test_what_the_memo_keeps_gives_the_same_geometry():
    memo = Memory()
    value = robot(base=[part("A"), part("gone")], arm=[part("B")], leaf=[part("P")])
    assert geometry(value, memo) == geometry(value, memo) == geometry(value)
    assert memo.made == 9


def test_each_reply_is_read_once_and_not_at_all_where_all_is_kept(monkeypatch):
    from linkwright.stages.mesh import tessellation

    reads = []
    real = tessellation.read
    monkeypatch.setattr(tessellation, "read", lambda body, parts: reads.append(parts) or real(body, parts))
    memo = Memory()
    value = robot(base=[part("A")], arm=[part("B"), part("A", at(2))], leg=[part("A", at(7))])
    geometry(value, memo)
    assert reads == [{"A", "B"}]
    geometry(value, memo)
    assert len(reads) == 1


def test_parts_without_triangles_are_reported_once_a_link():
    result = geometry(
        robot(base=[part("A"), part("gone"), part("X", reply=None)], arm=[part("X", reply=None)])
    )
    assert [(d.code, d.where, d.message) for d in result.diagnostics] == [
        ("W-NO-MESH", "base", "no triangles for 2 of 3 parts: X <1>, gone <1>"),
        ("W-NO-MESH", "arm", "no triangles for 1 of 1 part: X <1>"),
    ]
    assert result.of("arm", "visual") == result.of("arm", "collision") == ()


def test_a_recording_without_triangles_is_reported_once():
    bare = [part(str(index), reply=None) for index in range(3)]
    result = geometry(robot(base=bare[:1], arm=bare[1:]))
    (found,) = result.diagnostics
    assert (found.code, found.where) == ("W-NO-MESH", "source")
    assert "any of 3 parts" in found.message
    assert (result.shapes, result.files) == ((), {})


def test_a_flat_link_does_not_collide_and_is_reported():
    result = geometry(robot(base=[part("A")], leaf=[part("P")]))
    assert [(d.code, d.where) for d in result.diagnostics] == [("W-FLAT", "leaf")]
    assert [shape.role for shape in result.shapes if shape.link == "leaf"] == ["visual"]


def test_a_link_without_parts_has_no_shape_and_no_diagnostic():
    result = geometry(robot(base=[part("A")], origin=[]))
    assert result.diagnostics == ()
    assert {shape.link for shape in result.shapes} == {"base"}


def test_a_mesh_whose_volume_is_not_the_solids_is_reported_once():
    good, bad = part("A", volume=1.019), part("B", at(2), volume=0.6)
    result = geometry(robot(base=[good, bad], arm=[replace(bad, name="B <2>"), part("P", volume=3.0)]))
    codes = [(d.code, d.where) for d in result.diagnostics if d.code == "W-MESH-VOLUME"]
    assert codes == [("W-MESH-VOLUME", "B <1>")]
    assert "16.7% apart" in next(d.message for d in result.diagnostics if d.code == "W-MESH-VOLUME")
