"""Packs of small models for the view, made of a compiled model and nothing else: what a build packs is
tested with a build."""

import gzip
import json

import mujoco
import numpy as np

JOINTS = {0: "free", 1: "ball", 2: "slide", 3: "hinge"}
UNITS = {"free": "", "ball": "rad", "slide": "m", "hinge": "rad"}
GEOMS = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
VISUAL_GROUP = 2


def listed(values):
    return np.asarray(values, float).tolist()


class _Binary:
    """The binary part, which grows."""

    def __init__(self):
        self.content = bytearray()

    def add(self, content):
        at = len(self.content)
        self.content += content + b"\0" * (-len(content) % 4)
        return at


def pack_of(model, xml=None, files=None):
    """The header and the binary part. `xml`, `files`: the engine's own copy; without it the view only
    poses."""
    binary = _Binary()
    engine = None
    if xml is not None:
        parts = (files or {}).items()
        kept = {name: {"at": binary.add(content), "bytes": len(content)} for name, content in parts}
        engine = {"xml": xml, "files": kept, "lacks": []}
    camera = {"center": listed(model.stat.center), "extent": float(model.stat.extent)}
    header = {
        "version": 1, "name": "model", "source": "scene.xml", "thinned": None, "engine": engine,
        "bodies": [_body(model, body) for body in range(model.nbody)],
        "joints": [_joint(model, joint) for joint in range(model.njnt)],
        "relations": _relations(model),
        "loops": _loops(model),
        "keyframes": [_keyframe(model, key) for key in range(model.nkey)],
        "qpos0": listed(model.qpos0),
        "activations": int(model.na),
        "actuators": [_actuator(model, actuator) for actuator in range(model.nu)],
        "geoms": [_geom(model, geom) for geom in range(model.ngeom) if int(model.geom_type[geom]) in GEOMS],
        "meshes": [_mesh(model, mesh, binary) for mesh in range(model.nmesh)],
        "frames": [
            {"name": model.site(i).name, "body": int(model.site_bodyid[i])}
            | _pose(model.site_pos[i], model.site_quat[i])
            for i in range(model.nsite)
        ],
        "gravity": listed(model.opt.gravity),
        "timestep": float(model.opt.timestep),
        "camera": {**camera, "azimuth": 135, "elevation": -20},
        "links": [_link(model, body) for body in range(1, model.nbody)],
    }  # fmt: skip
    return header, bytes(binary.content)


def packed(pack):
    header, content = pack
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return gzip.compress(len(text).to_bytes(4, "little") + text + content, mtime=0)


def _pose(pos, quat):
    return {"pos": listed(pos), "quat": listed(quat)}


def _link(model, body):
    name, mass = model.body(body).name, float(model.body_mass[body])
    parts = [{"name": f"part of {name}", "mass": mass}]
    return {"name": name, "mass": mass, "parts": parts, "colliders": []}


def _keyframe(model, key):
    row = model.key(key)
    return {"name": row.name, **{name: listed(getattr(row, name)) for name in ("qpos", "ctrl", "act")}}


def _body(model, body):
    return {
        "name": model.body(body).name,
        "parent": int(model.body_parentid[body]),
        **_pose(model.body_pos[body], model.body_quat[body]),
        "mass": float(model.body_mass[body]),
        "com": listed(model.body_ipos[body]),
        "inertia": {"quat": listed(model.body_iquat[body]), "diagonal": listed(model.body_inertia[body])},
        "link": body - 1 if body else None,
    }


def _joint(model, joint):
    kind = JOINTS[int(model.jnt_type[joint])]
    address, name = int(model.jnt_qposadr[joint]), model.joint(joint).name
    return {
        "name": name, "label": name, "type": kind, "unit": UNITS[kind],
        "body": int(model.jnt_bodyid[joint]),
        "pos": listed(model.jnt_pos[joint]),
        "axis": listed(model.jnt_axis[joint]),
        "range": listed(model.jnt_range[joint]) if model.jnt_limited[joint] else None,
        "qpos": address,
        "dof": int(model.jnt_dofadr[joint]),
        "ref": float(model.qpos0[address]) if kind in ("hinge", "slide") else 0.0,
    }  # fmt: skip


def _relations(model):
    joints = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT]
    ends = [(int(model.eq_obj1id[i]), int(model.eq_obj2id[i]), listed(model.eq_data[i][:5])) for i in joints]
    return [dict(zip(("follower", "driver", "polynomial"), end, strict=True)) for end in ends]


def _loops(model):
    """The loops between sites, as Linkwright writes them."""
    loops = []
    for i in range(model.neq):
        kind = {0: "connect", 1: "weld"}.get(int(model.eq_type[i]))
        if kind is not None:
            sites = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            bodies = [int(model.site_bodyid[site]) for site in sites]
            a, b = (_pose(model.site_pos[site], model.site_quat[site]) for site in sites)
            loops.append({"name": model.eq(i).name, "type": kind, "bodies": bodies, "a_from": a, "b_from": b})
    return loops


def _actuator(model, actuator):
    position = model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE
    of_joint = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
    joint = int(model.actuator_trnid[actuator, 0]) if of_joint else None
    limited = bool(model.actuator_ctrllimited[actuator])
    state = int(model.actuator_actadr[actuator])
    target = {"ctrl": state < 0, "act": None if state < 0 else state, "slope": 1.0, "offset": 0.0}
    held = position and joint is not None
    return {
        "name": model.actuator(actuator).name,
        "kind": "position" if position else "motor",
        "joint": joint,
        "range": listed(model.actuator_ctrlrange[actuator]) if limited else None,
        "unit": UNITS[JOINTS[int(model.jnt_type[joint])]] if held else "N",
        "target": target if held else None,
    }


def _geom(model, geom):
    body, material, mesh = (int(getattr(model, f"geom_{key}")[geom]) for key in ("bodyid", "matid", "dataid"))
    role = "ground" if body == 0 else "visual" if model.geom_group[geom] == VISUAL_GROUP else "collision"
    return {
        "body": body,
        "role": role,
        "type": GEOMS[int(model.geom_type[geom])],
        "size": listed(model.geom_size[geom]),
        **_pose(model.geom_pos[geom], model.geom_quat[geom]),
        "rgba": listed(model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]),
        "mesh": mesh if mesh >= 0 else None,
        "name": model.geom(geom).name,
    }


def _mesh(model, mesh, binary):
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + count], float)
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    kind, size = ("<u2", 2) if count <= 65536 else ("<u4", 4)
    origin, span = vertices.min(axis=0), np.ptp(vertices, axis=0)
    step = np.where(span > 0, span / 65535, 1.0)
    points = binary.add(np.round((vertices - origin) / step).astype("<u2").tobytes())
    corners = binary.add(np.asarray(model.mesh_face[face : face + faces]).astype(kind).tobytes())
    return {
        "positions": {"at": points, "count": count, "origin": listed(origin), "step": listed(step)},
        "indices": {"at": corners, "count": 3 * faces, "bytes": size},
        "faces": faces,
        "of_faces": faces,
    }
