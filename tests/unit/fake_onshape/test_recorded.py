"""What the local Onshape sends that no recording shows: exactly what its README lists."""

import json
import re
from pathlib import Path

from tests import fake_onshape
from tests.fake_onshape.bundle import requests
from tests.fake_onshape.extended_sample import ask, extended_sample, studio
from tests.fake_onshape.frames import frame
from tests.fake_onshape.replies import PATHS
from tests.support.kit import OFF, ON, Kit
from tests.support.recorded import DATA, KBOT, needs_data

pytestmark = needs_data

README = Path(fake_onshape.__file__).with_name("README.md")
ROW = re.compile(r"^\| `(\w+)` \| `(.+?)` \| (.+?) \|$")
BY_ID = ("bodies", "featureStates", "seedToPatternInstances")
"""Maps whose keys are ids, and no fields."""
TOLD_APART = {"features": "featureType", "instances": "type"}
VALUES = ("mateType", "relationType", "bodyType")
WHOLE = "(all of it)"


def fields(value, path=""):
    """(path, type) of every field of a reply; the kinds of records are told apart, and some values."""
    last = path.rpartition(".")[2]
    if isinstance(value, list):
        for item in value:
            kind = item.get(TOLD_APART[last], "") if last in TOLD_APART and isinstance(item, dict) else ""
            yield f"{path}[{kind}]", ""
            yield from fields(item, f"{path}[{kind}]")
    elif isinstance(value, dict):
        for key, inner in value.items():
            here = f"{path}{{}}" if last in BY_ID else f"{path}.{key}".lstrip(".")
            yield here, type(inner).__name__
            if key in VALUES:
                yield f"{here} = {inner}", ""
            yield from fields(inner, here)


def opened(value):
    """A list of features without the old envelope; there states are a list, and now a map."""
    if isinstance(value, dict):
        inside = value.get("message")
        return opened(inside) if isinstance(inside, dict) else {k: opened(v) for k, v in value.items()}
    return [opened(item) for item in value] if isinstance(value, list) else value


def alike(replies):
    """The fields of replies; the root and the sub-assemblies have the same."""
    pairs = {pair for reply in replies for pair in fields(reply)}
    return {(re.sub(r"^(rootAssembly|subAssemblies\[\])", "assembly", path), kind) for path, kind in pairs}


def unseen(ours, recorded):
    """The fields that no recording has, without those inside them."""
    more = ours - recorded
    return {path for path in more if not any(path != other and inside(path, other) for other in more)}


def inside(first, other):
    return first.startswith((f"{other}.", f"{other}[", f"{other}{{", f"{other} = "))


def drawn():
    """A document with every type of mate and of relation, with all limits, patterns and a mirror."""
    kit = Kit()
    base, *arms = (kit.place(f"Bar {n}") for n in range(9))
    root, both = kit.root, (-0.5, 0.5)
    first = root.revolute("R", (arms[0], ON), (base, ON), limits=both)
    second = root.revolute("R2", (arms[1], ON), (base, OFF), limits=both)
    lift = root.slider("S", (arms[2], ON), (base, ON), limits=both)
    push = root.slider("S2", (arms[3], ON), (base, OFF), limits=both)
    turned = root.cylindrical("C", (arms[4], ON), (base, ON), limits=(both, both))
    root.pin_slot("P", (arms[5], ON), (base, ON), limits=(both, both))
    root.planar("F", (arms[6], ON), (base, ON), limits=(both, both, both))
    root.parallel("Q", (arms[7], ON), (base, ON), limits=(both, both, both, both))
    root.ball("B", (kit.place("Ball"), ON), (base, ON), limits=0.7)
    root.gear("Gears", first, second, 1.5)
    root.linear("Line", lift, push, 1.5)
    root.screw("Screw", turned, 0.01)
    root.rack("Rack", second, push, 0.01)
    root.pattern("Row", [arms[0]], [frame((0, 0.3, 0))], "LINEAR")
    root.mirror("Mirror", [arms[2]], frame((0, 0, 1)))
    return kit.document


def test_the_readme_lists_all_that_no_recording_shows():
    rows = {(endpoint, WHOLE) for endpoint in PATHS if endpoint not in recorded()}
    for endpoint, files in recorded().items():
        theirs = alike(opened(json.loads(file.read_text())) for file in files)
        ours = alike(sent(endpoint))
        rows |= {
            (endpoint, path) for path in unseen({path for path, _ in ours}, {path for path, _ in theirs})
        }
        if endpoint != "features":  # of features the recordings have much that nobody reads
            assert {path for path, _ in theirs - ours if not path.endswith("occurrence[]")} == set()
    assert listed() == sorted(rows)


def recorded():
    """The recordings of each reply."""
    return {
        "definition": [next(KBOT.glob("assembly_*_default.json")), DATA / "kscale_dummy_assembly.json"],
        "features": [*KBOT.glob("features_*.json"), DATA / "kscale_dummy_features.json"],
        "massproperties": [
            DATA / "star_partstudio_massproperties_subset.json",
            *KBOT.glob("part_*_mass_properties.json"),
        ],
        "tessellatedfaces": [DATA / "star_tessellatedfaces_subset.json"],
    }


def sent(endpoint):
    """Replies of the local Onshape that together have all fields of their kind."""
    made, more = extended_sample(), drawn()
    if endpoint == "definition":
        asked = {"includeMateFeatures": "true", "includeMateConnectors": "true"}
        return [ask(document, endpoint, document.root.element, **asked) for document in (made, more)]
    if endpoint == "features":
        return [ask(document, endpoint, document.root.element) for document in (made, more)]
    if endpoint == "massproperties":
        of = studio(made, "Extras").element
        return [ask(made, endpoint, of, massAsGroup=flag) for flag in ("true", "false")]
    base = studio(made, "Base").element
    return [
        ask(made, endpoint, base, **query) for query in ({"outputFacetNormals": "false"}, *triangles(made))
    ]


def triangles(document):
    """The ways in which builds ask for triangles, as queries."""
    asked = [request for request in requests(document)[1] if "/tessellatedfaces?" in request]
    return [dict(pair.split("=") for pair in asked[0].partition("?")[2].split("&"))]


def listed():
    """The rows of the README: the reply and the field."""
    lines = README.read_text().splitlines()
    return [(match[1], match[2]) for line in lines if (match := ROW.match(line))]
