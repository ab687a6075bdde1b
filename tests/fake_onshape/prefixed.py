"""A document made for onshape-to-robot: a meaning in every name, and no two joints alike."""

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import ORIGIN, Document
from tests.fake_onshape.frames import frame, turn

SIDE = turn((0, 1, 0), np.pi / 2, (0.03, 0.01, 0.02))
LEAN = turn((0.48, 0.6, 0.64), 0.7, (0.02, -0.03, 0.08))

LIKE_THEIRS = {"crank_link": "crank", "rod_link": "rod"}
"""Links that we call otherwise: the tool lets a joint have the name of a link."""


def prefixed():
    """Thirteen instances in ten links: each prefix, both orders of entities, and values other than 0."""
    document = Document("Prefixed")
    studio = document.studio("Parts")

    def part(name, *size, density=900.0):
        return studio.part(name, solids.box(*size) + solids.box(0.01, 0.02, 0.03), density=density)

    gripper = document.assembly("Gripper")
    palm, finger = (gripper.add(part(name, 0.03, 0.02, 0.01)) for name in ("Palm", "Finger"))
    gripper.revolute("dof_inside", (finger, LEAN), (palm, SIDE), value=0.2)

    root = document.assembly("Robot")
    document.root = root
    spare = {"redundant": True}
    names = ("Base", "Cover", "Plate", "Arm", "Forearm", "Sledge", "Wheel", "Camera", "Pin", "Crank", "Rod")
    sizes = np.random.default_rng(4).uniform(0.02, 0.09, (len(names), 3))
    base, cover, plate, arm, fore, sledge, wheel, camera, pin, crank, rod = (
        root.add(part(name, *size), fixed=name == "Base") for name, size in zip(names, sizes, strict=True)
    )
    hand = root.add(gripper)
    wheels = root.add(wheel.last.source)

    root.fasten("Fastened 1", (plate, LEAN), (base, SIDE))
    root.revolute("fix_cover", (base, frame((0, 0, 0.05))), (cover, SIDE), value=0.4)
    root.fasten("Fastened 2", (base, np.eye(4)), (ORIGIN, np.eye(4)), **spare)
    root.revolute("dof_shoulder", (arm, SIDE), (base, LEAN), value=0.3, limits=(-1.0, 1.5))
    root.revolute("Spare hinge", (arm, SIDE), (base, LEAN), value=0.3, **spare)
    root.revolute("dof_elbow_inv", (arm, LEAN), (fore, SIDE), value=-0.4, limits=(-0.5, 2.0))
    root.slider("dof_lift", (base, frame((0.1, 0, 0))), (sledge, LEAN), value=0.02, limits=(-0.01, 0.07))
    root.slider("dof_reach_inverted", (hand / palm, LEAN), (fore, LEAN), value=0.01, limits=(0.0, 0.05))
    root.revolute("dof_left_wheel", (wheel, SIDE), (sledge, SIDE), value=1.0)
    root.revolute("dof_continuous_right", (sledge, LEAN), (wheels, SIDE), value=-1.5)
    root.gear("Gear 1", *(root.features[index] for index in (-2, -1)), ratio=1.5)
    root.fasten("dof_mount", (camera, SIDE), (fore, frame((0, 0, 0.1))))
    root.fasten("frame_tip", (pin, SIDE), (hand / finger, LEAN))
    root.connector("frame_eye", camera, LEAN)
    root.connector("link_forearm_link", fore, SIDE)
    root.connector("Of no meaning", arm, SIDE)

    root.revolute("dof_crank", (crank, np.eye(4)), (base, frame((0, -0.3, 0))), value=0.5, limits=(-2, 2))
    root.revolute("dof_rod", (rod, np.eye(4)), (crank, frame((0.1, 0, 0))), value=0.7)
    on_rod = frame((0.15, 0.02, 0)) @ turn((0, 0, 1), 0.3)
    on_base = document.truth.frame_on(base, document.truth.poses()[rod.path] @ on_rod)
    root.revolute("closing_rod", (rod, on_rod), (base, on_base), closing=True)
    return document
