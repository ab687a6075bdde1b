"""Takes the look of a robot from its geometry, with its links at given poses, without any engine."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkwright.stages.formats.meshes.faces import mesh_corners
from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.robot.model.geometry import NEUTRAL, Geometry, Shape
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.show.preview.bones import bones
from linkwright.stages.show.preview.look import THREE_QUARTER, UNSEEN, Blob, Geom, Look, Solid, Vector
from linkwright.stages.show.preview.vectors import vector

_SOLIDS: Mapping[str, Solid] = {
    "box": "box",
    "sphere": "ellipsoid",
    "cylinder": "cylinder",
    "capsule": "capsule",
}


def look_of_model(robot: Robot, geometry: Geometry, world_from_link: Mapping[str, Array]) -> Look:
    """Returns the look of a robot whose links are at these poses (4, 4): its visual shapes, else its
    colliders, else bones."""
    blobs = _ModelBlobs(geometry.files)
    geoms = [_geom(shape, world_from_link[shape.link], blobs) for shape in _visible_shapes(geometry.shapes)]
    return Look(tuple(geoms or _bones(robot, world_from_link)), THREE_QUARTER, tuple(blobs.blobs))


def _visible_shapes(shapes: Sequence[Shape]) -> list[Shape]:
    for role in ("visual", "collision"):
        visible = [shape for shape in shapes if shape.role == role and (shape.colour or NEUTRAL)[3] > UNSEEN]
        if visible:
            return visible
    return []


def _geom(shape: Shape, world_from_link: Array, blobs: "_ModelBlobs") -> Geom:
    colour = vector(shape.colour or NEUTRAL)
    primitive = shape.primitive
    if primitive is not None:
        world_from_shape = world_from_link @ primitive.link_from_shape
        place, rotation = vector(world_from_shape[:3, 3]), vector(world_from_shape[:3, :3])
        return Geom(_SOLIDS[primitive.kind], _size(primitive.kind, primitive.size), place, rotation, colour)
    assert shape.file is not None
    place, rotation = vector(world_from_link[:3, 3]), vector(world_from_link[:3, :3])
    image = blobs.image(shape.texture) if shape.texture else -1
    return Geom("mesh", (), place, rotation, colour, blobs.mesh(shape.file), image=image)


def _size(kind: str, size: Vector) -> Vector:
    """Converts a primitive's size to MuJoCo's form, with half lengths."""
    if kind == "box":
        return vector(np.array(size) / 2)
    return vector(size[:1] * 3 if kind == "sphere" else (size[0], size[1] / 2))


def _bones(robot: Robot, world_from_link: Mapping[str, Array]) -> Iterator[Geom]:
    rows = {link.name: row for row, link in enumerate(robot.links)}
    parents = {joint.child: rows[joint.parent] for joint in robot.joints}
    places = np.array([world_from_link[link][:3, 3] for link in rows])
    return bones(places, [parents.get(link) for link in rows])


class _ModelBlobs:
    """Collects the meshes and images of a geometry, each once. `files`: the geometry's files by name."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self.blobs: list[Blob] = []
        self._files = files
        self._rows: dict[str, int] = {}

    def mesh(self, file: str) -> int:
        """Returns the index of the blob with a mesh."""
        if file not in self._rows:
            data = self._files[file]
            self._keep(file, Blob("stl", data) if file.endswith(".stl") else _corners(file, data))
        return self._rows[file]

    def image(self, file: str) -> int:
        """Returns the index of the blob with an image; -1 if the image cannot be read."""
        if file not in self._rows:
            blob = _image(file, self._files[file])
            if blob is None:
                return -1
            self._keep(file, blob)
        return self._rows[file]

    def _keep(self, file: str, blob: Blob) -> None:
        self._rows[file] = len(self.blobs)
        self.blobs.append(blob)


def _corners(file: str, data: bytes) -> Blob:
    corners, texcoords = mesh_corners(file, data)
    places = np.zeros((len(corners), 3, 2)) if texcoords is None else texcoords.copy()
    # The first row of an image is at its top.
    places[:, :, 1] = 1.0 - places[:, :, 1]
    return Blob("corners", corners.astype("<f4").tobytes() + places.astype("<f4").tobytes())


def _image(file: str, data: bytes) -> Blob | None:
    """Returns the pixels of a PNG, which MuJoCo decodes; None if it cannot."""
    text = f'<mujoco><asset><texture name="image" type="2d" file="{file}"/></asset></mujoco>'
    try:
        model = compiled_text(text.encode(), {file: data})
    except NotCompiled:
        return None
    shape = int(model.tex_height[0]), int(model.tex_width[0]), int(model.tex_nchannel[0])
    pixels = np.asarray(model.tex_data[: int(np.prod(shape))]).reshape(shape)
    colours = pixels[:, :, :3] if shape[2] >= 3 else np.repeat(pixels[:, :, :1], 3, axis=2)
    return Blob("image", np.ascontiguousarray(colours).tobytes(), shape[0])
