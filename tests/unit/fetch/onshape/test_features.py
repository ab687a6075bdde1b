"""Asking for limits that the definition lacks: when, of whom, and what is done without variables."""

import dataclasses
import io
import json
import zipfile

import numpy as np
import pytest

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.bundle.archive import pack, read
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.replies import features
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.codec import encode_robot
from linkwright.stages.robot.errors import Offline, ProtocolError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.replies import Replies
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.fake_onshape.settable import typed_arm
from tests.support.building import plan_of
from tests.support.kept import ADDRESS, Kept, fetched, onshape
from tests.support.reported import reports
from tests.support.traffic import asked_kinds, at_path

COLD = {"definition": 1, "massproperties": 1, "tessellatedfaces": 1}
OWNER = Owner(ElementKey("d", "m/1", "e", "default"), "default")


def unknown(made):
    return sorted(where for _, where in reports(build_robot(made.bundle, plan_of()), "W-LIMIT"))


def test_an_old_server_is_asked_once_for_each_moving_assembly(kept):
    with OnshapeServer(typed_arm(), newest=16) as server:
        made = fetched(onshape(server.document_url()), kept, server.environ)
        assert asked_kinds(server) == {**COLD, "currentmicroversion": 1, "features": 2, "variables": 2}
        assert made.calls == server.count == 8
        assert unknown(made) == []
        again = fetched(onshape(server.document_url()), kept, server.environ)
        assert (again.calls, server.count) == (1, 9)
        assert again.bundle == made.bundle
        assert all("/w/" not in request for request in kept)
    offline = fetched(onshape(server.document_url(), offline=True), kept)
    assert offline.bundle == made.bundle


def nested(depth=3):
    """A chain of sub-assemblies, each with a hinge of its own that has limits, and a studio for each."""
    document = Document("Nested")
    inner = None
    for level in range(depth):
        studio = document.studio(f"Studio {level}")
        post, arm = (studio.part(f"{n} {level}", solids.box(0.02, 0.03, 0.1), density=1000) for n in "PA")
        assembly = document.assembly(f"Level {level}")
        base = assembly.add(post, fixed=level == depth - 1)
        ends = (assembly.add(arm), np.eye(4)), (base, frame((0, 0, 0.1)))
        assembly.revolute(f"Hinge {level}", *ends, value=0.1, limits=(-1, None if level else 1))
        if inner is not None:
            held = assembly.add(inner[0])
            assembly.fasten("Held", (held / inner[1], np.eye(4)), (base, frame((0.2, 0, 0))))
        inner = assembly, base
    document.root = inner[0]
    return document


def resized(document, level):
    """The document after an edit of a part, which only its own studio shows."""
    after = document.edited(f"Studio {level}")
    after.part(f"A {level}").solid = solids.box(0.03, 0.03, 0.01 * len(after.microversion[:9]))
    return after


def spent(server, kept):
    """The calls of one more build, by the server's own count, and what was asked for by name."""
    server.reset()
    made = fetched(onshape(server.document_url()), kept, server.environ)
    assert made.calls == server.count
    return server.count, asked_kinds(server), made


def test_nested_limits_cost_no_call_beside_an_edits_own(kept):
    with OnshapeServer(nested()) as server:
        assert spent(server, kept)[0] == 1 + 2 * 3
        assert spent(server, kept)[0] == 1
        server.edit(resized(server.document, 1))
        calls, names, made = spent(server, kept)
        assert (calls, "features" in names, made.bundle.features) == (7, False, ())
        assert unknown(made) == []
        server.edit(resized(server.document, 0))
        assert spent(server, kept)[0] == 6
        versions = {target.split("/")[2] for _, target, _ in server.calls if "/assemblies/" in target}
        assert versions == {"v16", "v17"}  # the mass of the assembly, and its definition


