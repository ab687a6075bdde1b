"""`ignore`: what is not drawn and what touches nothing, while all that it weighs stays."""

from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.collide import make as collide
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.exports import compiled, exported
from tests.support.robots import joint, robot_with
from tests.support.touching import no_memo
from tests.unit.mesh.test_collide import BRACKET, bundle, kinds, part, robot

BALL = Primitive("sphere", (0.01,), frozen(np.eye(4)))
BOTH = robot(part("Block <1>"), part(BRACKET, 0.2), shapes=(BALL,))


def made(value, **keys):
    merged = {"mesh": {"collider": "hull", "visual": {"merge": "part"}}, **keys}
    return make_geometry(value, bundle(), MeshSections.model_validate(merged), no_memo)


@pytest.mark.parametrize(
    ("visual", "collision", "seen", "solid"),
    [
        ((), (), {"base_block.stl", "base_bracket.stl", "primitive"}, [(BRACKET, "Block <1>")]),
        (["Bl*"], (), {"base_bracket.stl", "primitive"}, [(BRACKET, "Block <1>")]),
        ((), ["Arm <1>/*"], {"base_block.stl", "base_bracket.stl", "primitive"}, [("Block <1>",)]),
        (["Br*"], ["Br*"], {"base_block.stl", "primitive"}, [("Block <1>",)]),
        (["base"], ["Block"], set(), [(BRACKET,)]),
        (["*"], ["*"], set(), []),
    ],
)
def test_globs_on_links_and_parts(visual, collision, seen, solid):
    geometry = made(BOTH, ignore={"visual": visual, "collision": collision})
    assert {shape.file or "primitive" for shape in geometry.shapes if shape.role == "visual"} == seen
    assert [tuple(sorted(names)) for names in kinds(geometry)] == solid
    balls = [shape for shape in geometry.of("base", "collision") if shape.primitive is not None]
    assert len(balls) == ("*" not in collision)


def test_ignored_part_costs_no_collider(monkeypatch):
    names = set()
    monkeypatch.setattr(
        collide._ColliderMaker, "_make", lambda self, job, function: names.add(job.name) or Collision()
    )
    keys = {"mesh": {"collider": "coacd", "colliders": {"Bracket": "coacd"}}}
    made(BOTH, **keys, ignore={"collision": ["Bracket"]})
    assert names == {"Block <1>"}


def test_model_weighs_as_much_and_has_no_such_geom():
    arm = robot_with([joint("revolute", "base", "arm", name="elbow")])
    value = replace(arm, links=tuple(replace(link, parts=(part("Block <1>"),)) for link in arm.links))
    models = [
        compiled(exported(value, made(value, ignore=ignore)))
        for ignore in ({}, {"visual": ["base"], "collision": ["arm"]})
    ]

    def geoms(model):
        rows = [model.geom(number) for number in range(model.ngeom)]
        return sorted((model.body(int(geom.bodyid[0])).name, int(geom.group[0])) for geom in rows)

    assert geoms(models[0]) == [("arm", 2), ("arm", 3), ("base", 2), ("base", 3)]
    assert geoms(models[1]) == [("arm", 2), ("base", 3)]
    np.testing.assert_array_equal(models[0].body_mass, models[1].body_mass)
    np.testing.assert_array_equal(models[0].body_inertia, models[1].body_inertia)


def test_glob_without_a_match_lists_what_there_is():
    with pytest.raises(MeshError) as caught:
        made(BOTH, ignore={"visual": ["Screw*", "*"], "collision": ["bse"]})
    first, other = caught.value.problems
    assert (first.code, first.where, other.where) == ("E-GLOB", "ignore.visual", "ignore.collision")
    assert "Screw*" in first.message
    assert "bse" in other.message
    assert "links are: base; parts are: Block, Bracket" in first.hint
