"""The robot as it is written: what the cache keeps of it, and the robot of each format."""

from dataclasses import fields

import pytest

from linkwright.stages.formats.mjcf import written as mjcf_written
from linkwright.stages.formats.urdf.as_written import form_with
from linkwright.stages.formats.written import Written, decode, encode
from linkwright.stages.robot.dynamics.driven import as_driven
from tests.support.truth import differences
from tests.unit.formats.test_described import ACTUATION, AMENDMENTS, GEOMETRY, SCENE, SENSING, whole


@pytest.mark.parametrize("seed", range(3))
def test_what_the_cache_keeps_is_read_as_it_was_written(seed: int) -> None:
    """Nothing is left out: each field differs from its default, but for what no build knows."""
    robot = whole(seed)
    forms = form_with(robot, merged=True), mjcf_written.form_with(robot)
    written = Written(as_driven(robot, ACTUATION), ACTUATION, GEOMETRY, *forms, SENSING, AMENDMENTS, SCENE)
    bare = Written(robot)
    same = [
        field.name for field in fields(Written) if getattr(written, field.name) == getattr(bare, field.name)
    ]
    assert same == ["srdf_form"]
    found = decode(encode(written), robot, GEOMETRY)
    assert differences(written, found, 0.0, {"option": "lists"}) == []
