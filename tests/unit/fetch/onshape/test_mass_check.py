"""Our sum of masses against the server's, and the plan of calls."""

import json

import pytest

from linkwright.stages.fetch.onshape.call_budget import allow
from linkwright.stages.fetch.onshape.replies import mass_check
from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import ProtocolError, SourceError
from tests.fake_onshape.definition import definition
from tests.fake_onshape.settable import typed_arm
from tests.fake_onshape.studio_replies import assembly_mass
from tests.support.building import bundle_of


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
WEIGHTS = {StudioKey("D", "m/M", "S", "default"): {"base": 1.0, "bone": 0.25}}


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


def test_the_sum_over_a_whole_robot_is_what_its_document_weighs():
    document = typed_arm()
    document.part("Finger").mass = 0.3
    bundle = bundle_of(document)
    weights = {studio.key: mass_check.read_weights(bundle.blobs[studio.mass[0]]) for studio in bundle.studios}
    total = json.dumps(assembly_mass(document)).encode()
    compared = mass_check.compare(json.dumps(definition(document)).encode(), weights, total)
    assert compared.theirs == pytest.approx(document.truth.total_mass(), rel=1e-12)
    assert compared.ours == pytest.approx(document.truth.total_mass(), rel=1e-12)


@pytest.mark.parametrize("body", [b"", b"[]", b"{}", b'{"mass": []}', b'{"mass": ["much"]}', b"7"])
def test_a_reply_without_a_mass_is_refused(body):
    with pytest.raises(ProtocolError, match="has no mass"):
        mass_check.read_total(body)
    with pytest.raises(ProtocolError, match="without mass properties"):
        mass_check.read_weights(b'{"bodies": {"a": %s}}' % (body or b"null"))


def test_as_many_calls_as_allowed_may_be_made_and_no_more():
    allow(3, 2, 5)
    allow(0, 5, 5)
    with pytest.raises(SourceError, match=r"this build needs 6 calls, but source.max_calls is 5") as caught:
        allow(6, 0, 5)
    assert caught.value.hint == "set source.max_calls=6 or more"
    with pytest.raises(SourceError, match=r"made 1 call and needs 5 more, but source.max_calls is 5"):
        allow(5, 1, 5)
