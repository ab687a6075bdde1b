"""Answers to requests: paths and queries below /api/vN to a status and a JSON body.

Two versions are played, v16 and v17. They differ in the definition: limits of mates are resolved there
from v17 on.
"""

import json
import re
from dataclasses import dataclass
from urllib.parse import parse_qsl, unquote

from tests.fake_onshape import settings
from tests.fake_onshape.definition import definition
from tests.fake_onshape.document import Assembly
from tests.fake_onshape.elements import Studio
from tests.fake_onshape.feature_replies import features
from tests.fake_onshape.gltf import gltf
from tests.fake_onshape.settings import BadSettingError
from tests.fake_onshape.studio_replies import assembly_mass, mass_properties, tessellated_faces
from tests.fake_onshape.variables import VariableStudio, tables

NEWEST = 17
"""The newest version of the API that the local Onshape plays."""
RESOLVED = 17
"""The first version whose definition has the limits of mates."""

PATHS = {
    "definition": "/assemblies/d/{did}/{wvm}/{wvmid}/e/{eid}",
    "massproperties": "/partstudios/d/{did}/{wvm}/{wvmid}/e/{eid}/massproperties",
    "tessellatedfaces": "/partstudios/d/{did}/{wvm}/{wvmid}/e/{eid}/tessellatedfaces",
    "gltf": "/partstudios/d/{did}/{wvm}/{wvmid}/e/{eid}/gltf",
    "assemblymass": "/assemblies/d/{did}/{wvm}/{wvmid}/e/{eid}/massproperties",
    "configuration": "/elements/d/{did}/{wvm}/{wvmid}/e/{eid}/configuration",
    "features": "/assemblies/d/{did}/{wvm}/{wvmid}/e/{eid}/features",
    "variables": "/variables/d/{did}/{wv}/{wvid}/e/{eid}/variables",
    "currentmicroversion": "/documents/d/{did}/{wv}/{wvid}/currentmicroversion",
    "elements": "/documents/d/{did}/{wvm}/{wvmid}/elements",
}
_STUDIO = "linkDocumentId configuration rollbackBarIndex elementMicroversionId partId"
_FACES = f"{_STUDIO} angleTolerance chordTolerance precomputedLevelOfDetail faceId maxFacetWidth"
_FACES += " outputFaceAppearances"
_QUERIES = {
    "definition": "linkDocumentId configuration explodedViewId includeMateFeatures includeNonSolids"
    " includeMateConnectors excludeSuppressed",
    "massproperties": f"{_STUDIO} massAsGroup useMassPropertyOverrides",
    "tessellatedfaces": f"{_FACES} outputVertexNormals outputFacetNormals outputTextureCoordinates"
    " outputIndexTable outputErrorFaces combineCompositePartConstituents",
    "gltf": f"{_FACES} outputSeparateFaceNodes",
    "assemblymass": "linkDocumentId configuration",
    "configuration": "linkDocumentId",
    "features": "linkDocumentId configuration explodedViewId featureId",
    "variables": "linkDocumentId configuration includeValuesAndReferencedVariables",
    "currentmicroversion": "",
    "elements": "linkDocumentId elementType elementId withThumbnails withZipContents",
}
QUERIES = {endpoint: frozenset(names.split()) for endpoint, names in _QUERIES.items()}
_HEX = "[0-9a-f]{24}"
_PATTERNS = {
    name: re.compile(
        re.sub(r"\{(did|wvmid|wvid|eid)\}", rf"(?P<\1>{_HEX})", path)
        .replace("{wvm}", "(?P<kind>[wvm])")
        .replace("{wv}", "(?P<kind>[wv])")
        + "$"
    )
    for name, path in PATHS.items()
}


@dataclass(frozen=True)
class Reply:
    """A status and a JSON body; `endpoint` names the kind of request."""

    status: int
    body: bytes
    endpoint: str = ""


