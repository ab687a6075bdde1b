"""What fetch reads of a definition: the part studios in use, each once, and nothing suppressed."""

import json

import pytest

from linkwright.stages.fetch.onshape.definition import read, require_parts
from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import AssemblyError, ProtocolError

RECORD = {"suppressed": False, "documentId": "d", "documentMicroversion": "m", "configuration": "default"}


def part(studio, part_id, **more):
    return {"type": "Part", **RECORD, "elementId": studio, "partId": part_id, **more}


def sub(element, **more):
    return {"type": "Assembly", **RECORD, "elementId": element, "name": element, **more}


def definition(instances, subs=()):
    root = {"documentId": "d", "documentMicroversion": "m", "elementId": "root", "configuration": "default"}
    tree = {"rootAssembly": {**root, "instances": instances}, "subAssemblies": list(subs)}
    return json.dumps(tree).encode()


def test_each_studio_version_and_configuration_counts_once():
    parts = [part("s", "JHD"), part("s", "JHD"), part("s", "J/+"), part("s", "JHD", configuration="x=2")]
    linked = part("t", "A", documentId="o", documentVersion="v")
    inner = sub("arm") | {"instances": [part("s", "JHH")]}
    body = definition([*parts, linked, sub("arm"), sub("arm")], [inner])
    assert read(body).parts == {
        StudioKey("d", "m/m", "s", "default"): ("J/+", "JHD", "JHH"),
        StudioKey("d", "m/m", "s", "x=2"): ("JHD",),
        StudioKey("o", "v/v", "t", "default"): ("A",),
    }


def test_what_is_suppressed_needs_no_studio():
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
def test_what_is_no_definition_is_a_protocol_error(body, why):
    with pytest.raises(ProtocolError, match=why):
        read(body)
