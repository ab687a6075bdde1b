"""The picture beside a USD, which a process of its own draws."""

import struct

import pytest

from tests.support.building import NO_MESHES
from tests.unit.export.test_usd_simready import arm, meshed, usd_export


@pytest.mark.parametrize("geometry", [NO_MESHES, meshed("part.stl")], ids=["bones", "mesh"])
def test_a_thumbnail_shows_the_robot_and_is_the_same_each_time(geometry):
    files, again = (usd_export(arm(), geometry).files for _ in range(2))
    picture = files[".thumbs/256x256/robot.usda.png"]
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", picture[16:24]) == (256, 256)
    # Of one colour a picture of this size has some hundred bytes.
    assert len(picture) > 2000
    assert files == again
