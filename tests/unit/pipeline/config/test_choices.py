"""What composing leaves open."""

from linkwright.pipeline.config.choices import Choices, resolved_tree


def test_a_preset_of_the_command_line_wins_but_for_keys_set_there():
    tree = {"name": "a", "root": {"base": "fixed", "select": "x"}, "export": {}}
    presets = {"root": {"base": "free", "select": "auto"}}
    choices = Choices("arm", (), (), presets, frozenset({"root.select"}))
    assert resolved_tree(tree, choices)["root"] == {"base": "free", "select": "x"}


def test_a_preset_without_a_value_leaves_the_robots_own():
    tree = {"name": "a", "source": {"kind": "onshape", "url": "mine"}}
    choices = Choices("arm", (), (), {"source": {"kind": "onshape", "url": "???"}})
    assert resolved_tree(tree, choices)["source"] == {"kind": "onshape", "url": "mine"}


def test_keys_of_another_source_go_unless_the_command_line_set_them():
    tree = {"name": "a", "source": {"url": "u", "tessellation": {}, "path": "p", "mine": 1}}
    choices = Choices("arm", (), (), {"source": {"kind": "bundle"}}, frozenset({"source.tessellation.angle"}))
    assert resolved_tree(tree, choices)["source"] == {
        "tessellation": {},
        "path": "p",
        "mine": 1,
        "kind": "bundle",
    }


def test_formats_that_are_not_chosen_go_and_unknown_ones_stay_to_be_judged():
    tree = {"name": "a", "export": {"urdf": {"meshes": "relative"}, "sdff": {}}}
    assert resolved_tree(tree, Choices("arm", ("mjcf",)))["export"] == {"sdff": {}, "mjcf": {}}


def test_the_tree_that_was_given_stays_as_it_was():
    tree = {"source": {"kind": "sample"}, "export": {"urdf": {}}}
    resolved_tree(tree, Choices("bare", ()))
    assert tree == {"source": {"kind": "sample"}, "export": {"urdf": {}}}
