"""The local Onshape's replies have Onshape's own shapes: its description and recorded replies."""

import base64
import json

import pytest

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


def test_every_key_and_type_that_is_sent_is_in_the_description(api, document):
    def check(endpoint, name, **query):
        path = PATHS[endpoint]
        responses = next(iter(api["paths"][path]["get"]["responses"].values()))
        schema = next(iter(responses["content"].values()))["schema"]
        conforms(api, schema, ask(document, endpoint, name, **query), endpoint)

    parts = studio(document, "Extras").element
    check("definition", document.root.element, includeMateFeatures="true", includeMateConnectors="true")
    for flags in ("true", "false"):
        check("massproperties", parts, massAsGroup=flags, useMassPropertyOverrides=flags)
        check("tessellatedfaces", parts, outputIndexTable=flags, outputFacetNormals=flags)
        check("tessellatedfaces", parts, outputFaceAppearances=flags, outputVertexNormals=flags)
    check("currentmicroversion", "")
    check("elements", "")
    check("features", document.root.element)


def test_what_can_be_set_is_reported_as_the_description_has_it(api):
    def check(made, endpoint, element, **query):
        path = PATHS[endpoint]
        responses = next(iter(api["paths"][path]["get"]["responses"].values()))
        schema = next(iter(responses["content"].values()))["schema"]
        conforms(api, schema, ask(made, endpoint, element, **query), endpoint)

    stand, driven = configured_stand(), driven_stand()
    check(stand, "configuration", stand.root.element)
    check(stand, "configuration", stand.studios[2].element)
    check(stand, "massproperties", stand.studios[2].element, configuration="jaw=L")
    for flag in ("true", "false"):
        for element in (driven.root, driven.studios[0], driven.variable_studios[0]):
            check(driven, "variables", element.element, includeValuesAndReferencedVariables=flag)
    check(driven, "elements", "")
    post = api["paths"][PATHS["variables"].replace("{wv}/{wvid}", "w/{wid}")]["post"]
    schema = next(iter(post["requestBody"]["content"].values()))["schema"]
    rows = [
        {"name": name, "type": kind, "expression": expression, "description": ""}
        for name, (kind, expression) in driven.variable_studios[0].table.items()
    ]
    conforms(api, schema, rows, "post")


@pytest.mark.parametrize("old", [True, False])
def test_a_list_of_features_has_the_recorded_keys_in_both_envelopes(old):
    document = typed_arm()
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}/features"
    ours = json.loads(Replies(document, old=old).answer(path).body)
    real = recorded("kscale_dummy_features.json")
    assert set(real) <= set(ours)
    assert isinstance(ours["featureStates"], list if old else dict)

    def opened(record):
        return record.get("message", record)

    def mates(reply):
        return [one for one in map(opened, reply["features"]) if one["featureType"] == "mate"]

    theirs = {one["parameterId"]: one for one in map(opened, mates(real)[0]["parameters"])}
    for mate in mates(ours):
        assert {"featureId", "name", "parameters", "suppressed"} <= set(mate)
        for one in map(opened, mate["parameters"]):
            assert one["parameterId"] in theirs
            known = theirs[one["parameterId"]]
            assert set(one) - {"btType"} <= set(known)
            assert all(type(one[key]) is type(known[key]) for key in set(one) - {"btType"})
    if old:
        assert set(ours["features"][0]) == set(real["features"][0])
        assert set(ours["featureStates"][0]) == set(real["featureStates"][0])


@pytest.mark.parametrize("name", ["kscale_dummy_features.json", "kbot"])
def test_limits_that_were_typed_and_that_were_not_look_as_in_every_recording(name):
    """Of each limit: whether it is null, what it says of being empty, and what it holds, typed or not."""

    def looks(reply):
        for feature in reply["features"]:
            inside = [one.get("message", one) for one in feature.get("message", feature)["parameters"]]
            for one in inside:
                if one["parameterId"].startswith("limit") and one["parameterId"] != "limitsEnabled":
                    text = "typed" if one["nullValue"] == "" else one["expression"]
                    plain = (one["isNull"], one["nullValue"], text, one["value"], one["units"])
                    yield one["parameterId"], *plain

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


def test_the_queries_that_are_accepted_are_those_of_the_description(api):
    for endpoint, path in PATHS.items():
        described = {p["name"] for p in api["paths"][path]["get"]["parameters"] if p["in"] == "query"}
        assert QUERIES[endpoint] == described, endpoint


@pytest.mark.parametrize("name", ["kscale_dummy_assembly.json", "kbot"])
def test_the_definition_has_every_key_that_was_recorded_with_the_same_types(name, document):
    if name == "kbot":
        found = sorted(RECORDED.glob("kbot-headless/assembly_*_default.json"))
        real = json.loads(found[0].read_text()) if found else pytest.skip("no recording of the K-Bot")
    else:
        real = recorded(name)
    ours = ask(
        document,
        "definition",
        document.root.element,
        includeMateFeatures="true",
        includeMateConnectors="true",
    )

    def shapes(made):
        assemblies = [made["rootAssembly"], *made["subAssemblies"]]
        instances = [i for a in assemblies for i in a["instances"]]
        features = [f for a in assemblies for f in a["features"]]
        yield "definition", [made]
        yield "root", [made["rootAssembly"]]
        yield "sub", made["subAssemblies"]
        yield "part", made["parts"]
        yield "occurrence", made["rootAssembly"]["occurrences"]
        for kind in ("Part", "Assembly"):
            yield kind, [i for i in instances if i.get("type") == kind]
        yield "feature", features
        for kind in ("mate", "mateRelation"):
            yield kind, [f["featureData"] for f in features if f["featureType"] == kind]
        mated = [e for f in features for e in f["featureData"].get("matedEntities", [])]
        yield "entity", mated
        yield "cs", [entity["matedCS"] for entity in mated]

    real_shapes, our_shapes = dict(shapes(real)), dict(shapes(ours))
    for kind, records in real_shapes.items():
        for record in records:
            for mine in our_shapes[kind]:
                assert set(record) <= set(mine), kind
                for key, value in record.items():
                    assert type(value) is type(mine[key]), f"{kind}.{key}"


def test_mass_properties_have_the_recorded_keys_and_lengths(document):
    real = recorded("star_partstudio_massproperties_subset.json")
    ours = ask(document, "massproperties", studio(document, "Extras").element, massAsGroup="false")
    assert set(ours) == set(real)
    for body in real["bodies"].values():
        for mine in ours["bodies"].values():
            assert set(mine) == set(body)
            for key, value in body.items():
                assert type(mine[key]) is type(value), key
                if isinstance(value, list):
                    assert len(mine[key]) == len(value), key


def test_tessellated_faces_have_the_recorded_keys(document):
    real = recorded("star_tessellatedfaces_subset.json")
    ours = ask(document, "tessellatedfaces", studio(document, "Arm").element, outputFacetNormals="false")
    assert set(real) <= set(ours)
    body, mine = real["bodies"][0], ours["bodies"][0]
    assert set(body) <= set(mine)
    face, facet = mine["faces"][0], mine["faces"][0]["facets"][0]
    assert set(body["faces"][0]) <= set(face)
    assert set(facet) == {"vertices"}
    assert [set(vertex) for vertex in facet["vertices"]] == [{"x", "y", "z"}] * 3
