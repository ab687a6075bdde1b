"""The points that the compiled model shows."""

import re

import mujoco
import numpy as np
from lxml import etree

from linkwright.stages.mujoco.warnings import collected_warnings
from tests.support.checklist import names, roles

HULL = 64
PIECES = 16
RATIO = 1000.0
CLOSED = 1e-6

HINGE, SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)


def compiles(built):
    """1: from any folder, without a warning."""
    for path in (built.path, built.folder / "scene.xml"):
        with collected_warnings() as heard:
            mujoco.MjModel.from_xml_path(str(path.resolve()))
        yield from (f"{path.name}: {warning}" for warning in heard)


def roles_of_geoms(built):
    """5: what is seen touches nothing, what collides is not seen."""
    model = built.model
    seen, solid = roles(model)
    if len(seen) + len(solid) != model.ngeom:
        yield "geoms that are neither seen nor collide"
    if model.geom_contype[seen].any() or model.geom_conaffinity[seen].any():
        yield "geoms that are seen collide"
    if not (model.geom_contype[solid] & 1 | model.geom_conaffinity[solid] & 1).all():
        yield "a collider does not meet the ground"


def colliders(built):
    """6: each body that is seen collides, or the build says that it does not; an MJCF's as it has them."""
    if built.as_its_file:
        return
    model = built.model
    seen, solid = roles(model)
    bare = set(model.geom_bodyid[seen].tolist()) - set(model.geom_bodyid[solid].tolist())
    for name in (model.body(index).name for index in sorted(bare)):
        if name not in built.messages:
            yield f"{name} has no collider, and nobody says so"


def inertias(built):
    """8 and 11: bodies that can exist, none too light for the one it hangs on."""
    model = built.model
    for index in range(1, model.nbody):
        a, b, c = np.sort(model.body_inertia[index])
        name, mass = model.body(index).name, model.body_mass[index]
        if a <= 0 or a + b < c * (1 - 1e-9):
            yield f"{name}: inertia {a}, {b}, {c}"
        above = model.body_parentid[index]
        if built.cad and above and model.body_mass[above] > RATIO * mass and name not in built.messages:
            yield f"{name} weighs {mass}, what it hangs on {model.body_mass[above]}"


def total_mass(built):
    """10: the mass is that of the source."""
    mass = float(built.model.body_mass.sum())
    if built.mass is not None and abs(mass - built.mass) > 1e-9 * built.mass:
        yield f"{mass} kg, not {built.mass}"


def every_body_moves(built):
    """12 and 13: no body without a joint but the root; each link and frame is a body or a site."""
    model = built.model
    for index in range(1, model.nbody):
        if not model.body_jntnum[index] and model.body_parentid[index]:
            yield f"{model.body(index).name} does not move"
    there = {*names(model, "body", model.nbody), *names(model, "site", model.nsite)}
    wanted = [link["name"] for link in built.robot["links"] + built.robot["frames"]]
    yield from (f"{name} is lost" for name in wanted if name not in there)


def limits(built):
    """14: each joint has the limits of its source, and `home` is within."""
    model = built.model
    for index in range(model.njnt):
        name, kind = model.joint(index).name, model.jnt_type[index]
        if kind not in (HINGE, SLIDE) or name not in built.dofs:
            continue
        low, high = model.jnt_range[index]
        said = built.dofs[name]["limits"]
        if bool(model.jnt_limited[index]) != any(side is not None for side in said):
            yield f"{name}: limited or not, its source says {said}"
        value = model.key("home").qpos[model.jnt_qposadr[index]]
        if model.jnt_limited[index] and not low - 1e-9 <= value <= high + 1e-9:
            yield f"{name}: {value} at home, range {low} to {high}"


def named(built):
    """17: all that a user refers to has a name, in letters that all formats take."""
    model = built.model
    counts = {"body": model.nbody, "joint": model.njnt, "actuator": model.nu, "site": model.nsite}
    counts |= {"sensor": model.nsensor, "eq": model.neq}
    for kind, count in counts.items():
        for name in names(model, kind, count):
            if not re.fullmatch(r"[A-Za-z0-9_]+", name):
                yield f"{kind} {name!r}"
    _, solid = roles(model)
    if not all(model.geom(int(index)).name for index in solid):
        yield "a collider has no name"
    both = set(names(model, "body", model.nbody)) & set(names(model, "joint", model.njnt))
    if both:
        yield f"links and joints of one name: {both}"


