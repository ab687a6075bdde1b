"""Keys of the mesh stage that change nothing are named."""

import pytest

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS
from linkwright.stages.mesh.idle_keys import idle_keys
from tests.support.building import plan_of


@pytest.mark.parametrize(
    ("keys", "makers", "source", "named"),
    [
        ({}, (), "onshape", []),
        ({"mesh__tolerance": 0.002}, (), "onshape", ["mesh.tolerance"]),
        ({"mesh__tolerance": 0.002}, (COLLIDERS["spheres"],), "onshape", []),
        ({"mesh": {"tolerance": 0.002, "effort": "low"}}, (COLLIDERS["ladder"],), "onshape", []),
        ({"mesh": {"effort": "low", "fine": "all"}}, (BY_CONTACT,), "onshape", ["mesh.effort"]),
        ({"mesh__fine": "all"}, (COLLIDERS["hull"],), "onshape", ["mesh.fine"]),
        (
            {"mesh": {"collider": "spheres", "effort": "low"}},
            (COLLIDERS["spheres"],),
            "onshape",
            ["mesh.effort"],
        ),
        (
            {"mesh": {"coacd": {"mcts_iterations": 9}, "extra_volume": 1}},
            (COLLIDERS["coacd"],),
            "urdf",
            ["mesh.extra_volume"],
        ),
        ({"mesh__basis": "visual"}, (), "onshape", ["mesh.basis"]),
        ({"mesh__basis": "visual"}, (), "mjcf", []),
        ({"mesh__glb_up": "y"}, (), "onshape", ["mesh.glb_up"]),
        ({"mesh": {"glb_up": "y", "format": "glb"}}, (), "onshape", []),
        ({"contact__exclude": [["a", "b"]]}, (), "onshape", ["contact.exclude"]),
        ({"contact": {"exclude": [["a", "b"]], "self": "auto"}}, (), "onshape", []),
    ],
)
def test_a_key_that_nothing_reads_is_named(keys, makers, source, named):
    found = list(idle_keys(plan_of(**keys), makers, source))
    assert [problem.where for problem in found] == named
    assert {problem.code for problem in found} <= {"I-IDLE-KEY"}
