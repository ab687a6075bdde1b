"""What other clients ask of the local Onshape, part by part, as they would read it."""

import json
from http.client import HTTPConnection
from urllib.parse import quote, urlsplit

import numpy as np
import pytest

from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.signing import headers
from tests.benchmarks.many_parts import many_parts
from tests.fake_onshape.server import OnshapeServer


@pytest.fixture(scope="module")
def document():
    return many_parts(parts=8, studios=2, links=4)


@pytest.fixture(scope="module")
def server(document):
    with OnshapeServer(document) as running:
        yield running


def ask(server, target):
    """Status, headers and body of one signed request."""
    connection = HTTPConnection(urlsplit(server.url).netloc)
    key = Credentials(*server.keys, kind="signature")
    connection.request("GET", target, headers=headers(key, "GET", target))
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, response.headers, body


def element(document, studio, kind="m"):
    pin = {"m": document.microversion, "w": document.workspace}[kind]
    return f"d/{document.id}/{kind}/{pin}/e/{studio.element}"


def part_path(document, part):
    return f"/api/parts/{element(document, part.studio)}/partid/{quote(part.id, safe='')}"


def test_an_stl_comes_by_way_of_a_redirect_and_is_the_part_in_metres(server, document):
    part = document.studios[0].parts[1]
    status, headers, _ = ask(server, part_path(document, part) + "/stl?mode=binary&units=meter")
    assert status == 307
    place = urlsplit(headers["Location"])
    assert f"{place.scheme}://{place.netloc}" == server.url
    status, _, body = ask(server, f"{place.path}?{place.query}")
    assert status == 200
    count = int(np.frombuffer(body, "<u4", 1, 80)[0])
    assert len(body) == 84 + 50 * count
    corners = np.frombuffer(body, [("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")], offset=84)["c"]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(part.solid.properties.volume, rel=1e-5)
    assert 500 < count < 700


def test_a_parts_metadata_and_masses_are_those_of_its_studio(server, document):
    part = document.studios[1].parts[0]
    _, _, body = ask(server, f"/api/metadata/{element(document, part.studio)}/p/{quote(part.id, safe='')}")
    values = {entry["name"]: entry["value"] for entry in json.loads(body)["properties"]}
    red, green, blue = part.colour
    assert values["Appearance"]["color"] == {"red": red, "green": green, "blue": blue}
    query = "?useMassPropertyOverrides=True"
    mass = json.loads(ask(server, part_path(document, part) + f"/massproperties{query}")[2])
    studio = f"/api/v16/partstudios/{element(document, part.studio)}/massproperties"
    whole = json.loads(ask(server, studio + "?massAsGroup=false&useMassPropertyOverrides=true")[2])
    assert mass["bodies"] == {part.id: whole["bodies"][part.id]}


def test_features_and_mate_values_are_in_the_old_envelope(server, document):
    path = f"/api/assemblies/{element(document, document.root)}/features"
    features = json.loads(ask(server, path)[2])["features"]
    hinge = next(feature["message"] for feature in features if feature["message"]["name"] == "dof_1")
    parameters = {entry["message"]["parameterId"]: entry["message"] for entry in hinge["parameters"]}
    assert parameters["limitsEnabled"]["value"] is True
    assert parameters["limitAxialZMin"]["expression"] == "-1.5 rad"
    workspace = f"/api/assemblies/{element(document, document.root, 'w')}/matevalues"
    values = json.loads(ask(server, workspace)[2])["mateValues"]
    assert {value["mateName"]: value["rotationZ"] for value in values} == {
        f"dof_{n}": 0.01 for n in (1, 2, 3)
    }