def keyframe(built):
    """19: `home` is a pose, with controls."""
    key, model = built.scene.key("home"), built.scene
    if len(key.qpos) != model.nq or len(key.ctrl) != model.nu:
        yield f"sizes {len(key.qpos)}, {len(key.ctrl)}"
    for index in range(model.njnt):
        if model.jnt_type[index] in (int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)):
            end = model.jnt_qposadr[index] + (7 if model.jnt_type[index] == 0 else 4)
            if abs(np.linalg.norm(key.qpos[end - 4 : end]) - 1) > 1e-9:
                yield f"{model.joint(index).name}: a quaternion that is none"


def pieces(built):
    """23 and 24: few pieces and vertices, with the errors of each collider."""
    model = built.model
    _, solid = roles(model)
    meshes = [model.geom_dataid[index] for index in solid if model.geom_dataid[index] >= 0]
    if max((model.mesh_vertnum[mesh] for mesh in meshes), default=0) > HULL:
        yield "a hull of many vertices"
    for row in built.report["details"]["colliders"]:
        if row["pieces"] > PIECES * len(row["parts"]):
            yield f"{row['parts']}: {row['pieces']} pieces"
        if row["rung"] != "none" and row["maker"] == "ladder" and row["miss"] is None and not row["reason"]:
            yield f"{row['parts']}: nobody knows how near its collider is"


def option(built):
    """27: the file says how it is to be simulated; an MJCF as before."""
    said = built.xml.find("option").attrib
    if (said.get("integrator") != "implicitfast" and not built.as_its_file) or "timestep" not in said:
        yield str(dict(said))


def placement(built):
    """28: a free base has a joint with a name, and stands on the ground; a fixed one has none."""
    model = built.scene
    free = [index for index in range(model.njnt) if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_FREE]
    if bool(free) == built.robot["base"]["fixed"]:
        yield "the base floats, or is fixed, and the source says otherwise"
    if not free:
        return
    data, floor = built.at_home(), model.geom("floor").id
    solid = [int(index) for index in roles(model)[1]]
    lowest = min(mujoco.mj_geomDistance(model, data, floor, geom, 1.0, None) for geom in solid)
    if not -1e-6 <= lowest <= 2e-3:
        yield f"the lowest collider is {lowest} m above the ground"


def equalities(built):
    """30: loops and relations hold in the first pose and at `home`."""
    model = built.model
    data = mujoco.MjData(model)
    for pose in (model.qpos0, model.key("home").qpos):
        data.qpos[:] = pose
        mujoco.mj_fwdPosition(model, data)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        off = np.abs(data.efc_pos[rows]).max(initial=0.0)
        if off > CLOSED:
            yield f"an equality is {off} off"


def both_formats(built):
    """32: MuJoCo reads the URDF as the same robot."""
    path = built.folder / f"{built.robot['name']}.urdf"
    root = etree.parse(str(path)).getroot()
    for link in root.iterfind("link"):
        for visual in (*link.findall("visual"), *link.findall("collision")):
            link.remove(visual)
    spec = mujoco.MjSpec.from_string(etree.tostring(root).decode())
    other, model = spec.compile(), built.model
    urdf = names(other, "joint", other.njnt)
    mjcf = {model.joint(index).name: int(model.jnt_type[index]) for index in range(model.njnt)}
    scalars = {dof["name"] for joint in built.robot["joints"] for dof in joint["dofs"]} & mjcf.keys()
    balls = {name for name in scalars if mjcf[name] == mujoco.mjtJoint.mjJNT_BALL}
    expected = scalars - balls | {f"{name}_{axis}" for name in balls for axis in "xyz"}
    if set(urdf) != expected:
        yield f"joints {sorted(urdf)}, and of the MJCF {sorted(expected)}"
    for name in urdf:
        # A URDF has to bound both sides, the source perhaps only one.
        for side, said in enumerate(built.dofs[name]["limits"] if name in built.dofs else ()):
            ends = other.joint(name).range[side], model.joint(name).range[side]
            if said is not None and abs(ends[0] - ends[1]) > 1e-9:
                yield f"{name}: {ends[0]} and {ends[1]}"


POINTS = (
    compiles,
    roles_of_geoms,
    colliders,
    inertias,
    total_mass,
    every_body_moves,
    limits,
    named,
    keyframe,
    pieces,
    option,
    placement,
    equalities,
    both_formats,
)
