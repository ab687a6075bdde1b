"""Our sum of masses against the server's."""

import json

import pytest

from linkwright.stages.fetch.onshape.replies import mass_check
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import ProtocolError


def instance(name, kind="Part", element="S", **more):
    address = {"documentId": "D", "documentMicroversion": "M", "elementId": element}
    return {"id": name, "type": kind, "partId": name, **address, **more}


ADDRESS = {"documentId": "D", "documentMicroversion": "M", "elementId": "Arm"}
INSTANCES = [
    instance("base"), instance("left", "Assembly", "Arm"), instance("right", "Assembly", "Arm"),
    instance("old", suppressed=True), instance("sketch", "Feature"),
]  # fmt: skip
PATHS = ("base", "left", "left bone", "right", "right bone", "old", "sketch", "gone bone")
OCCURRENCES = [{"path": path.split(), "hidden": path == "right bone"} for path in PATHS]
DEFINITION = {
    "rootAssembly": {**ADDRESS, "elementId": "Root", "instances": INSTANCES, "occurrences": OCCURRENCES},
    "subAssemblies": [{**ADDRESS, "instances": [instance("bone")]}],
}
WEIGHTS = {ElementKey("D", "m/M", "S", "default"): {"base": 1.0, "bone": 0.25}}


def masses(theirs, weights=WEIGHTS):
    return mass_check.compare(json.dumps(DEFINITION).encode(), weights, b'{"mass": [%r]}' % theirs)


def test_occurrences_count_at_any_depth_hidden_or_not():
    assert masses(1.5) == mass_check.Masses(1.5, 1.5, 1.25)
    totals = (1.5, 1.5 + 1e-7, 1.25, 1.5001, 1.4, 0.0)
    assert [masses(total).agree for total in totals] == [True, True, True, False, False, False]
    diagnostic = mass_check.Masses(1.5, 2.25, 2.25).diagnostic("abc")
    assert (diagnostic.code, diagnostic.level, diagnostic.where) == ("W-VERIFY", "warning", "assembly abc")
    assert "2.25 kg" in diagnostic.message
    assert "1.5 kg" in diagnostic.message


def test_parts_without_mass_count_nothing():
    assert masses(0.0, {}).agree
    assert mass_check.read_weights(
        b'{"bodies": {"a": {"mass": [2, 1, 3]}, "b": {"mass": [7, 7, 7], "hasMass": false}}}'
    ) == {"a": 2.0, "b": 0.0}


@pytest.mark.parametrize("body", [b"", b"[]", b"{}", b'{"mass": []}', b'{"mass": ["much"]}', b"7"])
def test_a_reply_without_a_mass_is_refused(body):
    with pytest.raises(ProtocolError, match="has no mass"):
        mass_check.read_total(body)
    with pytest.raises(ProtocolError, match="without mass properties"):
        mass_check.read_weights(b'{"bodies": {"a": %s}}' % (body or b"null"))
