"""What the tests of the local Onshape's replies share: a document with everything, and how to ask."""

import json
from urllib.parse import urlencode

from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame
from tests.fake_onshape.replies import PATHS, Replies
from tests.fake_onshape.sample import sample_document


def extended_sample():
    """The sample with what it lacks: a group, part connectors, overrides, no material, suppression."""
    made = sample_document()
    studio = made.studio("Extras")
    plain = studio.part("Plain", solids.box(0.1, 0.2, 0.3), density=None)
    heavy = studio.part("Heavy", solids.box(0.1, 0.1, 0.1), density=1000, mass=5.0)
    heavy.connector("Eye", frame((0, 0, 0.05)))
    plain_path = made.root.add(plain, pose=frame((1, 0, 0)), hidden=True)
    heavy_path = made.root.add(heavy)
    made.root.add(heavy, suppressed=True)
    made.root.group("Together", [(plain_path, frame()), (heavy_path, frame((0, 0, 1)))])
    return made


def ask(document, endpoint, element, **query):
    path = PATHS[endpoint].format(
        did=document.id, wvm="m", wvmid=document.microversion, wv="w", wvid=document.workspace, eid=element
    )
    reply = Replies(document).answer(path, urlencode(query, doseq=True))
    assert reply.status == 200, reply.body
    return json.loads(reply.body)


def studio(document, name):
    return next(studio for studio in document.studios if studio.name == name)
