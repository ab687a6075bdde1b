"""What composing leaves open."""

import copy

import pytest

from linkwright.pipeline.config.choices import Choices, resolve_choices
from linkwright.pipeline.config.presets import SEVERAL

NONE = dict.fromkeys(SEVERAL, ())
"""No option of a group that takes several."""

ROOT, URL = {"base": "fixed", "select": "x"}, {"kind": "onshape", "url": "mine"}
FREE = {"root": {"base": "free", "select": "auto"}}
FOREIGN = {"url": "u", "tessellation": {}, "path": "p", "mine": 1}


@pytest.mark.parametrize(("key", "tree", "choices", "expected"), [
    pytest.param("root", ROOT, [NONE, (), FREE, frozenset({"root.select"})],
        {"base": "free", "select": "x"}, id="a preset of the command line wins but for keys set there"),
    pytest.param("source", URL, [NONE, (), {"source": {"kind": "onshape", "url": "???"}}], URL,
        id="a preset without a value leaves the robot's own"),
    pytest.param("source", FOREIGN,
        [NONE, (), {"source": {"kind": "bundle"}}, frozenset({"source.tessellation.angle"})],
        {"tessellation": {}, "path": "p", "mine": 1, "kind": "bundle"},
        id="keys of another source go unless the command line set them"),
    pytest.param("export", {"urdf": {"meshes": "relative"}, "sdff": {}}, [{**NONE, "export": ("mjcf",)}],
        {"sdff": {}, "mjcf": {}}, id="formats that are not chosen go and unknown ones stay to be judged"),
])  # fmt: skip
def test_what_is_chosen_wins_over_the_tree_which_stays_as_it_was(key, tree, choices, expected):
    whole = {"name": "a", key: tree}
    before = copy.deepcopy(whole)
    assert resolve_choices(whole, Choices("arm", *choices))[key] == expected
    assert whole == before
