"""A document as a bundle: the replies that a build reads, in one deterministic zip."""

import hashlib
import io
import json
import zipfile
from urllib.parse import quote, urlencode

from tests.fake_onshape.elements import Mate
from tests.fake_onshape.replies import NEWEST, RESOLVED, Replies

API, DEFINITION_API = "v16", "v17"
TESSELLATION = {"angleTolerance": 0.2, "chordTolerance": 0.0005}


def canonical(path, query):
    """A request as bundles name it: the path below /api/vN and the query, keys sorted."""
    texts = {
        key: str(value).lower() if isinstance(value, bool) else str(value) for key, value in query.items()
    }
    return f"{path}?{urlencode(sorted(texts.items()), quote_via=quote, safe='')}"


def requests(document, tessellation=None):
    """(the definition's request, the part studios' requests), pinned and canonical."""
    root = document.root
    flags = dict.fromkeys(("includeMateConnectors", "includeMateFeatures", "includeNonSolids"), True)
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{root.element}"
    definition = canonical(path, {"configuration": "default", **flags})
    studios = {
        (place.instance.source.studio, place.instance.configuration)
        for place in document.truth.places.values()
        if place.instance.is_part
    }
    asked = []
    for studio, configuration in studios:
        home = studio.home
        pin = f"v/{home.version}" if home.linked else f"m/{home.microversion}"
        path = f"/partstudios/d/{home.id}/{pin}/e/{studio.element}"
        query = {"configuration": configuration, **({"linkDocumentId": document.id} if home.linked else {})}
        mass = {**query, "massAsGroup": False, "useMassPropertyOverrides": True}
        flags = {"outputFaceAppearances": True, "outputFacetNormals": False, "outputIndexTable": True}
        faces = {**query, **(tessellation or TESSELLATION), **flags}
        asked += [canonical(f"{path}/massproperties", mass), canonical(f"{path}/tessellatedfaces", faces)]
    return definition, sorted(asked)


def lists_of_features(document):
    """The requests for features of all assemblies with a mate that moves, pinned and canonical."""
    places = [place.instance for place in document.truth.places.values()]
    used = {(i.source, i.configuration) for i in places if not i.is_part} | {(document.root, "default")}
    asked = []
    for assembly, configuration in used:
        if not any(isinstance(feature, Mate) and feature.type != "FASTENED" for feature in assembly.features):
            continue
        home = assembly.home
        pin = f"v/{home.version}" if home.linked else f"m/{home.microversion}"
        query = {"configuration": configuration, **({"linkDocumentId": document.id} if home.linked else {})}
        asked.append(canonical(f"/assemblies/d/{home.id}/{pin}/e/{assembly.element}/features", query))
    return sorted(asked)


def bundle_bytes(document, tessellation=None, **options):
    """The zip of a document: `manifest.json` and `replies/<sha256>`.

    `tessellation`: {"angleTolerance": rad, "chordTolerance": m}; `options`: those of `Replies`. From a
    server whose newest version of the API is too old for limits, the lists of features are there too.
    """
    replies = Replies(document, **options)
    definition, studios = requests(document, tessellation)
    digests, bodies = {}, {}
    lists = lists_of_features(document) if options.get("newest", NEWEST) < RESOLVED else []
    for request in [definition, *studios, *lists]:
        reply = replies.answer(*request.split("?"))
        if reply.status != 200:
            msg = f"{request}: {reply.status} {reply.body.decode()}"
            raise ValueError(msg)
        digests[request] = hashlib.sha256(reply.body).hexdigest()
        bodies[digests[request]] = reply.body
    state = {"document": document.id, "microversion": document.microversion, "element": document.root.element}
    manifest = {
        "format": 1,
        "kind": "onshape",
        "api": API,
        "definition_api": DEFINITION_API,
        "root": {**state, "configuration": "default"},
        "definition": digests[definition],
        "requests": digests,
    }
    text = json.dumps(manifest, indent=1, sort_keys=True).encode()
    return _zip({"manifest.json": text, **{f"replies/{digest}": body for digest, body in bodies.items()}})


def _zip(entries):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, body in sorted(entries.items()):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            entry.create_system = 3
            archive.writestr(entry, body, zipfile.ZIP_DEFLATED, 9)
    return buffer.getvalue()


def write_robot(folder, name, document, yaml):
    """Writes a document's bundle `name`.zip and the robot `name`, as a user has them."""
    (folder / f"{name}.zip").write_bytes(bundle_bytes(document))
    (folder / "robot").mkdir(exist_ok=True)
    (folder / "robot" / f"{name}.yaml").write_text(yaml)
