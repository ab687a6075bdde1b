"""The compact form of triangles, with and without textures."""

import dataclasses

import numpy as np
import pytest

from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import ProtocolError

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
CORNERS = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
IMAGE = "ab" * 32
UV = np.linspace(0, 1, 24, dtype=np.float32).reshape(4, 3, 2)


PLAIN = body_arrays.merged("b", POINTS, CORNERS, [RED], np.zeros(4, dtype=np.int64))


def body(**changes):
    colours, images = [RED, RED, BLUE], ["", IMAGE, ""]
    made = body_arrays.merged("a", POINTS, CORNERS, colours, np.array([0, 1, 1, 2]), images, UV)
    return dataclasses.replace(made, **changes)


def test_body_without_textures_has_no_coordinates_of_an_image():
    header = b'{"bodies":[{"id":"b","points":4,"triangles":4,"palette":[[1.0,0.0,0.0,1.0]]}]}'
    arrays = (array.tobytes() for array in (PLAIN.points, PLAIN.triangles, PLAIN.colours))
    data = body_arrays.encode([PLAIN])
    assert data == b"".join([b"linkwright triangles 1\n", len(header).to_bytes(4, "little"), header, *arrays])
    decoded = body_arrays.decode(data)["b"]
    assert (decoded.textures, decoded.texcoords, triangles.textures(data)) == ((), None, frozenset())


def test_textures_and_coordinates_come_back_exactly():
    data = body_arrays.encode([body(), PLAIN, dataclasses.replace(body(), id="c")])
    decoded = body_arrays.decode(data)
    assert triangles.textures(data) == {IMAGE}
    assert (decoded["b"].textures, decoded["b"].texcoords) == ((), None)
    for name in ("a", "c"):
        assert decoded[name].palette == (BLUE, RED, RED)
        assert decoded[name].textures == ("", "", IMAGE)
        assert decoded[name].colours.tolist() == [1, 2, 2, 0]
        wanted = UV.copy()
        wanted[[0, 3]] = 0
        assert np.array_equal(decoded[name].texcoords, wanted)
    assert list(body_arrays.decode(data, ["c"])) == ["c"]


def test_more_colours_than_an_index_counts_are_refused():
    count = (1 << 16) + 1
    colours = [(index / count, 0.0, 0.0, 1.0) for index in range(count)]
    with pytest.raises(ValueError, match=f"{count} colours"):
        body_arrays.merged("a", POINTS, CORNERS[[0] * count], colours, np.arange(count))


def test_texture_that_no_triangle_has_is_left_out():
    made = body_arrays.merged("a", POINTS, CORNERS, [RED, RED], np.zeros(4, dtype=np.int64), ["", IMAGE], UV)
    assert (made.textures, made.texcoords) == ((), None)


@pytest.mark.parametrize("changes", [
    {"textures": ("", IMAGE)},
    {"textures": ("", "", "../x")},
    {"textures": ("", "", IMAGE + "\n")},
    {"textures": ("", "", IMAGE.upper())},
    {"texcoords": np.full((4, 3, 2), np.nan, np.float32)},
    {"texcoords": np.zeros((3, 3, 2), np.float32)},
])  # fmt: skip
def test_malformed_textures_are_refused(changes):
    with pytest.raises(ProtocolError):
        body_arrays.decode(body_arrays.encode([body(**changes)]))


def test_coordinates_that_are_cut_short_are_refused():
    with pytest.raises(ProtocolError, match="announces"):
        triangles.require_compact(body_arrays.encode([body()])[:-4])