def test_an_old_server_is_asked_again_only_for_changed_features(kept):
    with OnshapeServer(nested(), newest=16) as server:
        kinds = {"definition": 1, "features": 3, "massproperties": 3, "tessellatedfaces": 3}
        assert spent(server, kept)[:2] == (1 + 2 * 3 + 3, kinds)
        server.edit(resized(server.document, 1))
        calls, names, made = spent(server, kept)
        assert (calls, "features" in names) == (7, False)
        assert len(made.bundle.features) == 3
        server.edit(resized(server.document, 0))
        assert spent(server, kept)[0] == 6
        after = server.document.edited("Level 1")
        after.assemblies[1].features[0].limits = (-0.5, 0.5)
        server.edit(after)
        calls, names, made = spent(server, kept)
        assert names["features"] == 1
        robot = build_robot(made.bundle, plan_of())
        assert (-0.5, 0.5) in [(dof.limits.lower, dof.limits.upper) for dof in robot.dofs]
        cold = fetched(onshape(server.document_url()), Kept(), server.environ).bundle
        assert encode_robot(build_robot(cold, plan_of())) == encode_robot(robot)


def test_changed_tabs_are_asked_for_the_sake_of_features_alone():
    """One studio of two replies: to ask which tabs changed would cost as much, but for the three lists."""
    kept, document = Kept(), nested()
    with OnshapeServer(document, newest=16) as server:
        spent(server, kept)
        after = document.edited("Studio 0", "Studio 1", "Studio 2")
        for level in range(3):
            after.part(f"A {level}").solid = solids.box(0.03, 0.03, 0.2)
        server.edit(after)
        calls, names, _ = spent(server, kept)
        # The probe, the definition, what changed, all studios: no list, and nothing to weigh.
        assert (calls, "features" in names) == (1 + 1 + 2 + 2 * 3, False)


def test_replies_of_an_earlier_version_stay_good(kept):
    """Replies that were asked for at v16, before it was taken down at which version that was."""
    with OnshapeServer(nested(), newest=16) as server:
        before = spent(server, kept)[2].bundle
    for subject in [subject for subject in kept.facts if subject.endswith("#api")]:
        del kept.facts[subject]
    with OnshapeServer(nested()) as server:
        calls, names, made = spent(server, kept)
        assert (calls, names) == (1, {"currentmicroversion": 1})
        assert (made.bundle.definition_api, made.bundle.api) == ("v16", "v16")
        assert made.bundle == dataclasses.replace(before, definition_api="v16")
        server.edit(resized(server.document, 1))
        calls, names, made = spent(server, kept)
        assert (calls, "features" in names) == (7, False)
        assert (made.bundle.definition_api, made.bundle.api) == ("v17", "v16")
        assert fetched(onshape(server.document_url("m")), kept).calls == 0


def test_the_identity_of_a_pinned_source_stays():
    keys = onshape(ADDRESS.replace("/w/", "/v/"))
    pin = stage.pinned(keys)
    assert pin["api"] == "v16"
    assert set(pin) == {"kind", "api", "request", "configuration", "tessellation"}


def test_a_bundle_of_an_earlier_version_stays_as_it_was():
    with OnshapeServer(nested(), newest=16) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ).bundle
    new = pack(made)
    assert gather(RecordedAnswers(read(new, "new"), "new")).definition_api == "v17"
    with zipfile.ZipFile(io.BytesIO(new)) as archive:
        manifest = json.loads(archive.read("manifest.json"))
    assert (manifest["api"], manifest["definition_api"]) == ("v16", "v17")
    old = pack(dataclasses.replace(made, definition_api=""))
    bundle = gather(RecordedAnswers(read(old, "old"), "old"))
    assert (bundle.api, bundle.definition_api, len(bundle.features)) == ("v16", "", 3)
    with zipfile.ZipFile(io.BytesIO(pack(bundle))) as archive:
        assert "definition_api" not in json.loads(archive.read("manifest.json"))


@pytest.mark.parametrize("change", ["broken", "suppressed"])
def test_an_assembly_without_a_moving_mate_is_not_asked(change):
    document = typed_arm()
    setattr(document.assemblies[1].features[0], change, True)
    document.changed()
    with OnshapeServer(document, newest=16) as server:
        fetched(onshape(server.document_url()), environ=server.environ)
        assert asked_kinds(server)["features"] == 1


