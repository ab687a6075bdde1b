"""The robot as it is written, in the cache's form and back."""

from dataclasses import fields

import pytest

from linkwright.stages.formats.mjcf import written as mjcf_written
from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.formats.written import Written, decode, encode
from linkwright.stages.robot.dynamics.driven import as_driven
from tests.support.truth import differences
from tests.unit.formats.test_described import ACTUATION, AMENDMENTS, GEOMETRY, SCENE, SENSING, whole


@pytest.mark.parametrize("seed", range(3))
def test_the_cached_robot_is_read_as_it_was_written(seed):
    """Nothing is left out: each field differs from its default, except `srdf_form`, which no build sets."""
    robot = whole(seed)
    forms = urdf_form(robot, merged=True), mjcf_written.mjcf_form(robot)
    written = Written(as_driven(robot, ACTUATION), ACTUATION, GEOMETRY, *forms, SENSING, AMENDMENTS, SCENE)
    bare = Written(robot)
    names = [field.name for field in fields(Written)]
    same = [name for name in names if getattr(written, name) == getattr(bare, name)]
    assert same == ["srdf_form"]
    again = decode(encode(written), robot, GEOMETRY)
    assert differences(written, again, 0.0, {"option": "lists"}) == []
