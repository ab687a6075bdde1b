"""The form of requests, and which part studios a definition asks for."""

import json
from types import SimpleNamespace

import pytest

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.definition import read, require_parts
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import AssemblyError, ProtocolError

QUALITY = SimpleNamespace(angle=0.2, chord=0.0005, max_facet_width=None)
OWN = ElementKey("doc", "m/micro", "elem", "default")
LINKED = ElementKey("other", "v/version", "elem", "List_x=_500_mm;leg=0.25+meter")


def test_requests_reach_linked_documents_through_the_root():
    assert requests.definition("doc", "w/space", "elem", "a=b") == (
        "/assemblies/d/doc/w/space/e/elem?configuration=a%3Db&includeMateConnectors=true"
        "&includeMateFeatures=true&includeNonSolids=true"
    )
    assert requests.mass_properties(OWN, "doc") == (
        "/partstudios/d/doc/m/micro/e/elem/massproperties"
        "?configuration=default&massAsGroup=false&useMassPropertyOverrides=true"
    )
    assert requests.tessellated_faces(LINKED, "doc", QUALITY) == (
        "/partstudios/d/other/v/version/e/elem/tessellatedfaces?angleTolerance=0.2&chordTolerance=0.0005"
        "&configuration=List_x%3D_500_mm%3Bleg%3D0.25%2Bmeter&linkDocumentId=doc"
        "&outputFaceAppearances=true&outputFacetNormals=false&outputIndexTable=true"
    )
    assert requests.current_microversion("doc", "space") == "/documents/d/doc/w/space/currentmicroversion"
    assert requests.elements("doc", "micro") == "/documents/d/doc/m/micro/elements"
    # Part ids with slashes and pluses are encoded.
    path = requests.part_mass_properties(OWN, "J/F+a=").partition("?")[0]
    assert path == "/parts/d/doc/m/micro/e/elem/partid/J%2FF%2Ba%3D/massproperties"


def test_a_facet_width_is_sent_only_where_one_is_set():
    wide = SimpleNamespace(angle=0.2, chord=0.0005, max_facet_width=0.01)
    assert "&maxFacetWidth=0.01&" in requests.tessellated_faces(OWN, "doc", wide)
    assert "maxFacetWidth" not in requests.tessellated_faces(OWN, "doc", QUALITY)


def test_a_recording_is_found_whatever_its_quality():
    asked = requests.subject(requests.recorded_faces(LINKED))
    assert asked == requests.subject(requests.tessellated_faces(LINKED, "doc", QUALITY))
    other = ElementKey("other", "v/version", "elem", "default")
    assert asked != requests.subject(requests.recorded_faces(other))
    part = requests.part_mass_properties(OWN, "JHD")
    bare = part.partition("?")[0]
    assert {requests.subject(bare + query) for query in ("", "?inferMetadataOwner=true")} == {
        requests.subject(part)
    }
    # Mass as a group does not stand in for mass by part.
    request = requests.mass_properties(OWN, "doc")
    grouped = request.replace("massAsGroup=false", "massAsGroup=true")
    assert requests.subject(request) != requests.subject(grouped)


def test_the_mass_of_an_assembly_is_a_kind_of_its_own():
    request = requests.assembly_mass_properties("doc", "m/micro", "elem", "a=b")
    assert request == "/assemblies/d/doc/m/micro/e/elem/massproperties?configuration=a%3Db"
    assert requests.is_assembly_mass(request)
    assert not requests.is_definition(request)
    assert requests.is_definition(requests.definition("doc", "m/micro", "elem", "a=b"))
    assert not requests.is_assembly_mass(requests.mass_properties(OWN, "doc"))


def test_messages_name_what_was_asked_for():
    assert [
        requests.describe(request)
        for request in (
            requests.current_microversion("doc", "space"),
            requests.elements("doc", "micro"),
            requests.assembly_mass_properties("doc", "m/micro", "elem", "default"),
        )
    ] == ["the current microversion of document doc", "the tabs of document doc", "the mass of assembly elem"]


RECORD = {"suppressed": False, "documentId": "d", "documentMicroversion": "m", "configuration": "default"}


def part(studio, part_id, **more):
    return {"type": "Part", **RECORD, "elementId": studio, "partId": part_id, **more}


def sub(element, **more):
    return {"type": "Assembly", **RECORD, "elementId": element, "name": element, **more}


def definition(instances, subs=()):
    root = {"documentId": "d", "documentMicroversion": "m", "elementId": "root", "configuration": "default"}
    tree = {"rootAssembly": {**root, "instances": instances}, "subAssemblies": list(subs)}
    return json.dumps(tree).encode()


def test_a_studio_version_and_configuration_counts_once():
    parts = [part("s", "JHD"), part("s", "JHD"), part("s", "J/+"), part("s", "JHD", configuration="x=2")]
    linked = part("t", "A", documentId="o", documentVersion="v")
    inner = sub("arm") | {"instances": [part("s", "JHH")]}
    body = definition([*parts, linked, sub("arm"), sub("arm")], [inner])
    assert read(body).parts == {
        ElementKey("d", "m/m", "s", "default"): ("J/+", "JHD", "JHH"),
        ElementKey("d", "m/m", "s", "x=2"): ("JHD",),
        ElementKey("o", "v/v", "t", "default"): ("A",),
    }


def test_a_suppressed_instance_needs_no_studio():
    gone = [
        {"id": "x", "suppressed": True},
        part("unused", "JHD", suppressed=True),
        sub("arm", suppressed=True),
    ]
    inner = sub("arm") | {"instances": [part("also-unused", "JHD")]}
    body = definition([part("s", "JHD"), *gone], [inner])
    assert [key.element for key in read(body).parts] == ["s"]


@pytest.mark.parametrize("instances", [[], [part("s", "JHD", suppressed=True)], [{"type": "Feature"}]])
def test_an_assembly_without_parts_is_named_empty(instances):
    with pytest.raises(AssemblyError, match="assembly root: the assembly is empty"):
        require_parts(read(definition(instances)))


@pytest.mark.parametrize(
    ("body", "why"),
    [
        (b'{"rootAssembly": {"insta', "not JSON"),
        (b"[]", "unknown format"),
        (b'{"bodies": {}}', "lacks the key 'rootAssembly'"),
        (b'{"rootAssembly": null}', "unknown format"),
        (definition([sub("arm")]), "does not describe the sub-assembly 'arm'"),
        (definition([{"type": "Part", "documentId": "d"}]), "lacks the key 'documentMicroversion'"),
        (definition([]).replace(b'"documentId": "d"', b'"documentId": 7'), "documentId is not text"),
    ],
)
def test_a_malformed_definition_is_a_protocol_error(body, why):
    with pytest.raises(ProtocolError, match=why):
        read(body)
