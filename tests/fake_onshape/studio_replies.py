"""What Onshape says about a part studio: mass properties and tessellated faces."""

import base64

import numpy as np

from tests.fake_onshape import ids
from tests.fake_onshape.elements import together


def mass_properties(studio, parts, *, as_group, overrides):
    """The bulk reply: bodies by part id, or all together as "-all-"."""
    if as_group:
        return {"microversionId": studio.home.microversion, "bodies": {"-all-": _merged(parts, overrides)}}
    bodies = {part.id: _body_mass([part], *part.inertial(overrides), overrides) for part in parts}
    return {"microversionId": studio.home.microversion, "bodies": bodies}


def assembly_mass(document):
    """The whole assembly's figures, flat; what has no mass is silently left out of them."""
    truth = document.truth
    used = [truth.places[path].instance.source for path in truth.leaves]
    whole = truth.inertial([path for path, part in zip(truth.leaves, used, strict=True) if part.has_mass])
    weighed = [part for part in used if part.has_mass] or used
    return _body_mass(weighed, whole.mass, whole.com, whole.inertia, overrides=True)


def _merged(parts, overrides):
    return _body_mass(parts, *together([part.inertial(overrides) for part in parts]), overrides)


def _body_mass(parts, mass, com, inertia, overrides):
    missing = sum(not (part.has_mass if overrides else part.density is not None) for part in parts)
    volume = sum(part.volume for part in parts)
    area = sum(part.solid.properties.area for part in parts)
    moments, axes = np.linalg.eigh(inertia)
    largest = np.take_along_axis(axes, np.abs(axes).argmax(0)[None], 0)[0]
    axes = axes.T * np.where(largest < 0, -1.0, 1.0)[:, None]
    return {
        "mass": _ranged([mass]),
        "volume": _ranged([volume]),
        "periphery": _ranged([area]),
        "centroid": _ranged(com, 1e-6),
        "inertia": _ranged(inertia.ravel()),
        "hasMass": missing < len(parts),
        "massMissingCount": missing,
        "principalInertia": [float(moment) for moment in moments],
        "principalAxes": [{"btType": "BTVector3d-389", **_point(axis)} for axis in axes],
    }


def _ranged(values, width=1e-8):
    """Onshape gives each figure three times: nominal, least, most."""
    values = np.asarray(values, float)
    return [float(value) for value in np.concatenate([values, values - width, values + width])]


def tessellated_faces(studio, parts, *, appearances, facet_normals, index_table, combine=False):
    """The triangles of each body, as the v12 object.

    With `index_table` each body has `facetPoints` and facets have `indices`; points are repeated
    where faces meet, as faces are tessellated one by one. Else facets have `vertices`.
    """
    bodies = []
    for part in parts:
        taken, faces, points = set(), [], []
        # A composite part is told by its constituents, which have faces of their own.
        for face in () if part.members and not combine else part.solid.faces:
            face_id = ids.deterministic_id(taken, studio.element, part.id, face.name)
            record = {"btType": "BTExportTessellatedFacesFace-1192", "id": face_id}
            taken.add(face_id)
            if appearances:
                record["appearance"] = _appearance(part.face_colours.get(face.name, part.colour))
            used = np.unique(face.triangles)
            corners = part.solid.vertices[face.triangles]
            if index_table:
                local = np.searchsorted(used, face.triangles) + len(points)
                record["facets"] = [{"indices": [int(i) for i in triangle]} for triangle in local]
                points.extend(_point(vertex) for vertex in part.solid.vertices[used])
            else:
                record["facets"] = [{"vertices": [_point(v) for v in triangle]} for triangle in corners]
            for facet, triangle in zip(record["facets"], corners, strict=True) if facet_normals else ():
                normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
                facet["normal"] = _point(normal / (np.linalg.norm(normal) or 1.0))
            faces.append(record)
        body = {
            "btType": "BTExportTessellatedFacesBody-1321",
            "id": part.id,
            "name": part.name,
            "bodyType": part.body.upper(),
            "constituents": [member.id for member in part.members],
            "faces": faces,
            "facetPoints": points,
        }
        if appearances:
            body["appearance"] = _appearance(part.colour)
        bodies.append(body)
    return {
        "btType": "BTExportTessellatedFacesResponse-898",
        "documentId": studio.home.id,
        "elementId": studio.element,
        "facetPoints": [],
        "bodiesInfo": None,
        "bodies": bodies,
    }


def _appearance(colour):
    packed, opacity = base64.b64encode(bytes(colour[:3])).decode(), int(colour[3]) if len(colour) > 3 else 255
    return {"btType": "BTGraphicsAppearance-1152", "color": packed, "opacity": opacity}


def _point(vector):
    return {"x": float(vector[0]), "y": float(vector[1]), "z": float(vector[2])}
