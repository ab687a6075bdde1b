"""Every kind of body: sheets, composites, hidden and suppressed instances, and their colours."""

import json

import numpy as np
import pytest

from linkwright.stages.fetch.onshape.triangles.faces import read as read_triangles
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import AssemblyError
from tests.fake_onshape import solids
from tests.fake_onshape.extended_sample import ask
from tests.fake_onshape.frames import frame
from tests.fake_onshape.server import OnshapeServer
from tests.support.building import plan_of, robot_of
from tests.support.kept import fetched, onshape
from tests.support.kit import TOP
from tests.support.reported import codes, reports

RED, BLUE = (255, 0, 0), (0, 0, 255)


def geometry_of(document):
    """The robot and its meshes, fetched from a server."""
    with OnshapeServer(document) as server:
        bundle = fetched(onshape(server.document_url()), environ=server.environ).bundle
    robot = build_robot(bundle, plan_of())
    return robot, make_geometry(robot, bundle, plan_of(), lambda kind, key, make: make())


def extent(geometry, link, role):
    """The size [m] of a link's meshes of a role along x, y and z."""
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    files = [shape.file for shape in geometry.shapes if (shape.link, shape.role) == (link, role)]
    corners = np.concatenate(
        [np.frombuffer(geometry.files[file][84:], facet)["corners"].reshape(-1, 3) for file in files]
    )
    return np.ptp(corners, axis=0)


def with_sheet(kit, **more):
    """A base with a sheet, larger than it, on top."""
    base = kit.place("Base", fixed=True)
    sheet = kit.root.add(kit.studio.sheet("Skin", solids.box(0.5, 0.5, 0.001), **more))
    kit.root.fasten("Glue", (sheet, np.eye(4)), (base, TOP))


@pytest.mark.parametrize(("mass", "size"), [(None, [0.02, 0.03]), (0.5, [0.5, 0.5])])
def test_a_sheet_without_mass_is_seen_and_does_not_collide(kit, mass, size):
    with_sheet(kit, mass=mass)
    robot, geometry = geometry_of(kit.document)
    (link,) = robot.links
    assert link.inertial.mass == pytest.approx(0.06 + (mass or 0))
    parts = {part.name: (part.inertial.mass, part.collides) for part in link.parts}
    assert parts == {"Base <1>": (pytest.approx(0.06), True), "Skin <1>": (mass or 0, mass is not None)}
    assert reports(robot, "W-BODY-TYPE") == ([] if mass else [("W-BODY-TYPE", "Skin <1>")])
    assert extent(geometry, link.name, "visual")[:2] == pytest.approx([0.5, 0.5])
    assert extent(geometry, link.name, "collision")[:2] == pytest.approx(size)


def test_a_sheet_that_the_mass_reply_leaves_out_has_none(kit):
    """Whether servers list sheets there is not documented."""
    with_sheet(kit)
    listed = robot_of(kit.document)
    kit.studio.parts.pop()
    robot = robot_of(kit.document)
    assert codes(robot) == codes(listed) == ["W-BODY-TYPE"]
    assert robot.links[0].inertial.mass == listed.links[0].inertial.mass


def test_a_link_of_sheets_alone_cannot_be_built(kit):
    base = kit.place("Base", fixed=True)
    flag = kit.root.add(kit.studio.sheet("Flag", solids.box(0.5, 0.5, 0.001)))
    kit.root.revolute("Wave", (flag, np.eye(4)), (base, TOP), limits=(-1, 1))
    with pytest.raises(AssemblyError, match=r"E-MASS flag: .*are sheets or weigh nothing"):
        robot_of(kit.document)


def composed(kit):
    """A base, and a composite of two bars of different densities that turns on it."""
    base = kit.place("Base", fixed=True)
    light = kit.studio.part("Light", solids.box(0.1, 0.1, 0.1), density=1000, colour=RED)
    heavy = kit.studio.part("Heavy", solids.box(0.1, 0.1, 0.1, (0.2, 0, 0)), density=3000, colour=BLUE)
    whole = kit.root.add(kit.studio.composite("Whole", [light, heavy]))
    kit.root.revolute("Turn", (whole, np.eye(4)), (base, TOP), limits=(-1, 1))
    return light, heavy


def test_a_composite_weighs_as_its_entry(kit):
    composed(kit)
    robot, geometry = geometry_of(kit.document)
    link = robot.link("whole")
    assert link.inertial.mass == pytest.approx(4.0)
    assert link.inertial.com == pytest.approx([0.15, 0, 0])
    assert [part.name for part in link.parts] == ["Whole <1>"]
    assert codes(robot) == []
    assert extent(geometry, "whole", "visual") == pytest.approx([0.3, 0.1, 0.1])
    colours = {shape.colour for shape in geometry.shapes if (shape.link, shape.role) == ("whole", "visual")}
    assert colours == {(1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)}


@pytest.mark.parametrize("combine", ["true", "false"])
def test_a_composite_is_read_however_the_server_sends_it(kit, combine):
    composed(kit)
    query = {"outputIndexTable": "true", "combineCompositePartConstituents": combine}
    reply = ask(kit.document, "tessellatedfaces", kit.studio.element, **query)
    bodies = {body.id: body for body in read_triangles(json.dumps(reply).encode())}
    whole = bodies[kit.studio.parts[-1].id]
    assert len(whole.triangles) == 24
    assert np.ptp(whole.points, axis=0) == pytest.approx([0.3, 0.1, 0.1])


def test_hidden_instances_are_built_and_suppressed_ones_are_not(kit):
    base = kit.place("Base", fixed=True)
    for name, more in (("Seen", {}), ("Hidden", {"hidden": True}), ("Gone", {"suppressed": True})):
        part = kit.root.add(kit.bar(name), **more)
        kit.root.fasten(f"{name} on", (part, np.eye(4)), (base, TOP), suppressed=name == "Gone")
    robot, geometry = geometry_of(kit.document)
    (link,) = robot.links
    assert sorted(part.name for part in link.parts) == ["Base <1>", "Hidden <1>", "Seen <1>"]
    assert link.inertial.mass == pytest.approx(3 * 0.06)
    assert len(geometry.shapes) == 2


def test_appearances_are_the_parts_own_and_the_faces_own(kit):
    colours = {"colour": RED, "face_colours": {"+x": (*BLUE, 128)}}
    part = kit.studio.part("Box", solids.box(0.1, 0.1, 0.1), density=1000, **colours)
    kit.root.add(part, fixed=True, pose=frame((1, 0, 0)))
    _, geometry = geometry_of(kit.document)
    faces = sorted({shape.colour for shape in geometry.shapes if shape.role == "visual"})
    assert faces == [(0.0, 0.0, 1.0, pytest.approx(128 / 255)), (1.0, 0.0, 0.0, 1.0)]
