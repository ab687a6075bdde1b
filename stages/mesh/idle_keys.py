"""Reports keys of the mesh stage that are set, but have no effect on this robot."""

from collections.abc import Collection, Iterator
from dataclasses import fields
from typing import TYPE_CHECKING

from linkwright.stages.mesh import BY_CONTACT, COLLIDERS, Maker
from linkwright.stages.mesh.contact_parts import SHAPE_DECLARING_KINDS
from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSections

MAKER_KEYS = ("tolerance", "fine", "extra_volume", "effort", "coacd")
"""Keys that only some collider makers read. The maker `ladder` reads them only if a tolerance is set, or for
a part that mesh.colliders names."""


def idle_key_reports(
    sections: "MeshSections", makers: Collection[Maker], source: str
) -> Iterator[Diagnostic]:
    """Yields I-IDLE-KEY for each key that is set although nothing reads it. `makers`: the default maker and
    the makers that are chosen for parts; `source`: the kind of source."""
    section, default = sections.mesh, type(sections.mesh)()
    if section.basis != default.basis and source not in SHAPE_DECLARING_KINDS:
        text = "the source has no collision shapes of its own, so this key has no effect"
        yield Diagnostic("I-IDLE-KEY", text, "mesh.basis", "remove it: only a URDF or an MJCF has them")
    for key in MAKER_KEYS:
        is_set = getattr(section, key) != getattr(default, key)
        if is_set and not any(_maker_reads(maker, key) for maker in makers):
            readers = [name for name, maker in COLLIDERS.items() if _maker_reads(maker, key)]
            # `COLLIDERS` does not list BY_CONTACT, the ladder without a tolerance.
            reader_names = " or ".join(readers) or "ladder without a tolerance"
            text = f"no collider is made by {reader_names}, so this key has no effect"
            yield Diagnostic("I-IDLE-KEY", text, f"mesh.{key}", "remove it, or choose such a collider")
    if section.glb_up != default.glb_up and section.format != "glb":
        text = "no mesh is a GLB, so this key has no effect"
        yield Diagnostic("I-IDLE-KEY", text, "mesh.glb_up", "remove it, or choose mesh.format=glb")
    if sections.contact.exclude and sections.contact.self_ == "none":
        text = "no links of the robot collide with each other (contact.self=none), so this key has no effect"
        yield Diagnostic("I-IDLE-KEY", text, "contact.exclude", "remove it, or choose another contact.self")


def _maker_reads(maker: Maker, key: str) -> bool:
    """Tells whether a maker reads a key. `fine` is not a field of its settings: only BY_CONTACT reads it."""
    return maker is BY_CONTACT if key == "fine" else key in {field.name for field in fields(maker.settings)}
