"""What the local Onshape's replies say: volumes, masses, colours, order, ids, bundles."""

import numpy as np
import pytest

from tests.fake_onshape.extended_sample import ask, extended_sample, studio
from tests.fake_onshape.sample import sample_document


@pytest.fixture(scope="module")
def document():
    return extended_sample()


def test_triangles_enclose_the_volume_that_mass_properties_state(document):
    for home in (studio(document, "Base"), studio(document, "Extras")):
        masses = ask(document, "massproperties", home.element, massAsGroup="false")["bodies"]
        indexed = ask(document, "tessellatedfaces", home.element, outputIndexTable="true")["bodies"]
        soup = ask(document, "tessellatedfaces", home.element)["bodies"]
        for first, second in zip(indexed, soup, strict=True):
            points = np.array([[p[k] for k in "xyz"] for p in first["facetPoints"]])
            faces = [points[f["indices"]] for face in first["faces"] for f in face["facets"]]
            again = [
                [[v[k] for k in "xyz"] for v in f["vertices"]]
                for face in second["faces"]
                for f in face["facets"]
            ]
            assert np.array_equal(faces, again)
            volume = sum(np.dot(a, np.cross(b, c)) for a, b, c in faces) / 6
            assert volume == pytest.approx(masses[first["id"]]["volume"][0], rel=1e-9)


def test_an_override_counts_only_when_it_is_asked_for(document):
    element, heavy = studio(document, "Extras").element, studio(document, "Extras").parts[1].id
    for asked, mass in (("true", 5.0), ("false", 1.0)):
        query = {"massAsGroup": "false", "useMassPropertyOverrides": asked}
        body = ask(document, "massproperties", element, **query)["bodies"][heavy]
        assert body["mass"][0] == pytest.approx(mass)
        assert body["inertia"][0] == pytest.approx(mass * 0.01 / 6)


def test_ids_are_onshapes_own_length_and_some_hold_a_slash_or_a_plus():
    document = sample_document()
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
