"""Recorded Onshape data beside the project, and bundles made of it. Absent in a fresh clone."""

import hashlib
import io
import json
import zipfile
from urllib.parse import urlsplit

import pytest

from linkwright.stages.fetch.bundle.archive import read
from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers
from linkwright.stages.robot.bundle import ElementKey
from tests.support.places import SHARED

DATA = SHARED / "data" / "onshape"
KBOT = DATA / "kbot-headless"

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the recorded data is not beside this clone")


def kbot_definition():
    return next(KBOT.glob("assembly_*_default.json")).read_bytes()


def kbot_masses():
    """Recorded mass replies, one a part, by the request that other clients made for them."""
    replies = {}
    for file in sorted(KBOT.glob("part_*_mass_properties.json")):
        metadata = json.loads(file.with_name(file.name.replace("mass_properties", "metadata")).read_text())
        # .../api/metadata/d/<did>/m/<mid>/e/<eid>/p/<pid>, where <pid> may hold "/".
        path = urlsplit(metadata["href"]).path.partition("/api/metadata")[2]
        element, _, part = path.partition("/p/")
        request = f"/parts{element}/partid/{part.replace('/', '%2F').replace('+', '%2B')}/massproperties"
        replies[f"{request}?configuration=default"] = file.read_bytes()
    return replies


def kscale_bundle():
    """Gears across a sub-assembly that is used twice. Nobody recorded what its parts weigh."""
    definition = (DATA / "kscale_dummy_assembly.json").read_bytes()
    root = json.loads(definition)["rootAssembly"]
    listed = (
        f"/assemblies/d/{root['documentId']}/m/{root['documentMicroversion']}/e/{root['elementId']}/features"
    )
    features = (DATA / "kscale_dummy_features.json").read_bytes()
    return pack(definition, {f"{listed}?configuration=default": features, **weightless(definition)})


def nb_bundle():
    """A chain of hinges through a sub-assembly that is used twice. Nobody recorded what its parts weigh."""
    definition = (DATA / "nb_toolkit_assembly.json").read_bytes()
    return pack(definition, weightless(definition))


def weightless(definition):
    """Mass replies that know none of the parts, for every part studio of a definition."""
    studios = {ElementKey.of(part) for part in json.loads(definition)["parts"]}
    asked = [requests.mass_properties(studio, studio.document) for studio in sorted(studios)]
    return dict.fromkeys(asked, b'{"bodies": {}}')


def pack(definition, replies):
    """A bundle of a recorded definition and the replies beside it."""
    root = json.loads(definition)["rootAssembly"]
    asked = (
        f"/assemblies/d/{root['documentId']}/m/{root['documentMicroversion']}/e/{root['elementId']}"
        "?configuration=default&includeMateConnectors=true&includeMateFeatures=true&includeNonSolids=true"
    )
    bodies = {asked: definition, **replies}
    digests = {request: hashlib.sha256(body).hexdigest() for request, body in bodies.items()}
    manifest = {
        "format": 1,
        "kind": "onshape",
        "api": "v16",
        "root": {
            "document": root["documentId"],
            "microversion": root["documentMicroversion"],
            "element": root["elementId"],
            "configuration": "default",
        },
        "definition": digests[asked],
        "requests": digests,
    }
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("manifest.json", json.dumps(manifest))
        for digest, body in sorted({digests[request]: body for request, body in bodies.items()}.items()):
            archive.writestr(f"replies/{digest}", body)
    return buffer.getvalue()


def kbot_bundle():
    return pack(kbot_definition(), kbot_masses())


def bundle_in(archive):
    """What a fetch gives of a bundle in a file."""
    return gather(RecordedAnswers(read(archive, "recorded"), "recorded"))


def definition_in(archive):
    """The assembly definition in a bundle."""
    recording = read(archive, "recorded")
    return recording.blobs[recording.definition]
