"""The local Onshape's replies: the shapes of Onshape's description and recordings, and what it refuses."""

import base64
import json

import pytest

from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.signing import headers
from tests.fake_onshape.auth import Gate
from tests.fake_onshape.bundle import requests
from tests.fake_onshape.extended_sample import ask, extended_sample, studio
from tests.fake_onshape.replies import PATHS, QUERIES, Replies
from tests.fake_onshape.settable import configured_stand, driven_stand, typed_arm
from tests.support.places import SHARED

RECORDED = SHARED / "data" / "onshape"

# Where the description does not say what the server sends (recordings and clients do).
FEATURE_DATA = {
    "mate": {"name", "mateType", "mateLimits", "matedEntities"},
    "mateRelation": {"name", "relationType", "relationRatio", "reverseDirection", "mates"},
    "mateGroup": {"name", "occurrences"},
    "mateConnector": {"name", "occurrence", "mateConnectorCS"},
}


def recorded(name):
    path = RECORDED / name
    if not path.exists():
        pytest.skip(f"no recording {name}")
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def api():
    return recorded("openapi.json")


@pytest.fixture(scope="module")
def document():
    return extended_sample()


def properties_of(schema, schemas):
    """The properties of a schema and of all that it is made of."""
    properties, pending = {}, [schema]
    while pending:
        part = pending.pop()
        if "$ref" in part:
            part = schemas[part["$ref"].rsplit("/", 1)[1]]
        properties |= part.get("properties", {})
        pending += part.get("allOf", [])
    return properties


def conforms(api, schema, value, where):
    """Every key that we send is in the schema and has a value of its type."""
    schemas = api["components"]["schemas"]
    while "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        if isinstance(value, dict) and value.get("btType") in schemas:
            name = value["btType"]
        schema = schemas[name]
    if value is None:
        return
    properties = properties_of(schema, schemas)
    if isinstance(value, dict):
        for key, inner in value.items():
            if key in properties:
                conforms(api, properties[key], inner, f"{where}.{key}")
            elif "get" + key in properties:  # a generator's slip: getxAxis for xAxis
                conforms(api, properties["get" + key], inner, f"{where}.{key}")
            else:
                assert "additionalProperties" in schema or is_feature_data(where, key), f"{where}.{key}"
                if "additionalProperties" in schema:
                    conforms(api, schema["additionalProperties"], inner, f"{where}.{key}")
        return
    kind = schema.get("type")
    if kind == "array" and isinstance(value, str):
        # Bytes are described as a list and sent as base64.
        assert schema["items"].get("format") == "byte", where
        assert base64.b64decode(value, validate=True)
    elif kind == "array":
        assert isinstance(value, list), where
        for inner in value:
            conforms(api, schema["items"], inner, f"{where}[]")
    else:
        allowed = {"string": str, "boolean": bool, "integer": int, "number": (int, float)}[kind]
        assert isinstance(value, allowed), where
        assert not (isinstance(value, bool) and kind != "boolean"), where
        assert value in schema.get("enum", [value]), where


def is_feature_data(where, key):
    return where.endswith("featureData") and any(key in keys for keys in FEATURE_DATA.values())


def sent_conforms(api, document, endpoint, element, **query):
    responses = next(iter(api["paths"][PATHS[endpoint]]["get"]["responses"].values()))
    schema = next(iter(responses["content"].values()))["schema"]
    conforms(api, schema, ask(document, endpoint, element, **query), endpoint)


def test_every_key_and_type_that_is_sent_is_in_the_description(api, document):
    parts, root = studio(document, "Extras").element, document.root.element
    flags = {"includeMateFeatures": "true", "includeMateConnectors": "true"}
    sent_conforms(api, document, "definition", root, **flags)
    for flag in ("true", "false"):
        group = {"massAsGroup": flag, "useMassPropertyOverrides": flag}
        sent_conforms(api, document, "massproperties", parts, **group)
        faces = {"outputIndexTable": flag, "outputFacetNormals": flag, "outputFaceAppearances": flag}
        sent_conforms(api, document, "tessellatedfaces", parts, **faces)
    for endpoint, element in (("currentmicroversion", ""), ("elements", ""), ("features", root)):
        sent_conforms(api, document, endpoint, element)


def test_settings_are_as_in_the_description(api):
    stand, driven = configured_stand(), driven_stand()
    tools = stand.studios[2].element
    for element in (stand.root.element, tools):
        sent_conforms(api, stand, "configuration", element)
    sent_conforms(api, stand, "massproperties", tools, configuration="jaw=L")
    for flag in ("true", "false"):
        for tab in (driven.root, driven.studios[0], driven.variable_studios[0]):
            flags = {"includeValuesAndReferencedVariables": flag}
            sent_conforms(api, driven, "variables", tab.element, **flags)
    sent_conforms(api, driven, "elements", "")
    post = api["paths"][PATHS["variables"].replace("{wv}/{wvid}", "w/{wid}")]["post"]
    schema = next(iter(post["requestBody"]["content"].values()))["schema"]
    rows = [
        {"name": name, "type": kind, "expression": expression, "description": ""}
        for name, (kind, expression) in driven.variable_studios[0].table.items()
    ]
    conforms(api, schema, rows, "post")


