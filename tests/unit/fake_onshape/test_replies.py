"""What the local Onshape's replies say: volumes, masses, colours, order, ids, bundles."""

import base64
import json

import numpy as np
import pytest

from tests.fake_onshape.bundle import bundle_bytes, requests
from tests.fake_onshape.document import Document
from tests.fake_onshape.extended_sample import ask, extended_sample, studio
from tests.fake_onshape.replies import PATHS, Replies
from tests.fake_onshape.sample import sample_document


@pytest.fixture(scope="module")
def document():
    return extended_sample()


def test_triangles_enclose_the_volume_that_mass_properties_state(document):
    for home in document.studios:
        masses = ask(document, "massproperties", home.element, massAsGroup="false")["bodies"]
        indexed = ask(document, "tessellatedfaces", home.element, outputIndexTable="true")["bodies"]
        soup = ask(document, "tessellatedfaces", home.element)["bodies"]
        for one, two in zip(indexed, soup, strict=True):
            points = np.array([[p[k] for k in "xyz"] for p in one["facetPoints"]])
            faces = [points[f["indices"]] for face in one["faces"] for f in face["facets"]]
            again = [
                [[v[k] for k in "xyz"] for v in f["vertices"]]
                for face in two["faces"]
                for f in face["facets"]
            ]
            assert np.array_equal(faces, again)
            volume = sum(np.dot(a, np.cross(b, c)) for a, b, c in faces) / 6
            assert volume == pytest.approx(masses[one["id"]]["volume"][0], rel=1e-9)


def test_a_part_without_material_has_volume_but_neither_mass_nor_centroid(document):
    bodies = ask(document, "massproperties", studio(document, "Extras").element, massAsGroup="false")[
        "bodies"
    ]
    plain = bodies[studio(document, "Extras").parts[0].id]
    assert (plain["hasMass"], plain["massMissingCount"], plain["mass"][0]) == (False, 1, 0.0)
    assert plain["centroid"][:3] == [0, 0, 0]
    assert plain["volume"][0] == pytest.approx(0.006)


def test_an_override_counts_only_when_it_is_asked_for(document):
    element, heavy = studio(document, "Extras").element, studio(document, "Extras").parts[1].id
    for asked, mass in (("true", 5.0), ("false", 1.0)):
        query = {"massAsGroup": "false", "useMassPropertyOverrides": asked}
        body = ask(document, "massproperties", element, **query)["bodies"][heavy]
        assert body["mass"][0] == pytest.approx(mass)
        assert body["inertia"][0] == pytest.approx(mass * 0.01 / 6)


def test_all_parts_as_a_group_weigh_what_they_weigh_one_by_one(document):
    element = studio(document, "Arm").element
    one_by_one = ask(document, "massproperties", element, massAsGroup="false")["bodies"].values()
    group = ask(document, "massproperties", element)["bodies"]
    assert list(group) == ["-all-"]
    mass = sum(body["mass"][0] for body in one_by_one)
    assert group["-all-"]["mass"][0] == pytest.approx(mass, rel=1e-12)
    first = sum(body["mass"][0] * np.array(body["centroid"][:3]) for body in one_by_one)
    assert group["-all-"]["centroid"][:3] == pytest.approx(first / mass, abs=1e-12)


def test_principal_axes_are_rows_that_make_the_inertia_diagonal(document):
    bodies = ask(document, "massproperties", studio(document, "Arm").element, massAsGroup="false")["bodies"]
    for body in bodies.values():
        A = np.array([[axis[k] for k in "xyz"] for axis in body["principalAxes"]])
        inertia = np.reshape(body["inertia"][:9], (3, 3))
        assert A @ inertia @ A.T == pytest.approx(np.diag(body["principalInertia"]), abs=1e-12)


def test_only_the_parts_asked_for_come_and_colours_only_on_request(document):
    arm = studio(document, "Arm")
    wanted = [arm.parts[2].id, arm.parts[0].id]
    bodies = ask(document, "tessellatedfaces", arm.element, partId=wanted)["bodies"]
    assert [body["id"] for body in bodies] == wanted
    assert "appearance" not in bodies[0]
    assert "appearance" not in bodies[0]["faces"][0]
    for form, decode in (("base64", base64.b64decode), ("list", bytes)):
        query = {"partId": wanted, "outputFaceAppearances": "true", "colours": form}
        body = ask(document, "tessellatedfaces", arm.element, **query)["bodies"][0]
        assert tuple(decode(body["appearance"]["color"])) == arm.parts[2].colour
        assert body["appearance"]["opacity"] == 255


def test_shuffling_changes_the_order_and_nothing_else(document):
    element = document.root.element
    path = PATHS["definition"].format(did=document.id, wvm="w", wvmid=document.workspace, eid=element)

    def sorted_deeply(value):
        if isinstance(value, dict):
            return {key: sorted_deeply(inner) for key, inner in value.items()}
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return sorted((sorted_deeply(inner) for inner in value), key=json.dumps)
        return value

    plain, shuffled = (
        json.loads(Replies(document, shuffle=seed).answer(path, "includeMateFeatures=true").body)
        for seed in (None, 7)
    )

    def entities(made):
        return {f["id"]: f["featureData"].get("matedEntities") for f in made["rootAssembly"]["features"]}

    assert plain != shuffled
    assert sorted_deeply(plain) == sorted_deeply(shuffled)
    assert entities(plain) == entities(shuffled)


def test_occurrences_stand_where_the_document_says_and_suppressed_ones_are_left_out(document):
    made = ask(document, "definition", document.root.element)
    poses = document.truth.poses()
    found = {tuple(o["path"]): o["transform"] for o in made["rootAssembly"]["occurrences"]}
    assert set(found) == set(poses)
    for path, transform in found.items():
        assert np.array_equal(np.reshape(transform, (4, 4)), poses[path])
    suppressed = [i for i in made["rootAssembly"]["instances"] if i["suppressed"]]
    assert len(suppressed) == 1
    assert (suppressed[0]["id"],) not in found


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


def test_a_bundle_asks_for_the_definition_and_twice_for_each_studio_in_use(document):
    definition, studios = requests(document)
    assert "/m/" in definition
    assert len(studios) == 2 * 5
    linked = [request for request in studios if "/v/" in request]
    assert len(linked) == 2
    assert all(f"linkDocumentId={document.id}" in request for request in linked)
    assert any("angleTolerance=0.2&chordTolerance=0.0005&configuration=default" in r for r in studios)


def test_a_bundle_of_an_unknown_state_is_never_made():
    document = Document("Empty")
    document.assembly("Nothing")
    assert len(bundle_bytes(document)) > 0
    document.microversion = "not hex"
    with pytest.raises(ValueError, match="404"):
        bundle_bytes(document)
