"""Prepares a URDF for MuJoCo, which reads meshes by their paths, and floating joints only below the world."""

from collections.abc import Callable

from linkwright.stages.formats.xml import Element, element


def without_packages(root: Element) -> None:
    """Makes the paths `package://<package>/...` relative. A URDF is at the top of its package, whose name
    MuJoCo would treat as a folder."""
    for node in root.xpath("//*[starts-with(@filename, 'package://')]"):
        node.set("filename", node.get("filename").removeprefix("package://").partition("/")[2])


def with_floating_on_world(root: Element) -> bool:
    """Puts a link `world` above the root, and moves the floating joints to it, where MuJoCo accepts them. The
    robot stays the same, since the root is at rest. Returns whether there was a floating joint elsewhere."""
    floating = root.xpath("joint[@type='floating']/parent[@link != 'world']")
    if not floating:
        return False
    holder = element(root, "joint", name="world_fixed", type="fixed")
    element(holder, "parent", link="world")
    element(holder, "child", link=floating[0].get("link"))
    element(root, "link", name="world")
    for parent in floating:
        parent.set("link", "world")
    return True


def with_every_link(root: Element, place_of: Callable[[str], str | None], *, visuals: bool = True) -> None:
    """Keeps the links that MuJoCo would drop, and fixes floating joints, which URDFs of other tools may have
    below any link. `place_of`: returns the path of a mesh by its name in the URDF, None to drop the mesh;
    `visuals`: whether purely visual shapes stay."""
    for visual in [] if visuals else list(root.iterfind("link/visual")):
        visual.getparent().remove(visual)
    for mesh in list(root.iter("mesh")):
        place = place_of(mesh.get("filename", ""))
        if place is None:
            _drop(mesh)
        else:
            mesh.set("filename", place)
    for existing in root.findall("mujoco"):
        root.remove(existing)
    settings = element(root, "mujoco")
    discarded = "false" if visuals else None
    element(settings, "compiler", strippath="false", fusestatic="false", discardvisual=discarded)
    for joint in root.iterfind("joint[@type='floating']"):
        joint.set("type", "fixed")


def _drop(mesh: Element) -> None:
    """Removes the visual or collision that holds a mesh."""
    holder = mesh.getparent().getparent()
    if holder is not None and holder.getparent() is not None:
        holder.getparent().remove(holder)