def test_mates_without_limits_of_their_own_are_looked_up(monkeypatch):
    """A definition of which one mate has limits and the other, in a sub-assembly, has none."""
    document = typed_arm()

    def mixed(self, names, pairs, api):
        made = plain(self, names, pairs, api)
        for feature in made["subAssemblies"][0]["features"]:
            feature["featureData"].pop("mateLimits", None)
        return made

    plain = Replies._definition
    monkeypatch.setattr(Replies, "_definition", mixed)
    with OnshapeServer(document) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
        (target,) = [target for _, target, _ in server.calls if "/features" in target]
        assert f"/e/{document.assemblies[1].element}/" in target
        assert unknown(made) == []


def test_variables_are_asked_for_only_where_a_limit_names_one():
    document = typed_arm(low="-30 deg", high="1 rad")
    with OnshapeServer(document, newest=16) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
        assert asked_kinds(server)["variables"] == 1
        of_hand = f"/e/{document.assemblies[1].element}/variables"
        assert [t for _, t, _ in server.calls if "/variables?" in t and of_hand in t]
        assert unknown(made) == []


def test_a_version_has_variables_and_a_microversion_has_none():
    with OnshapeServer(typed_arm(), newest=16) as server:
        version = fetched(onshape(server.document_url("v")), environ=server.environ)
        again = gather(RecordedAnswers(read(pack(version.bundle), "zip"), "zip"))
        assert again == version.bundle
        assert [feature.variables is not None for feature in again.features] == [True, True]
        assert version.calls == 7
        assert unknown(version) == []
        server.reset()
        micro = fetched(onshape(server.document_url("m")), environ=server.environ)
        assert micro.calls == 5
        assert "variables" not in asked_kinds(server)
        assert unknown(micro) == ["curl", "turn"]


def test_variables_of_a_workspace_that_moved_on_are_not_taken(kept):
    document = typed_arm()
    studio, changed = document.variable_studios[0].element, {"Reach": ("ANGLE", "80 deg")}
    with OnshapeServer(document, newest=16) as server:

        def edit_before_variables(method, target, number):
            if "/variables?" in target and server.document is document:
                server.edit(document.with_variables(studio, changed))

        server.fault = edit_before_variables
        made = fetched(onshape(server.document_url()), kept, server.environ)
    assert unknown(made) == ["curl", "turn"]
    assert not [request for request in kept if "/variables" in request]


def test_an_offline_build_asks_for_no_features():
    with OnshapeServer(typed_arm(), newest=16) as server:
        kept = Kept()
        made = fetched(onshape(server.document_url()), kept, server.environ)
    for request in [request for request in kept if "/variables" in request]:
        del kept[request]
    offline = fetched(onshape(server.document_url(), offline=True), kept)
    assert offline.calls == 0
    assert unknown(offline) == ["curl", "turn"]
    assert unknown(made) == []
    for request in [request for request in kept if "/features" in request]:
        del kept[request]
    with pytest.raises(Offline, match="the features of assembly"):
        fetched(onshape(server.document_url(), offline=True), kept)


@pytest.mark.parametrize("body", [b"{", b"[]", b'{"features": 3}', b'{"features": ["x"]}'])
def test_malformed_features_and_variables_are_not_kept(body, kept):
    with OnshapeServer(typed_arm(), newest=16) as server:
        server.fault = at_path(Fault(200, body), "/features")
        with pytest.raises(ProtocolError, match="the features of assembly"):
            fetched(onshape(server.document_url("v")), kept, server.environ)
    assert not [request for request in kept if "/features" in request]
    with pytest.raises(ProtocolError, match="the variables"):
        features.check(body.replace(b"[]", b'["x"]'), "the variables of element e", tables=True)


def test_a_configured_limit_may_name_a_variable_in_any_value():
    value = {"value": {"parameterId": "limitZMax", "expression": "#far + 1 mm"}}
    configured = {"parameterId": "limitZMax", "configurationParameterId": "size", "values": [value]}
    switch = {"parameterId": "limitsEnabled", "configurationParameterId": "size", "values": []}
    body = json.dumps({"features": [{"parameters": [switch, configured]}]}).encode()
    assert features.name_variables(body, OWNER)
    assert not features.name_variables(body, Owner(OWNER.key, "far=1+mm"))
    off = {"parameterId": "limitsEnabled", "value": False}
    body = json.dumps({"features": [{"parameters": [off, configured]}]}).encode()
    assert not features.name_variables(body, OWNER)
