"""Changes a URDF for MuJoCo, which does not resolve `package://` and accepts floating joints only on the
world."""

from collections.abc import Callable

from linkwright.stages.formats.xml import Element, element


def remove_package_prefixes(root: Element) -> None:
    """Makes the paths `package://<package>/...` relative to the package. The URDF must be at the top of its
    package, whose name MuJoCo would take for a folder."""
    for node in root.xpath("//*[starts-with(@filename, 'package://')]"):
        node.set("filename", node.get("filename").removeprefix("package://").partition("/")[2])


def move_floating_joints_to_world(root: Element) -> bool:
    """Adds a link `world` above the root, and makes it the parent of the floating joints, as MuJoCo requires.
    The robot stays the same, since its root is fixed. Returns whether a joint was moved."""
    floating_parents = root.xpath("joint[@type='floating']/parent[@link != 'world']")
    if not floating_parents:
        return False
    world_joint = element(root, "joint", name="world_fixed", type="fixed")
    element(world_joint, "parent", link="world")
    # The parent of the first floating joint is taken for the root.
    element(world_joint, "child", link=floating_parents[0].get("link"))
    element(root, "link", name="world")
    for parent in floating_parents:
        parent.set("link", "world")
    return True


def prepare_for_inspection(
    root: Element, path_of: Callable[[str], str | None], *, visuals: bool = True
) -> None:
    """Makes MuJoCo keep all links, and makes floating joints fixed: in URDFs of other tools they may be below
    any link, which MuJoCo refuses.

    `path_of`: returns the path of a mesh for its name in the URDF, or None to leave out the shape; `visuals`:
    whether visual shapes are kept.
    """
    if not visuals:
        for visual in list(root.iterfind("link/visual")):
            visual.getparent().remove(visual)
    _set_mesh_paths(root, path_of)
    _set_compiler(root, visuals=visuals)
    for joint in root.iterfind("joint[@type='floating']"):
        joint.set("type", "fixed")


def _set_mesh_paths(root: Element, path_of: Callable[[str], str | None]) -> None:
    """Sets the path of each mesh, and removes the shapes whose mesh has no path."""
    for mesh in list(root.iter("mesh")):
        path = path_of(mesh.get("filename", ""))
        if path is None:
            _remove_shape(mesh)
        else:
            mesh.set("filename", path)


def _set_compiler(root: Element, *, visuals: bool) -> None:
    """Replaces the URDF's settings of MuJoCo's compiler by our own."""
    for own_settings in root.findall("mujoco"):
        root.remove(own_settings)
    settings = element(root, "mujoco")
    # None leaves MuJoCo's default, which discards visuals.
    discarded = "false" if visuals else None
    element(settings, "compiler", strippath="false", fusestatic="false", discardvisual=discarded)


def _remove_shape(mesh: Element) -> None:
    """Removes the visual or collision that holds a mesh."""
    shape = mesh.getparent().getparent()
    if shape is not None and shape.getparent() is not None:
        shape.getparent().remove(shape)
