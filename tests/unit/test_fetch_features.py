"""Asking for limits that the definition lacks: when, of whom, and what is done without variables."""

import json

import pytest

from stages.fetch import features
from stages.fetch.features import Owner
from stages.graph import build_robot
from stages.robot.bundle import StudioKey
from stages.robot.errors import Offline, ProtocolError
from tests.building import plan_of
from tests.kept import Kept, fetched, onshape
from tests.onshape.server import Fault, OnshapeServer
from tests.onshape.settable import typed_arm

OWNER = Owner(StudioKey("d", "m/1", "e", "default"), "default")


def asked(server):
    """How often each kind of request was made: by the last piece of its path."""
    names = [target.partition("?")[0].rpartition("/")[2] for _, target, _ in server.calls]
    return {name: names.count(name) for name in sorted(set(names)) if len(name) < 24}


def unknown(made):
    robot = build_robot(made.bundle, plan_of())
    return sorted(d.where for d in robot.diagnostics if d.code == "W-LIMIT")


def test_a_server_that_sends_limits_is_not_asked_for_features():
    with OnshapeServer(typed_arm()) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
        assert made.bundle.features == ()
        assert asked(server) == {"massproperties": 1, "tessellatedfaces": 1}


def test_an_old_server_is_asked_once_for_each_assembly_with_moving_mates_and_once_for_its_variables():
    kept = Kept()
    with OnshapeServer(typed_arm(), newest=16) as server:
        made = fetched(onshape(server.document_url()), kept, server.environ)
        calls = {"currentmicroversion": 1, "features": 2, "massproperties": 1, "tessellatedfaces": 1}
        assert asked(server) == {**calls, "variables": 2}
        assert made.calls == server.count == 8
        assert unknown(made) == []
        again = fetched(onshape(server.document_url()), kept, server.environ)
        assert (again.calls, server.count) == (1, 9)
        assert again.bundle == made.bundle
        assert all("/w/" not in request for request in kept)
    offline = fetched(onshape(server.document_url(), offline=True), kept)
    assert offline.bundle == made.bundle


def test_variables_are_asked_for_only_where_a_limit_names_one():
    document = typed_arm(low="-30 deg", high="1 rad")
    with OnshapeServer(document, newest=16) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
        assert asked(server)["variables"] == 1
        of_hand = f"/e/{document.assemblies[1].element}/variables"
        assert [t for _, t, _ in server.calls if "/variables?" in t and of_hand in t]
        assert unknown(made) == []


def test_an_assembly_of_fastened_mates_alone_is_not_asked():
    document = typed_arm()
    document.assemblies[1].features[0].suppressed = True
    document.changed()
    with OnshapeServer(document, newest=16) as server:
        fetched(onshape(server.document_url()), environ=server.environ)
        assert asked(server)["features"] == 1


def test_a_version_has_variables_and_a_microversion_has_none():
    with OnshapeServer(typed_arm(), newest=16) as server:
        version = fetched(onshape(server.document_url("v")), environ=server.environ)
        assert version.calls == 7
        assert unknown(version) == []
        server.reset()
        micro = fetched(onshape(server.document_url("m")), environ=server.environ)
        assert micro.calls == 5
        assert "variables" not in asked(server)
        assert unknown(micro) == ["curl", "turn"]


def test_variables_of_a_workspace_that_moved_on_are_not_taken_for_those_of_what_is_built():
    document = typed_arm()
    kept = Kept()
    with OnshapeServer(document, newest=16) as server:

        def edit_before_variables(method, target, number):
            if "/variables?" in target and server.document is document:
                server.edit(document.with_variables(
                    document.variable_studios[0].element, {"Reach": ("ANGLE", "80 deg")}
                ))  # fmt: skip
            return

        server.fault = edit_before_variables
        made = fetched(onshape(server.document_url()), kept, server.environ)
    assert unknown(made) == ["curl", "turn"]
    assert not [request for request in kept if "/variables" in request]


def test_a_bundle_keeps_what_was_asked_and_builds_the_same(tmp_path):
    from stages.fetch.bundle import pack, read
    from stages.fetch.onshape import gather
    from stages.fetch.recorded import Recorded

    with OnshapeServer(typed_arm(), newest=16) as server:
        made = fetched(onshape(server.document_url("v")), environ=server.environ)
    again = gather(Recorded(read(pack(made.bundle), "zip"), "zip"))
    assert again == made.bundle
    assert [one.variables is not None for one in again.features] == [True, True]


def test_nothing_is_asked_offline():
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
def test_a_list_of_features_that_is_none_is_not_kept(body):
    kept = Kept()
    with OnshapeServer(typed_arm(), newest=16) as server:
        server.fault = lambda method, target, number: Fault(200, body) if "/features" in target else None
        with pytest.raises(ProtocolError, match="the features of assembly"):
            fetched(onshape(server.document_url("v")), kept, server.environ)
    assert not [request for request in kept if "/features" in request]


@pytest.mark.parametrize("body", [b"{", b"{}", b'["x"]'])
def test_variables_that_are_none_are_refused(body):
    with pytest.raises(ProtocolError, match="the variables"):
        features.check(body, "the variables of element e", tables=True)


def test_a_limit_that_the_configuration_sets_may_name_a_variable_in_any_of_its_values():
    value = {"value": {"parameterId": "limitZMax", "expression": "#far + 1 mm"}}
    configured = {"parameterId": "limitZMax", "configurationParameterId": "size", "values": [value]}
    switch = {"parameterId": "limitsEnabled", "configurationParameterId": "size", "values": []}
    body = json.dumps({"features": [{"parameters": [switch, configured]}]}).encode()
    assert features.name_variables(body, OWNER)
    assert not features.name_variables(body, Owner(OWNER.key, "far=1+mm"))
    off = {"parameterId": "limitsEnabled", "value": False}
    body = json.dumps({"features": [{"parameters": [off, configured]}]}).encode()
    assert not features.name_variables(body, OWNER)