@pytest.mark.parametrize("old", [True, False])
def test_a_list_of_features_has_the_recorded_keys(old):
    document = typed_arm()
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}/features"
    ours = json.loads(Replies(document, old=old).answer(path).body)
    real = recorded("kscale_dummy_features.json")
    assert set(real) <= set(ours)
    assert isinstance(ours["featureStates"], list if old else dict)

    def opened(record):
        return record.get("message", record)

    def mates(reply):
        return [entry for entry in map(opened, reply["features"]) if entry["featureType"] == "mate"]

    theirs = {entry["parameterId"]: entry for entry in map(opened, mates(real)[0]["parameters"])}
    for mate in mates(ours):
        assert {"featureId", "name", "parameters", "suppressed"} <= set(mate)
        for parameter in map(opened, mate["parameters"]):
            assert parameter["parameterId"] in theirs
            recorded_shape = theirs[parameter["parameterId"]]
            assert set(parameter) - {"btType"} <= set(recorded_shape)
            assert all(
                type(parameter[key]) is type(recorded_shape[key]) for key in set(parameter) - {"btType"}
            )
    if old:
        assert set(ours["features"][0]) == set(real["features"][0])
        assert set(ours["featureStates"][0]) == set(real["featureStates"][0])


@pytest.mark.parametrize("name", ["kscale_dummy_features.json", "kbot"])
def test_typed_and_untyped_limits_look_as_recorded(name):
    """Limits are compared by whether they are null, what they say of being empty, and what they hold."""

    def looks(reply):
        for feature in reply["features"]:
            inside = [
                parameter.get("message", parameter)
                for parameter in feature.get("message", feature)["parameters"]
            ]
            for entry in inside:
                if entry["parameterId"].startswith("limit") and entry["parameterId"] != "limitsEnabled":
                    text = "typed" if entry["nullValue"] == "" else entry["expression"]
                    plain = (entry["isNull"], entry["nullValue"], text, entry["value"], entry["units"])
                    yield entry["parameterId"], *plain

    files = sorted(RECORDED.glob("kbot-headless/features_*.json")) if name == "kbot" else [RECORDED / name]
    if not files or not files[0].exists():
        pytest.skip(f"no recording {name}")
    real = {look for file in files for look in looks(json.loads(file.read_text()))}
    document = typed_arm()
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}/features"
    ours = list(looks(json.loads(Replies(document).answer(path).body)))
    # Of all that is typed the recordings have turns only.
    assert {look for look in ours if look[3] != "typed"} <= real
    assert {(*look[1:], look[0][-3:]) for look in ours if look[3] == "typed"} <= {
        (False, "", "typed", 0.0, "", "Min"),
        (False, "", "typed", 0.0, "", "Max"),
    }
    if name == "kbot":
        assert {look[1:] for look in real if look[3] == "typed"} == {(False, "", "typed", 0.0, "")}


def test_accepted_queries_are_those_of_the_description(api):
    for endpoint, path in PATHS.items():
        described = {p["name"] for p in api["paths"][path]["get"]["parameters"] if p["in"] == "query"}
        assert QUERIES[endpoint] == described, endpoint


def test_ids_have_onshapes_length_and_letters(document):
    instances = [place.instance.id for place in document.truth.places.values()]
    parts = [part.id for home in document.homes for studio in home.studios for part in studio.parts]
    assert {len(i) for i in instances} == {17}
    for ids in (instances, parts):
        text = "".join(ids)
        assert "/" in text
        assert "+" in text
    for home in document.homes:
        for each in home.studios:
            assert len({part.id for part in each.parts}) == len(each.parts)


def test_requests_that_onshape_refuses_are_refused(document):
    replies = Replies(document)
    definition, studios = requests(document)
    linked = next(request for request in studios if "/v/" in request)
    masses = next(request for request in studios if "/m/" in request and "/massproperties" in request)
    for request, status in (
        (linked, 200),
        (definition + "&includeSuppressed=true", 400),
        (definition.replace("includeMateFeatures=true", "includeMateFeatures=yes"), 400),
        (masses + "&partId=nope", 400),
        (linked.replace("linkDocumentId", "partId"), 403),
        (definition.replace(document.microversion, "0" * 24), 404),
    ):
        assert replies.answer(*request.split("?")).status == status, request


def test_a_signature_holds_for_one_request_and_its_headers_once():
    gate, target = Gate(("acc", "sec"), "token"), "/api/v16/x?a=b"
    signed = headers(Credentials("acc", "sec", "signature"), "GET", target)
    for change, why in (
        ({"On-Nonce": "short"}, "nonce"),
        ({"Date": "Mon, 02 Mar 2020 10:11:12 GMT"}, "too far"),
        ({"Date": "today"}, "date"),
        ({"Content-Type": "text/plain"}, "signature"),
    ):
        assert why in gate.refuses("GET", target, {**signed, **change})
    assert "signature" in gate.refuses("GET", "/api/v16/x?a=c", signed)
    assert gate.refuses("GET", target, signed) == ""
    assert "nonce" in gate.refuses("GET", target, signed)
