"""The picture of a build: from what it is drawn, what is kept, and that nothing of it fails a build."""

import json
import subprocess
import sys
from unittest.mock import Mock

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.caching.actions import Cache
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.errors import ConfigError, SourceError
from linkwright.pipeline.show import preview as room
from linkwright.pipeline.show.preview import NONE, require
from linkwright.stages.formats import png
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files import stl
from linkwright.stages.robot.system.guest import Bounds
from linkwright.stages.show.preview import (
    ENDED,
    PICTURE,
    REFUSED,
    SMALL,
    TURN,
    ask,
    guest,
    model_of,
    names,
    needed_by,
    turning,
)
from linkwright.stages.show.preview.ask import Painter, pictures_of
from linkwright.stages.show.preview.compiled import look_of, look_of_files
from linkwright.stages.show.preview.look import Geom, Look, packed
from linkwright.stages.show.preview.model_text import mjcf_text
from linkwright.stages.show.preview.surface import surface_of
from tests.support.pictures import pixels_of, robot_in
from tests.support.places import PROJECT

ROBOT = b'{"keyframes": [{"name": "home", "values": {"hinge": 0.5, "ball": [1, 0, 0, 0]}}]}'
SCENE = b'<mujoco><include file="arm.xml"/><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>'
ARM = b"""<mujoco><worldbody><body><joint name="hinge" axis="0 1 0"/>
  <geom type="box" size="0.1 0.1 0.3" rgba="0.9 0.1 0.1 1"/></body></worldbody></mujoco>"""
