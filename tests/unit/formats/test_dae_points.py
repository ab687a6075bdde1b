"""Points of a COLLADA file: placed by its nodes and in its unit, as pycollada and a closed form have them."""

import io
import math
import re

import numpy as np
import pytest

from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.meshes.dae_points import dae_points

DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01</created><modified>2020-01-01</modified><unit meter="0.01"/></asset>
<library_geometries><geometry id="g"><mesh>
  <source id="at"><float_array id="numbers" count="15">0 0 0 1 0 0 0 2 0 0 0 3 9 9 9</float_array>
    <technique_common><accessor source="#numbers" count="5" stride="3"><param name="X" type="float"/>
      <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
  <source id="up"><float_array id="ups" count="3">0 0 1</float_array>
    <technique_common><accessor source="#ups" count="1" stride="3"><param name="X" type="float"/>
      <param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#at"/></vertices>
  <triangles count="2"><input semantic="NORMAL" source="#up" offset="0"/>
    <input semantic="VERTEX" source="#v" offset="1"/><p>0 0 0 1 0 2 0 0 0 1 0 3</p></triangles>
</mesh></geometry></library_geometries>
<library_nodes><node id="part"><translate>0 0 1</translate><instance_geometry url="#g"/></node>
</library_nodes>
<library_visual_scenes><visual_scene id="s">
  <node><rotate>0 0 1 90</rotate><scale>1 2 3</scale><instance_geometry url="#g"/>
    <node><matrix>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</matrix><instance_node url="#part"/></node></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""

SOLID = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
"""The points that the triangles use."""


def distinct(points):
    """The points, each once and sorted, to a micrometre: pycollada computes in single precision."""
    return np.unique(np.round(points, 6) + 0.0, axis=0)


def test_points_are_placed_by_nodes_and_in_metres():
    def scaled(points):
        x, y, z = (points * [1, 2, 3]).T
        return 0.01 * np.stack([-y, x, z], axis=1)

    expected = np.concatenate([scaled(SOLID), scaled(SOLID + np.array([5, 6, 8]))])
    assert distinct(dae_points(DAE.encode())) == pytest.approx(distinct(expected), abs=1e-9)


def test_points_are_those_of_pycollada():
    collada = pytest.importorskip("collada")
    document = collada.Collada(io.BytesIO(DAE.encode()))
    placed = [
        part.vertex[part.vertex_index].reshape(-1, 3)
        for shape in document.scene.objects("geometry")
        for part in shape.primitives()
    ]
    expected = document.assetInfo.unitmeter * np.concatenate(placed)
    assert distinct(dae_points(DAE.encode())) == pytest.approx(distinct(expected), abs=1e-6)


def test_elements_may_have_a_prefix():
    prefixed = re.sub(r"<(/?)(\w)", r"<\1c:\2", DAE).replace("xmlns=", "xmlns:c=")
    assert (dae_points(prefixed.encode()) == dae_points(DAE.encode())).all()


def test_points_of_all_uses_are_limited(monkeypatch):
    monkeypatch.setattr("linkwright.stages.formats.meshes.dae_points._MAX_POINTS", 7)
    with pytest.raises(Damaged, match="more than 7 points"):
        dae_points(DAE.encode())


@pytest.mark.parametrize(("old", "new"), [
    ('url="#part"', 'url="#nowhere"'),
    ("<translate>0 0 1</translate>", '<instance_node url="#part"/>'),
    ("<p>0 0 0 1", "<p>0 0 0 99"),
    ("<p>0 0 0 1", "<p>0 0 0 inf"),
    ('offset="1"', 'offset="inf"'),
    ('offset="1"', 'offset="-1"'),
    ("<translate>0 0 1</translate>", "<translate>0 one</translate>"),
    ("<translate>0 0 1</translate>", "<skew>45 0 1 0 1 0 0</skew>"),
])  # fmt: skip
def test_file_that_is_not_whole_is_damaged(old, new):
    assert old in DAE
    with pytest.raises(Damaged):
        dae_points(DAE.replace(old, new).encode())


def test_nodes_that_multiply_without_end_are_damaged():
    """Each of twenty nodes uses the next one twice."""
    use = '<instance_node url="#n{}"/>'.format
    nodes = "".join(f'<node id="n{n}">{2 * use(n + 1)}</node>' for n in range(20))
    text = DAE.replace('<node id="part">', f'{nodes}<node id="n20"/><node id="part">')
    with pytest.raises(Damaged):
        dae_points(text.replace('url="#part"', 'url="#n0"').encode())
    assert math.isfinite(dae_points(text.encode()).sum())