class RefusedError(Exception):
    """A request that is answered with an error."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status, self.message = status, message


class Replies:
    """A document as Onshape would serve it. `shuffle`: see `definition`. The same request always has the
    same bytes. `earlier`: those before an edit, which answer for the microversion that they had. `old`:
    lists of features in the old envelope. `newest`: the newest version of the API that is known."""

    def __init__(self, document, *, shuffle=None, newest=NEWEST, old=False, earlier=None):
        self.document, self.earlier, self.old = document, earlier, old
        self.newest, self.shuffle = newest, shuffle

    def answer(self, path, query="", api=NEWEST):
        """The reply to GET /api/v`api``path`?`query`."""
        try:
            endpoint, names = self._endpoint(unquote(path))
            if self.earlier and self._is_before(names):
                return self.earlier.answer(path, query, api)
            pairs = parse_qsl(query, keep_blank_values=True)
            for key, _ in pairs:
                if key not in QUERIES[endpoint]:
                    raise RefusedError(400, f"Unrecognized query parameter: {key}.")
            version = {"api": self.version(api)} if endpoint == "definition" else {}
            value = getattr(self, f"_{endpoint}")(names, pairs, **version)
            if isinstance(value, bytes):
                return Reply(200, value, endpoint)
        except BadSettingError as wrong:
            return Reply(400, error_body(400, str(wrong)))
        except RefusedError as refused:
            return Reply(refused.status, error_body(refused.status, refused.message))
        return Reply(200, json.dumps(value, separators=(",", ":"), ensure_ascii=False).encode(), endpoint)

    def version(self, asked):
        """The version that answers where this one is asked: the newest for one that is not known."""
        return min(asked, self.newest)

    def _endpoint(self, path):
        for name, pattern in _PATTERNS.items():
            match = pattern.match(path)
            if match:
                return name, match.groupdict()
        raise RefusedError(404, "Not found.")

    def _is_before(self, names):
        """Whether a path leads to another microversion of the document than it has now."""
        pinned = (names["did"], names.get("kind")) == (self.document.id, "m")
        return pinned and names["wvmid"] != self.document.microversion

    def _home(self, names, pairs):
        """The document that is asked for, at a state that it has."""
        home = next((home for home in self.document.homes if home.id == names["did"]), None)
        if home is None:
            raise RefusedError(404, f"Document {names['did']} does not exist.")
        state = {"w": home.workspace, "v": home.version, "m": home.microversion}[names["kind"]]
        if state != (names.get("wvmid") or names.get("wvid")):
            raise RefusedError(404, "Document workspace, version or microversion not found.")
        if home.linked and dict(pairs).get("linkDocumentId") != self.document.id:
            raise RefusedError(403, "Access to a linked document needs linkDocumentId.")
        return home

    def element(self, names, query, kind):
        """The `kind` of element that a path leads to; RefusedError where it leads to none."""
        pairs = parse_qsl(query, keep_blank_values=True)
        return self._element(self._home(names, pairs), names, kind)

    def _element(self, home, names, kind):
        all_of_them = [*home.studios, *home.assemblies, *home.variable_studios]
        elements = {element.element: element for element in all_of_them}
        element = elements.get(names["eid"])
        if element is None:
            raise RefusedError(404, f"Element {names['eid']} does not exist.")
        if not isinstance(element, kind):
            wanted = {Assembly: "an assembly", Studio: "a part studio"}.get(kind, "of that kind")
            raise RefusedError(400, f"The element is not {wanted}.")
        return element

    def _definition(self, names, pairs, api):
        home = self._home(names, pairs)
        assembly = self._element(home, names, Assembly)
        if assembly is not self.document.root:
            raise RefusedError(404, "This server serves the definition of the document's root assembly only.")
        configuration = dict(pairs).get("configuration") or "default"
        document = self.document.at(configuration)
        resolved = api >= RESOLVED
        made = definition(document, configuration=configuration, limits=resolved, shuffle=self.shuffle)
        if not _flag(pairs, "includeMateFeatures", False):
            for part in [made["rootAssembly"], *made["subAssemblies"]]:
                part["features"] = []
        if not _flag(pairs, "includeMateConnectors", False):
            for part in made["parts"]:
                part.pop("mateConnectors", None)
        return made

    def _massproperties(self, names, pairs):
        studio, parts = self._studio(names, pairs)
        as_group = _flag(pairs, "massAsGroup", True)
        overrides = _flag(pairs, "useMassPropertyOverrides", False)
        return mass_properties(studio, parts, as_group=as_group, overrides=overrides)

    def _tessellatedfaces(self, names, pairs):
        studio, parts = self._studio(names, pairs)
        return tessellated_faces(
            studio,
            parts,
            appearances=_flag(pairs, "outputFaceAppearances", False),
            facet_normals=_flag(pairs, "outputFacetNormals", True),
            index_table=_flag(pairs, "outputIndexTable", False),
            combine=_flag(pairs, "combineCompositePartConstituents", False),
        )

    def _gltf(self, names, pairs):
        _, parts = self._studio(names, pairs)
        return gltf(parts, appearances=_flag(pairs, "outputFaceAppearances", False))

    def _studio(self, names, pairs):
        studio = self._element(self._home(names, pairs), names, Studio)
        studio = studio.at(dict(pairs).get("configuration") or "default")
        asked = [value for key, value in pairs if key == "partId"]
        parts = {part.id: part for part in studio.parts}
        for part in asked:
            if part not in parts:
                raise RefusedError(400, f"Part {part} does not exist.")
        return studio, [parts[part] for part in asked] if asked else studio.parts

    def _assemblymass(self, names, pairs):
        assembly = self._element(self._home(names, pairs), names, Assembly)
        if assembly is not self.document.root:
            raise RefusedError(404, "This server weighs the document's root assembly only.")
        return assembly_mass(self.document.at(dict(pairs).get("configuration") or "default"))

    def _configuration(self, names, pairs):
        home = self._home(names, pairs)
        element = self._element(home, names, (Studio, Assembly))
        owner = self.document if element is self.document.root else element
        return settings.reply(getattr(owner, "parameters", ()), home.microversion)

    def _features(self, names, pairs):
        return features(self._element(self._home(names, pairs), names, Assembly), old=self.old)

    def _variables(self, names, pairs):
        home = self._home(names, pairs)
        element = self._element(home, names, (Studio, Assembly, VariableStudio))
        every = tables(home, element.element)
        if _flag(pairs, "includeValuesAndReferencedVariables", False):
            return every
        plain = [table for table in every if "variableStudioReference" not in table]
        for record in (record for table in plain for record in table["variables"]):
            record["value"] = ""
        return plain

    def post(self, path, body):
        """The reply to POST /api/vN`path`, and the document as it is then."""
        try:
            endpoint, names = self._endpoint(unquote(path))
            if endpoint != "variables" or names["kind"] != "w":
                raise RefusedError(405, "Method not allowed.")
            studio = self._element(self._home(names, ()), names, VariableStudio)
            rows = json.loads(body)
            table = {row["name"]: (row["type"], row["expression"]) for row in rows}
        except RefusedError as refused:
            return Reply(refused.status, error_body(refused.status, refused.message)), self.document
        return Reply(200, b"{}", "variables"), self.document.with_variables(studio.element, table)

    def _currentmicroversion(self, names, pairs):
        return {"microversion": self._home(names, pairs).microversion}

    def _elements(self, names, pairs):
        home = self._home(names, pairs)
        wanted = dict(pairs)
        kinds = (
            ("PARTSTUDIO", "Part Studio", home.studios),
            ("ASSEMBLY", "Assembly", home.assemblies),
            ("VARIABLESTUDIO", "Variable Studio", home.variable_studios),
        )
        units = {"lengthUnits": "meter", "angleUnits": "degree", "massUnits": "kilogram"}
        listed = [
            {
                "id": element.element,
                "name": element.name,
                "elementType": kind,
                "type": words,
                "dataType": f"onshape/{words.lower().replace(' ', '')}",
                "microversionId": home.tab_microversion(element),
                "deleted": False,
                **units,
            }
            for kind, words, elements in kinds
            for element in elements
        ]
        return [
            record
            for record in listed
            if wanted.get("elementId", record["id"]) == record["id"]
            and wanted.get("elementType", record["elementType"]) == record["elementType"]
        ]


def error_body(status, message):
    """The JSON body of an error."""
    return json.dumps({"message": message, "status": status, "code": 0, "moreInfoUrl": ""}).encode()


def _flag(pairs, name, default):
    text = dict(pairs).get(name)
    if text is None:
        return default
    if text not in ("true", "false"):
        raise RefusedError(400, f"{name} must be true or false.")
    return text == "true"
