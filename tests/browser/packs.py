"""Packs of small models for the view, made of a compiled model and nothing else: what a build packs is
tested with a build."""

import gzip
import json
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

JOINTS = {0: "free", 1: "ball", 2: "slide", 3: "hinge"}
UNITS = {"free": "", "ball": "rad", "slide": "m", "hinge": "rad"}
GEOMS = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
VISUAL_GROUP = 2

Pack = tuple[dict[str, Any], bytes]
"""The header, and the binary part."""


def listed(values: Any) -> list[Any]:
    return np.asarray(values, float).tolist()


class _Binary:
    """The binary part, which grows."""

    def __init__(self) -> None:
        self.content = bytearray()

    def add(self, content: bytes) -> int:
        at = len(self.content)
        self.content += content + b"\0" * (-len(content) % 4)
        return at


def pack_of(model: Any, xml: str | None = None, files: Mapping[str, bytes] | None = None) -> Pack:
    """The header and the binary part. `xml`, `files`: the engine's own copy; without it the view only
    poses."""
    binary = _Binary()
    engine = None
    if xml is not None:
        kept = {
            name: {"at": binary.add(content), "bytes": len(content)}
            for name, content in (files or {}).items()
        }
        engine = {"xml": xml, "files": kept, "lacks": []}
    header = {
        "version": 1,
        "name": "model",
        "source": "scene.xml",
        "bodies": [_body(model, body) for body in range(model.nbody)],
        "joints": [_joint(model, joint) for joint in range(model.njnt)],
        "relations": _relations(model),
        "loops": _loops(model),
        "keyframes": [
            {
                "name": model.key(i).name,
                "qpos": listed(model.key_qpos[i]),
                "ctrl": listed(model.key_ctrl[i]),
                "act": listed(model.key_act[i]),
            }
            for i in range(model.nkey)
        ],
        "qpos0": listed(model.qpos0),
        "activations": int(model.na),
        "actuators": [_actuator(model, actuator) for actuator in range(model.nu)],
        "geoms": [_geom(model, geom) for geom in range(model.ngeom) if int(model.geom_type[geom]) in GEOMS],
        "meshes": [_mesh(model, mesh, binary) for mesh in range(model.nmesh)],
        "frames": [
            {
                "name": model.site(i).name,
                "body": int(model.site_bodyid[i]),
                "pos": listed(model.site_pos[i]),
                "quat": listed(model.site_quat[i]),
            }
            for i in range(model.nsite)
        ],
        "gravity": listed(model.opt.gravity),
        "timestep": float(model.opt.timestep),
        "camera": {
            "center": listed(model.stat.center),
            "extent": float(model.stat.extent),
            "azimuth": 135,
            "elevation": -20,
        },
        "thinned": None,
        "links": [
            {
                "name": model.body(body).name,
                "mass": float(model.body_mass[body]),
                "parts": [{"name": f"part of {model.body(body).name}", "mass": float(model.body_mass[body])}],
                "colliders": [],
            }
            for body in range(1, model.nbody)
        ],
        "engine": engine,
    }
    return header, bytes(binary.content)


def packed(pack: Pack) -> bytes:
    header, content = pack
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return gzip.compress(len(text).to_bytes(4, "little") + text + content, mtime=0)


def _body(model: Any, body: int) -> dict[str, Any]:
    return {
        "name": model.body(body).name,
        "parent": int(model.body_parentid[body]),
        "pos": listed(model.body_pos[body]),
        "quat": listed(model.body_quat[body]),
        "mass": float(model.body_mass[body]),
        "com": listed(model.body_ipos[body]),
        "inertia": {"quat": listed(model.body_iquat[body]), "diagonal": listed(model.body_inertia[body])},
        "link": body - 1 if body else None,
    }


