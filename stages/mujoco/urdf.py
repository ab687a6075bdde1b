"""A URDF as MuJoCo reads URDFs: its meshes by paths, and no floating joint but below the world."""

from collections.abc import Callable

from linkwright.stages.formats.xml import Element, element


def without_packages(root: Element) -> None:
    """Makes the paths `package://<package>/...` relative: a URDF lies at the top of its package, whose name
    MuJoCo takes for a folder."""
    for node in root.xpath("//*[starts-with(@filename, 'package://')]"):
        node.set("filename", node.get("filename").removeprefix("package://").partition("/")[2])


def with_floating_on_world(root: Element) -> bool:
    """Puts a link `world` above the root, and moves the floating joints to it: the same, since the root does
    not move, and MuJoCo accepts them only there. Whether there were any elsewhere."""
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
    """Keeps what MuJoCo would leave out, and fixes joints that float, which may be below any link of a URDF
    that is not ours. `place_of`: the path of a mesh by what the URDF names, None for one that is left out;
    `visuals`: whether what is only seen stays."""
    for seen in [] if visuals else list(root.iterfind("link/visual")):
        seen.getparent().remove(seen)
    for mesh in list(root.iter("mesh")):
        place = place_of(mesh.get("filename", ""))
        if place is None:
            _drop(mesh)
        else:
            mesh.set("filename", place)
    for settings in root.findall("mujoco"):
        root.remove(settings)
    own = element(root, "mujoco")
    discarded = "false" if visuals else None
    element(own, "compiler", strippath="false", fusestatic="false", discardvisual=discarded)
    for joint in root.iterfind("joint[@type='floating']"):
        joint.set("type", "fixed")


def _drop(mesh: Element) -> None:
    """Takes out the visual or collision of a mesh."""
    around = mesh.getparent().getparent()
    if around is not None and around.getparent() is not None:
        around.getparent().remove(around)
