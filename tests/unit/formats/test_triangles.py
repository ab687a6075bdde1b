"""The compact form of triangles with textures; without any it is as it always was."""

import dataclasses

import numpy as np
import pytest

from linkwright.stages.formats import triangles
from linkwright.stages.robot.errors import ProtocolError

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
CORNERS = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
IMAGE = "ab" * 32
UV = np.linspace(0, 1, 24, dtype=np.float32).reshape(4, 3, 2)


def body(**changes: object) -> triangles.Body:
    made = triangles.merged(
        "a", POINTS, CORNERS, [RED, RED, BLUE], np.array([0, 1, 1, 2]), ["", IMAGE, ""], UV
    )
    return dataclasses.replace(made, **changes)


def test_a_body_without_textures_is_as_it_always_was() -> None:
    plain = triangles.merged("a", POINTS, CORNERS, [RED], np.zeros(4, dtype=np.int64))
    header = b'{"bodies":[{"id":"a","points":4,"triangles":4,"palette":[[1.0,0.0,0.0,1.0]]}]}'
    data = triangles.encode([plain])
    assert data == b"".join(
        [
            b"linkwright triangles 1\n",
            len(header).to_bytes(4, "little"),
            header,
            plain.points.tobytes(),
            plain.triangles.tobytes(),
            plain.colours.tobytes(),
        ]
    )
    found = triangles.decode(data)["a"]
    assert (found.textures, found.texcoords, triangles.textures(data)) == ((), None, frozenset())


def test_textures_and_coordinates_come_back_exactly() -> None:
    plain = triangles.merged("b", POINTS, CORNERS, [RED], np.zeros(4, dtype=np.int64))
    data = triangles.encode([body(), plain, dataclasses.replace(body(), id="c")])
    found = triangles.decode(data)
    assert triangles.textures(data) == {IMAGE}
    assert (found["b"].textures, found["b"].texcoords) == ((), None)
    for name in ("a", "c"):
        assert found[name].palette == (BLUE, RED, RED)
        assert found[name].textures == ("", "", IMAGE)
        assert found[name].colours.tolist() == [1, 2, 2, 0]
        wanted = UV.copy()
        wanted[[0, 3]] = 0
        assert np.array_equal(found[name].texcoords, wanted)
    assert list(triangles.decode(data, ["c"])) == ["c"]


def test_a_texture_that_no_triangle_has_is_none() -> None:
    made = triangles.merged("a", POINTS, CORNERS, [RED, RED], np.zeros(4, dtype=np.int64), ["", IMAGE], UV)
    assert (made.textures, made.texcoords) == ((), None)


@pytest.mark.parametrize(
    "changes",
    [
        {"textures": ("", IMAGE)},
        {"textures": ("", "", "../x")},
        {"textures": ("", "", IMAGE + "\n")},
        {"textures": ("", "", IMAGE.upper())},
        {"texcoords": np.full((4, 3, 2), np.nan, np.float32)},
        {"texcoords": np.zeros((3, 3, 2), np.float32)},
    ],
)
def test_malformed_textures_are_refused(changes: dict[str, object]) -> None:
    with pytest.raises(ProtocolError):
        triangles.decode(triangles.encode([body(**changes)]))


def test_coordinates_that_are_cut_short_are_refused() -> None:
    with pytest.raises(ProtocolError, match="announced"):
        triangles.check(triangles.encode([body()])[:-4])