URDF = b"""<robot name="arm"><link name="base"/>
  <link name="arm"><visual><geometry><box size="0.2 0.2 0.6"/></geometry>
    <material name="red"><color rgba="0.9 0.1 0.1 1"/></material></visual>
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
FILES = {"scene.xml": SCENE, "arm.xml": ARM, "robot.json": ROBOT}

LOOK = Look(
    (Geom("box", (0.1, 0.1, 0.1), (0.0,) * 3, (1.0, 0, 0, 0, 1, 0, 0, 0, 1), (1.0,) * 4),), (1.0, 0, 0), ()
)

ENOUGH = Bounds(seconds=60, memory=2 << 30, reply=64 << 20, wall_time_factor=4)


@pytest.fixture
def cache(tmp_path):
    return Cache(Store(tmp_path / "cache"))


@pytest.fixture
def guest_like(monkeypatch):
    """A stand-in for the guest: what it returns, and how often it was asked."""
    stand_in = Mock(return_value={PICTURE: b"picture", SMALL: b"small"})
    monkeypatch.setattr(ask, "pictures_of", stand_in)
    return stand_in


def preview(cache, files=FILES, kind="png"):
    return room.start_drawing(cache, files, {}, kind).result()


@pytest.fixture
def visitor(tmp_path, monkeypatch):
    """A guest that runs these lines."""
    monkeypatch.syspath_prepend(tmp_path)

    def make(lines, bounds=ENOUGH):
        body = "\n".join(f"    {line}" for line in lines.splitlines())
        (tmp_path / "painting_visitor.py").write_text(f"def answer(request):\n{body}\n")
        return Painter("painting_visitor", bounds)

    return make


def test_picture_is_drawn_from_the_scene_else_from_a_urdf():
    assert model_of(FILES) == "scene.xml"
    assert model_of({"ros2/a/urdf/arm.urdf": b"", "robot.json": b""}) == "ros2/a/urdf/arm.urdf"
    assert model_of({"python/a/arm/scene.xml": b"", "arm.urdf": b""}) == "python/a/arm/scene.xml"
    assert model_of({"arm.sdf": b"", "notscene.xml": b""}) is None


def test_files_that_a_model_cannot_name_are_not_needed():
    files = {**FILES, "arm.urdf": b"", "assets/a.stl": b"", "graph.svg": b"", "ros2/arm/urdf/arm.urdf": b""}
    assert needed_by("scene.xml", files) == ["arm.xml", "assets/a.stl", "scene.xml"]
    assert needed_by("arm.urdf", files) == ["arm.urdf", "assets/a.stl", "robot.json"]
    ros = {"ros2/arm/urdf/arm.urdf": b"", "ros2/arm/meshes/a.stl": b"", "robot.json": b"", "a.stl": b""}
    needed = needed_by("ros2/arm/urdf/arm.urdf", ros)
    assert needed == ["robot.json", "ros2/arm/meshes/a.stl", "ros2/arm/urdf/arm.urdf"]


@pytest.mark.parametrize("files", [FILES, {"arm.urdf": URDF, "robot.json": ROBOT}], ids=["mjcf", "urdf"])
def test_guest_draws_the_same_bytes_whatever_the_driver(files, monkeypatch):
    look = look_of_files(model_of(files), files)
    drawing = pictures_of(look, "png")
    assert sorted(drawing) == [PICTURE, SMALL]
    assert len(drawing[SMALL]) <= 66_000
    assert png.problem(drawing[PICTURE]) == png.problem(drawing[SMALL]) == ""
    pixels = pixels_of(drawing[PICTURE])
    assert pixels.shape == (guest.SIZE[1], guest.SIZE[0], 3)
    assert robot_in(pixels).mean() > 0.05
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    assert pictures_of(look, "png") == drawing


def asked(model, files, kind):
    """What the guest answers, in this process."""
    draws = turning if kind == "turn" else guest
    return ask._pictures_in(draws.answer(packed(look_of_files(model, files))))


def test_urdf_is_seen_at_home(monkeypatch):
    monkeypatch.setattr(guest, "SIZE", (80, 60))
    files = {"arm.urdf": URDF, "robot.json": ROBOT}
    home = asked("arm.urdf", files, "png")[PICTURE]
    assert home != asked("arm.urdf", files | {"robot.json": b"{}"}, "png")[PICTURE]
    at_home = files | {"robot.json": ROBOT.replace(b"[1, 0, 0, 0]", b"3")}
    assert home == asked("arm.urdf", at_home, "png")[PICTURE]


@pytest.mark.parametrize("frames", [5, pytest.param(turning.FRAMES, marks=pytest.mark.slow)])
def test_turn_has_all_its_frames_and_goes_on(frames, tmp_path, monkeypatch):
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setattr(turning, "FRAMES", frames)
    monkeypatch.setattr(guest, "SIZE", (80, 60))
    drawing = asked("scene.xml", FILES, "turn")
    (tmp_path / TURN).write_bytes(drawing[TURN])
    with image.open(tmp_path / TURN) as opened:
        assert opened.size == turning.SIZE
        assert opened.n_frames == frames
        assert opened.info["loop"] == 0
        shown = []
        for frame in range(frames):
            opened.seek(frame)
            shown.append(opened.convert("RGB").tobytes())
            assert opened.info["duration"] == turning.FRAME_TIME
    assert len(set(shown)) == frames
    assert len(drawing[TURN]) < 1_000_000


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", "drawing it crashed (SIGSEGV)"),
        ("import os\nos.abort()", "drawing it crashed (SIGABRT)"),
        ("raise RuntimeError('no driver')", "drawing it failed (RuntimeError: no driver)"),
        ("return b'nonsense'", "drawing it gave an invalid reply"),
        ("return b'{\"files\": []}\\n'", "drawing it gave an invalid reply"),
        ('return b\'{"files": [["preview.png", 9]]}\\nab\'', "drawing it gave an invalid reply"),
    ],
)
def test_guest_that_fails_is_survived_and_reported(visitor, lines, why):
    results = pictures_of(LOOK, "png", visitor(lines))
    assert {name: json.loads(data) for name, data in results.items()} == {ENDED: {"why": why}}


EATS = "kept = b'x' * (1 << 29)\nimport time\ntime.sleep(60)"


@pytest.mark.parametrize(
    ("lines", "bounds", "why"),
    [
        ("while True: pass", Bounds(0.3, 1 << 30, 1000), "longer than 0.3 s"),
        (EATS, Bounds(60, 1 << 28, 1000), "of memory"),
    ],
    ids=["hangs", "eats memory"],
)
def test_guest_that_takes_too_much_is_ended(visitor, lines, bounds, why):
    assert why in json.loads(pictures_of(LOOK, "png", visitor(lines, bounds))[ENDED])["why"]


@pytest.mark.parametrize(
    "text", [b"<mujoco><nonsense/></mujoco>", b"not xml", b'<mujoco><include file="gone.xml"/></mujoco>']
)
def test_model_that_does_not_compile_is_reported(text):
    for files in ({"scene.xml": text}, {"arm.urdf": b"<robot><joint/></robot>", "robot.json": b"{}"}):
        with pytest.raises(SourceError, match=f"cannot compile {model_of(files)}"):
            look_of_files(model_of(files), files)


def test_picture_is_made_once_for_the_same_files(cache, guest_like):
    first = preview(cache)
    assert first.files == {PICTURE: b"picture"}
    assert (first.small, first.path, first.diagnostics) == (b"small", PICTURE, ())
    assert preview(cache, {**FILES, "graph.svg": b"new"}) == first
    assert guest_like.call_count == 1
    preview(cache, {**FILES, "arm.xml": ARM.replace(b"0.3", b"0.4")})
    assert guest_like.call_count == 2


def test_edit_that_the_look_does_not_show_draws_nothing(cache, guest_like):
    first = preview(cache)
    seen = ARM.replace(b"<geom", b'<geom contype="0" conaffinity="0"')
    hidden = seen.replace(b'axis="0 1 0"', b'axis="0 1 0" range="-1 1" damping="3"').replace(
        b"<joint", b'<geom size="9" group="3"/><inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/><joint'
    )
    assert preview(cache, {**FILES, "arm.xml": ARM + b"<!-- -->"}) == first
    assert guest_like.call_count == 1
    assert preview(cache, {**FILES, "arm.xml": hidden}) == first
    assert preview(cache, {**FILES, "arm.xml": seen}) == first
    assert guest_like.call_count == 1
    camera = b'<worldbody><camera name="overview" pos="3 0 0" xyaxes="0 1 0 0 0 1"/>'
    for path, old, new in (
        ("arm.xml", b"0.9 0.1 0.1", b"0.9 0.2 0.1"),
        ("arm.xml", b"<body>", b'<body pos="1 0 0"><geom size="0.1"/>'),
        ("scene.xml", b"<worldbody>", camera),
    ):
        count = guest_like.call_count
        preview(cache, {**FILES, path: FILES[path].replace(old, new)})
        assert guest_like.call_count == count + 1, path


MESHED = b"""<mujoco><compiler meshdir="assets"/>
  <default><default class="v"><geom type="mesh" contype="0" conaffinity="0"/></default></default>
  <asset><mesh file="wedge.stl" scale="0.5 1 -1"/><mesh name="other" file="wedge.stl"/></asset>
  <worldbody><body pos="0 0 1" euler="20 30 40"><joint/>{mass}
    <geom class="v" density="0.01" mesh="wedge" pos="0.1 0.2 0.3" quat="1 1 0 0" rgba="0.9 0.1 0.1 1"/>
    <body childclass="v"><geom mesh="other" pos="1 0 0" density="0"/></body>
    <geom type="box" mesh="other" contype="0" conaffinity="0" density="0"/>
  </body></worldbody></mujoco>"""
MASS = b'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


@pytest.mark.parametrize("mass", [MASS, b""])
def test_stl_that_mujoco_does_not_read_is_where_mujoco_has_it(mass):
    """Triangle by triangle; a body without a mass of its own needs its meshes."""
    wedge = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    data = stl.write(Surface(wedge, faces))
    files = {"scene.xml": MESHED.replace(b"{mass}", mass), "assets/wedge.stl": data}
    drawing = look_of_files("scene.xml", files)
    whole = mjcf_text("scene.xml", files, keep_meshes=True)
    model = mujoco.MjSpec.from_string(whole.text, assets=dict(whole.files)).compile()
    expected = look_of(model, {})
    assert [geom.solid for geom in drawing.geoms] == [geom.solid for geom in expected.geoms]
    assert ("stl" in [blob.packing for blob in drawing.blobs]) == (mass == MASS)
    places = [np.sort(surface_of(look).corners.reshape(-1, 3), axis=0) for look in (drawing, expected)]
    assert places[0] == pytest.approx(places[1], abs=1e-6)


def test_picture_from_the_cache_imports_nothing_heavy(tmp_path, cache, guest_like):
    made = preview(cache)
    code = (
        "import sys\nfrom pathlib import Path\nfrom linkwright.pipeline.show import preview as room\n"
        "from linkwright.pipeline.caching.actions import Cache\n"
        "from linkwright.pipeline.caching.store import Store\n"
        f"cache = Cache(Store(Path({str(tmp_path / 'cache')!r})))\n"
        f"found = room.start_drawing(cache, {FILES!r}, {{}}, 'png').result()\n"
        "heavy = [name for name in ('numpy', 'mujoco', 'PIL', 'lxml', 'trimesh') if name in sys.modules]\n"
        "print(found.files, heavy)"
    )
    options = {"cwd": PROJECT, "capture_output": True, "text": True, "check": True}
    done = subprocess.run([sys.executable, "-c", code], **options)
    assert done.stdout.strip() == f"{made.files} []"


def test_refusal_is_kept_and_an_accident_is_tried_again(cache, guest_like):
    guest_like.return_value = {REFUSED: b'{"why": "MuJoCo says no"}'}
    for _ in range(2):
        outcome = preview(cache)
        assert (outcome.files, outcome.path) == ({}, "")
        messages = [(diagnostic.code, diagnostic.message) for diagnostic in outcome.diagnostics]
        assert messages == [("I-PREVIEW", "no preview of the robot: MuJoCo says no")]
    assert guest_like.call_count == 1
    guest_like.return_value = {ENDED: b'{"why": "drawing it crashed"}'}
    for _ in range(2):
        painted = {**FILES, "arm.xml": ARM.replace(b"0.9", b"0.8")}
        (diagnostic,) = preview(cache, painted).diagnostics
        assert "crashed" in diagnostic.message
    assert guest_like.call_count == 3


def test_nothing_is_drawn_unless_requested_and_possible(cache, guest_like):
    assert preview(cache, kind="none") == NONE
    (diagnostic,) = preview(cache, {"arm.sdf": b"", "robot.json": b""}).diagnostics
    assert "none of the exported files" in diagnostic.message
    assert "export=" in diagnostic.hint
    assert guest_like.call_count == 0
    assert [names(kind) for kind in ("none", "png", "turn")] == [(), (PICTURE,), (PICTURE, TURN)]


def test_turn_without_its_library_is_refused_before_the_build(monkeypatch):
    require("turn")
    monkeypatch.setattr(room.importlib.util, "find_spec", lambda name: None)
    require("png")
    with pytest.raises(ConfigError, match="pillow") as caught:
        require("turn")
    assert caught.value.where == "page.preview"
    assert "pip install 'pillow>=" in caught.value.hint
