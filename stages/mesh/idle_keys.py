"""Keys of the mesh stage that nothing of this robot depends on."""

from collections.abc import Collection, Iterator
from dataclasses import fields
from typing import TYPE_CHECKING

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, Maker
from linkwright.stages.mesh.contact_parts import FILES
from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSections

KEYS = ("tolerance", "fine", "extra_volume", "effort", "coacd")
"""Keys that only some makers of colliders read; of the ladder, with a tolerance or a part that is named."""


def idle_keys(keys: "MeshSections", makers: Collection[Maker], source: str) -> Iterator[Diagnostic]:
    """I-IDLE-KEY for each key that is set and that nothing reads. `makers`: those of all colliders, and of
    those that further parts would have; `source`: the kind of the source."""
    section, default = keys.mesh, type(keys.mesh)()
    for key in ("basis", *KEYS):
        if getattr(section, key) == getattr(default, key):
            continue
        if key in KEYS and not any(_reads(maker, key) for maker in makers):
            readers = [name for name, maker in COLLIDERS.items() if _reads(maker, key)]
            by = " or ".join(readers) or "ladder without a tolerance"
            text = f"no collider is made by {by}, so it changes nothing"
            yield Diagnostic(
                "I-IDLE-KEY", text, f"mesh.{key}", "leave it out, or choose such a maker of colliders"
            )
        if key == "basis" and source not in FILES:
            text = "the source has no collision shapes of its own, so it changes nothing"
            yield Diagnostic("I-IDLE-KEY", text, "mesh.basis", "leave it out: it is for a URDF or an MJCF")
    if keys.contact.exclude and keys.contact.self_ == "none":
        text = "no links of the robot collide with each other (contact.self is none), so it changes nothing"
        yield Diagnostic(
            "I-IDLE-KEY", text, "contact.exclude", "leave it out, or choose another contact.self"
        )


def _reads(maker: Maker, key: str) -> bool:
    return maker is BY_CONTACT if key == "fine" else key in {one.name for one in fields(maker.settings)}
