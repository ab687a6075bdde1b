"""Our sum of masses against the server's, and the plan of calls."""

import json

import pytest

from linkwright.stages.fetch.onshape.call_budget import allow
from linkwright.stages.fetch.onshape.replies import mass_check
from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import ProtocolError, SourceError
from tests.fake_onshape.definition import definition
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.studio_replies import assembly_mass
from tests.support.building import bundle_of


def occurrence(path, **more):
    return {"path": path.split(), **more}


def instance(name, kind="Part", element="S", **more):
    address = {"documentId": "D", "documentMicroversion": "M", "elementId": element}
    return {"id": name, "type": kind, "partId": name, **address, **more}


ADDRESS = {"documentId": "D", "documentMicroversion": "M", "elementId": "Arm"}
DEFINITION = {
    "rootAssembly": {
        **ADDRESS,
        "elementId": "Root",
        "instances": [
            instance("base"),
            instance("left", "Assembly", "Arm"),
            instance("right", "Assembly", "Arm"),
            instance("old", suppressed=True),
            instance("sketch", "Feature"),
        ],
        "occurrences": [
            occurrence("base"),
            occurrence("left"),
            occurrence("left bone"),
            occurrence("right"),
            occurrence("right bone", hidden=True),
            occurrence("old"),
            occurrence("sketch"),
            occurrence("gone bone"),
        ],
    },
    "subAssemblies": [{**ADDRESS, "instances": [instance("bone")]}],
}
WEIGHTS = {StudioKey("D", "m/M", "S", "default"): {"base": 1.0, "bone": 0.25}}


def masses(theirs, weights=WEIGHTS):
    return mass_check.compare(json.dumps(DEFINITION).encode(), weights, b'{"mass": [%r]}' % theirs)


def test_every_occurrence_of_a_part_counts_at_any_depth():
    assert masses(1.5) == mass_check.Masses(1.5, 1.5, 1.25)


@pytest.mark.parametrize(
    ("theirs", "agree"),
    [(1.5, True), (1.5 + 1e-7, True), (1.25, True), (1.5001, False), (1.4, False), (0.0, False)],
)
def test_rounding_and_hidden_parts_make_no_difference(theirs, agree):
    assert masses(theirs).agree is agree


def test_parts_without_mass_count_nothing():
    assert masses(0.0, {}).agree
    assert mass_check.read_weights(
        b'{"bodies": {"a": {"mass": [2, 1, 3]}, "b": {"mass": [7, 7, 7], "hasMass": false}}}'
    ) == {"a": 2.0, "b": 0.0}


def test_the_sum_over_a_whole_robot_is_what_its_document_weighs():
    document = sample_document()
    bundle = bundle_of(document)
    weights = {studio.key: mass_check.read_weights(bundle.blobs[studio.mass[0]]) for studio in bundle.studios}
    total = json.dumps(assembly_mass(document)).encode()
    found = mass_check.compare(json.dumps(definition(document)).encode(), weights, total)
    assert found.theirs == pytest.approx(document.truth.total_mass(), rel=1e-12)
    assert found.ours == pytest.approx(document.truth.total_mass(), rel=1e-12)


def test_the_diagnostic_names_both_masses():
    found = mass_check.Masses(1.5, 2.25, 2.25).diagnostic("abc")
    assert (found.code, found.level, found.where) == ("W-VERIFY", "warning", "assembly abc")
    assert "2.25 kg" in found.message
    assert "1.5 kg" in found.message


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
