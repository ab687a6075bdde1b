"""Answers to what other clients ask below unversioned /api paths: part by part, in the old envelopes.

The document, its elements and the assembly's definition; its features as `{typeName, message}` and its
mate values; and of each part its STL (by way of a redirect), its metadata and its mass properties.
"""

import json
import re
from urllib.parse import unquote

import numpy as np

from tests.fake_onshape.document import Assembly
from tests.fake_onshape.elements import Mate, Relation, Studio
from tests.fake_onshape.mates import FREEDOMS, bounds
from tests.fake_onshape.replies import RefusedError, Reply, error_body
from tests.fake_onshape.studio_replies import mass_properties

_AT = "/d/(?P<did>[0-9a-f]{24})/(?P<kind>[wvm])/(?P<wvmid>[0-9a-f]{24})/e/(?P<eid>[0-9a-f]{24})"
_PATTERNS = {
    "document": re.compile("/documents/(?P<did>[0-9a-f]{24})$"),
    "features": re.compile(f"/assemblies{_AT}/features$"),
    "matevalues": re.compile(f"/assemblies{_AT}/matevalues$"),
    # Where the redirect leads: Onshape sends the same path to another host.
    "stl_file": re.compile(f"/parts{_AT}/partid/(?P<pid>.+)/stl/file$"),
    "stl": re.compile(f"/parts{_AT}/partid/(?P<pid>.+)/stl$"),
    "metadata": re.compile(f"/metadata{_AT}/p/(?P<pid>.+)$"),
    "element_metadata": re.compile(f"/metadata{_AT}$"),
    "part_massproperties": re.compile(f"/parts{_AT}/partid/(?P<pid>.+)/massproperties$"),
}
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class PeerReplies:
    """A document as other clients ask for it; what they have in common with us `replies` answers.

    `origin`: scheme and host that redirects lead to.
    """

    def __init__(self, replies, origin):
        self.replies, self.document, self.origin = replies, replies.document, origin

    def answer(self, path, query=""):
        """The reply to GET /api`path`?`query`, and headers of its own."""
        for name, pattern in _PATTERNS.items():
            match = pattern.match(unquote(path))
            if match is None:
                continue
            try:
                if name == "stl":
                    self._part(match.groupdict(), query)
                    return Reply(307, b"", name), {"Location": f"{self.origin}/api{path}/file?{query}"}
                body = getattr(self, f"_{name}")(match.groupdict(), query)
            except RefusedError as refused:
                return Reply(refused.status, error_body(refused.status, refused.message)), {}
            if isinstance(body, bytes):
                return Reply(200, body, name), {"Content-Type": "application/octet-stream"}
            return Reply(200, json.dumps(body, separators=(",", ":")).encode(), name), {}
        return self.replies.answer(path, query, api=0), {}

    def _document(self, names, query):
        if names["did"] != self.document.id:
            raise RefusedError(404, f"Document {names['did']} does not exist.")
        home = {"id": self.document.workspace, "name": "Main", "type": "workspace"}
        return {"id": self.document.id, "name": self.document.name, "defaultWorkspace": home}

    def _features(self, names, query):
        assembly = self.replies.element(names, query, Assembly)
        kinds = {Mate: _mate, Relation: _relation}
        features = [kinds[type(feature)](feature) for feature in assembly.features if type(feature) in kinds]
        return {"features": features, "featureStates": [], "isComplete": True}

    def _matevalues(self, names, query):
        assembly = self.replies.element(names, query, Assembly)
        if names["kind"] == "m":
            raise RefusedError(400, "Mate values are of a workspace or a version.")
        saved = self.document.truth.saved
        axes = {"REVOLUTE": "rotationZ", "SLIDER": "translationZ"}
        mates = [mate for mate in assembly.features if isinstance(mate, Mate) and mate.type in axes]
        return {
            "mateValues": [
                {
                    "featureId": mate.id,
                    "mateName": mate.name,
                    axes[mate.type]: saved.get(mate.name, mate.value),
                }
                for mate in mates
            ]
        }

    def _stl_file(self, names, query):
        """Binary STL in metres."""
        _, part = self._part(names, query)
        triangles = np.concatenate([face.triangles for face in part.solid.faces])
        facets = np.zeros(len(triangles), _FACET)
        facets["corners"] = part.solid.vertices[triangles]
        a, b, c = part.solid.vertices[triangles].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        facets["normal"] = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        return b"STL".ljust(80) + np.uint32(len(facets)).tobytes() + facets.tobytes()

    def _metadata(self, names, query):
        _, part = self._part(names, query)
        red, green, blue, opacity = (*part.colour, 255)[:4]
        colour = {"red": int(red), "green": int(green), "blue": int(blue)}
        appearance = {"color": colour, "opacity": int(opacity), "isGenerated": False}
        return {
            "jsonType": "metadata-part",
            "partId": part.id,
            "properties": [{"name": "Name", "value": part.name}, {"name": "Appearance", "value": appearance}],
        }

    def _element_metadata(self, names, query):
        assembly = self.replies.element(names, query, Assembly)
        return {"jsonType": "metadata-element", "properties": [{"name": "Name", "value": assembly.name}]}

    def _part_massproperties(self, names, query):
        studio, part = self._part(names, query)
        overrides = "useMassPropertyOverrides=true" in query.lower()
        return mass_properties(studio, [part], as_group=False, overrides=overrides)

    def _part(self, names, query):
        studio = self.replies.element(names, query, Studio)
        part = next((part for part in studio.parts if part.id == names["pid"]), None)
        if part is None:
            raise RefusedError(404, f"Part {names['pid']} does not exist.")
        return studio, part


def _mate(mate):
    limits = bounds(mate.type, mate.limits)
    parameters = [_boolean("limitsEnabled", any(end is not None for pair in limits for end in pair))]
    for freedom, pair in zip(FREEDOMS[mate.type], limits, strict=True):
        unit = "m" if freedom.kind == "slide" else "rad"
        for name, end in zip(freedom.limit_names, pair, strict=True):
            if name is not None:
                limit = {"parameterId": name, "expression": "" if end is None else f"{end!r} {unit}"}
                parameters.append(_parameter("BTMParameterNullableQuantity", **limit))
    return _feature("BTMMate", mate, "mate", parameters)


def _relation(relation):
    queries = [_parameter("BTMFeatureQueryWithOccurrence", featureId=mate.id) for _, mate in relation.mates]
    name = "relationLength" if relation.by_length else "relationRatio"
    text = f"{float(relation.amount)!r} m" if relation.by_length else repr(float(relation.amount))
    parameters = [
        _parameter("BTMParameterQueryWithOccurrenceList", parameterId="matesQuery", queries=queries),
        _parameter("BTMParameterQuantity", parameterId=name, expression=text),
        _boolean("reverseDirection", relation.reverse),
    ]
    return _feature("BTMMateRelation", relation, "mateRelation", parameters)


def _feature(kind, feature, name, parameters):
    message = {"featureId": feature.id, "name": feature.name, "featureType": name, "parameters": parameters}
    return {"typeName": kind, "message": {**message, "suppressed": getattr(feature, "suppressed", False)}}


def _boolean(name, value):
    return _parameter("BTMParameterBoolean", parameterId=name, value=value)


def _parameter(kind, **message):
    return {"typeName": kind, "message": message}