def _joint(model: Any, joint: int) -> dict[str, Any]:
    kind = JOINTS[int(model.jnt_type[joint])]
    address = int(model.jnt_qposadr[joint])
    return {
        "name": model.joint(joint).name,
        "body": int(model.jnt_bodyid[joint]),
        "type": kind,
        "pos": listed(model.jnt_pos[joint]),
        "axis": listed(model.jnt_axis[joint]),
        "range": listed(model.jnt_range[joint]) if model.jnt_limited[joint] else None,
        "qpos": address,
        "dof": int(model.jnt_dofadr[joint]),
        "ref": float(model.qpos0[address]) if kind in ("hinge", "slide") else 0.0,
        "label": model.joint(joint).name,
        "unit": UNITS[kind],
    }


def _relations(model: Any) -> list[dict[str, Any]]:
    return [
        {
            "follower": int(model.eq_obj1id[i]),
            "driver": int(model.eq_obj2id[i]),
            "polynomial": listed(model.eq_data[i][:5]),
        }
        for i in range(model.neq)
        if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT
    ]


def _loops(model: Any) -> list[dict[str, Any]]:
    """Those between sites, as Linkwright writes them."""
    loops = []
    for i in range(model.neq):
        kind = {0: "connect", 1: "weld"}.get(int(model.eq_type[i]))
        if kind is None:
            continue
        sites = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        frames = [{"pos": listed(model.site_pos[s]), "quat": listed(model.site_quat[s])} for s in sites]
        loops.append(
            {
                "name": model.eq(i).name,
                "type": kind,
                "bodies": [int(model.site_bodyid[s]) for s in sites],
                "a_from": frames[0],
                "b_from": frames[1],
            }
        )
    return loops


def _actuator(model: Any, actuator: int) -> dict[str, Any]:
    position = model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE
    of_joint = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
    joint = int(model.actuator_trnid[actuator, 0]) if of_joint else None
    limited = bool(model.actuator_ctrllimited[actuator])
    state = int(model.actuator_actadr[actuator])
    target = {"ctrl": state < 0, "act": None if state < 0 else state, "slope": 1.0, "offset": 0.0}
    return {
        "name": model.actuator(actuator).name,
        "kind": "position" if position else "motor",
        "joint": joint,
        "range": listed(model.actuator_ctrlrange[actuator]) if limited else None,
        "unit": UNITS[JOINTS[int(model.jnt_type[joint])]] if position and joint is not None else "N",
        "target": target if position and joint is not None else None,
    }


def _geom(model: Any, geom: int) -> dict[str, Any]:
    body = int(model.geom_bodyid[geom])
    role = "ground" if body == 0 else "visual" if model.geom_group[geom] == VISUAL_GROUP else "collision"
    material = int(model.geom_matid[geom])
    colour = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    mesh = int(model.geom_dataid[geom])
    return {
        "body": body,
        "role": role,
        "type": GEOMS[int(model.geom_type[geom])],
        "size": listed(model.geom_size[geom]),
        "pos": listed(model.geom_pos[geom]),
        "quat": listed(model.geom_quat[geom]),
        "rgba": listed(colour),
        "mesh": mesh if mesh >= 0 else None,
        "name": model.geom(geom).name,
    }


def _mesh(model: Any, mesh: int, binary: _Binary) -> dict[str, Any]:
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.asarray(model.mesh_vert[first : first + count], float)
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    indices = np.asarray(model.mesh_face[face : face + faces])
    origin, span = vertices.min(axis=0), np.ptp(vertices, axis=0)
    step = np.where(span > 0, span / 65535, 1.0)
    small = count <= 65536
    return {
        "positions": {
            "at": binary.add(np.round((vertices - origin) / step).astype("<u2").tobytes()),
            "count": count,
            "origin": listed(origin),
            "step": listed(step),
        },
        "indices": {
            "at": binary.add(indices.astype("<u2" if small else "<u4").tobytes()),
            "count": 3 * faces,
            "bytes": 2 if small else 4,
        },
        "faces": faces,
        "of_faces": faces,
    }
