"""Textured meshes: made by hand, and read back by trimesh and by MuJoCo.

Corners (m, 3, 5) are x, y, z [m] and u, v of the corners of each triangle; v upwards.
"""

import io
import struct
import zlib

import mujoco
import numpy as np
import trimesh

from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot import codec
from tests.support.building import plan_of, write

QUADRANTS = ((255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0))
"""The colours of the image: upper left, upper right, lower left, lower right."""


def image(size=4, colours=QUADRANTS):
    """A PNG of four colours, written by hand."""
    half = size // 2
    rows = [bytes(colours[k]) * half + bytes(colours[k + 1]) * half for k in (0, 2) for _ in range(half)]
    return png(size, size, rows)


def png(width, height, rows, depth=8, colour=2):
    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + b"".join(map(chunk, (b"IHDR", b"IDAT", b"IEND"), (head, pixels, b"")))


def chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def cube(side=0.2, shift=(0.3, 0.0, -0.1)):
    """A cube with the image on each side, upright and smaller from one side to the next: every edge is a
    seam."""
    quads = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            across, up = np.eye(3)[(axis + 1) % 3] * sign, np.eye(3)[(axis + 2) % 3]
            size = 1 - len(quads) / 10
            quads.append(
                [
                    [*((np.cross(across, up) + a * across + b * up) * side / 2), a, b]
                    for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
                ]
            )
            quads[-1] = [[*point, (a + 1) / 2 * size, (b + 1) / 2 * size] for *point, a, b in quads[-1]]
    corners = np.array(quads)
    corners[:, :, :3] += shift
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def obj(corners, material="m", library="m.mtl"):
    """An OBJ that shares its points, and so has two or three pairs (u, v) at each."""
    points, place = np.unique(corners[..., :3].reshape(-1, 3), axis=0, return_inverse=True)
    pairs, uv = np.unique(corners[..., 3:].reshape(-1, 2), axis=0, return_inverse=True)
    lines = [f"mtllib {library}"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [f"vt {u!r} {v!r}" for u, v in pairs.tolist()]
    lines += [f"usemtl {material}"]
    both = np.stack([place.reshape(-1, 3), uv.reshape(-1, 3)], axis=-1) + 1
    lines += ["f " + " ".join(f"{a}/{b}" for a, b in face) for face in both.tolist()]
    return "\n".join(lines).encode() + b"\n"


def put(folder, **files):
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return folder


def urdf(*visuals):
    """A robot of one link with these visuals."""
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    inertial = f'<inertial><mass value="1"/>{inertia}</inertial>'
    return f'<robot name="robot"><link name="a">{inertial}{"".join(visuals)}</link></robot>'.encode()


def visual(file, scale="1 1 1", xyz="0 0 0", inside=""):
    return (
        f'<visual><origin xyz="{xyz}"/><geometry><mesh filename="{file}" scale="{scale}"/></geometry>'
        f"{inside}</visual>"
    )


def built(source, **mesh):
    """A robot's file through the stages from fetch to mesh, once through the codec."""
    from linkwright.stages.fetch import fetch
    from linkwright.stages.fetch.source import FetchContext

    plan = plan_of(source=source, mesh=mesh)
    fetched = fetch(plan, FetchContext(replies=None, environ={}))  # type: ignore[arg-type]
    bundle = codec.decode_bundle(codec.encode_bundle(fetched.bundle))
    robot = build_robot(bundle, plan)

    def memo(kind, key, make):
        return make()

    geometry = make_geometry(robot, bundle, plan, memo)
    return robot, codec.decode_geometry(codec.encode_geometry(geometry)), plan, fetched


def built_into(folder, source, **mesh):
    robot, geometry, plan, _ = built(source, **{"collider": "visual", **mesh})
    write(robot, folder, plan, geometry)
    return robot, geometry, plan


def by_trimesh(path):
    """The corners of an OBJ's triangles, as trimesh reads them."""
    mesh = trimesh.load(io.BytesIO(path.read_bytes()), file_type="obj", process=False)
    return np.concatenate([mesh.vertices, mesh.visual.uv], axis=1)[mesh.faces]


def by_mujoco(model, mesh):
    """The corners of a mesh's triangles, as MuJoCo has them: its v points downwards."""
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
    points = model.mesh_vert[first : first + count] @ turn.reshape(3, 3).T + model.mesh_pos[mesh]
    first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    pairs = model.mesh_texcoord[int(model.mesh_texcoordadr[mesh]) :].astype(float) * [1, -1] + [0, 1]
    faces = slice(first, first + count)
    return np.concatenate([points[model.mesh_face[faces]], pairs[model.mesh_facetexcoord[faces]]], axis=-1)


def ordered(corners):
    """Triangles in an order of their own, each from its least corner on, in the sense that it runs."""
    rounded = np.round(corners, 6) + 0.0
    keys = [[tuple(corner) for corner in triangle] for triangle in rounded.tolist()]
    turned = [triangle[k:] + triangle[:k] for triangle in keys for k in [triangle.index(min(triangle))]]
    return np.array(sorted(turned))
