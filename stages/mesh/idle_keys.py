"""Keys of the mesh stage that nothing of this robot depends on."""

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING

from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSections

BY_CONTACT = "ladder without a tolerance"
"""The maker of colliders by contact, as it is called here."""

USED_BY: Mapping[str, Collection[str]] = {
    "tolerance": ("ladder", "coacd", "spheres"),
    "fine": (BY_CONTACT,),
    "extra_volume": ("ladder",),
    "effort": ("ladder", "coacd"),
    "coacd": ("coacd",),
}
"""Key → the makers of colliders that read it; of the ladder, with a tolerance or a part that is named."""

FILES = ("urdf", "mjcf")
"""Kinds of source that may have collision shapes of their own."""


def idle_keys(keys: "MeshSections", makers: Collection[str], source: str) -> Iterator[Diagnostic]:
    """I-IDLE-KEY for each key that is set and that nothing reads. `makers`: those of all colliders, and of
    those that further parts would have; `source`: the kind of the source."""
    section, default = keys.mesh, type(keys.mesh)()
    for key in ("basis", *USED_BY):
        if getattr(section, key) == getattr(default, key):
            continue
        if key in USED_BY and not set(makers) & set(USED_BY[key]):
            text = f"no collider is made by {' or '.join(USED_BY[key])}, so it changes nothing"
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
