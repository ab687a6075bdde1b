"""Makes a bundle of a URDF and its meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from linkwright.stages.fetch.robot_file import IMAGE
from linkwright.stages.fetch.urdf.mesh_paths import MeshPlace
from linkwright.stages.fetch.urdf.meshes.companions import companions
from linkwright.stages.fetch.urdf.meshes.loose_mesh import LooseMesh, body
from linkwright.stages.fetch.urdf.meshes.mesh_file import Unreadable, read
from linkwright.stages.fetch.urdf.meshes.textures import NO_COORDINATES, Texture, texture
from linkwright.stages.fetch.urdf.srdf_file import NAME_OPTION, SRDF, SrdfFile, is_named_by_user
from linkwright.stages.fetch.urdf.survey import LARGEST_MESH, Survey, survey
from linkwright.stages.formats import png
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.formats.srdf.parse import parse_srdf
from linkwright.stages.formats.urdf.model import Urdf, UrdfShape, mesh_key
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.formats.xml import Malformed
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import Diagnostic, SourceError
from linkwright.stages.robot.system import regular_files

if TYPE_CHECKING:
    from linkwright.stages.fetch.urdf.section import UrdfSourceSection

ROBOT = "robot.urdf"
"""The request for the robot's text."""

_SKIP_HINT = "build without them: source.missing_meshes=skip"
_PLACES_HINT = (
    "put the files at the paths in the URDF, name packages by source.packages={name: FOLDER}, "
    f"or {_SKIP_HINT}"
)


def gather(
    source: UrdfSourceSection, environ: Mapping[str, str]
) -> tuple[FileBundle, tuple[Diagnostic, ...]]:
    """Makes the bundle of a robot's file; returns it with the diagnostics of the search for its meshes.

    Raises SourceError with all errors of the text and all meshes that are missing or damaged.
    """
    robot_files = survey(source, environ)
    srdf, srdf_reports = _srdf(source, robot_files.srdf)
    robot = parse(robot_files.text, robot_files.document)
    files = _Files(robot_files, skip=source.missing_meshes == "skip")
    blobs = files.blobs(robot)
    errors = [
        diagnostic for diagnostic in (*robot.diagnostics, *files.missing) if diagnostic.level == "error"
    ]
    if errors:
        codes = {error.code for error in errors}
        hint = (
            _PLACES_HINT
            if "E-MESH-MISSING" in codes
            else f"to {_SKIP_HINT}"
            if "E-MESH-READ" in codes
            else ""
        )
        count = f"{len(errors)} problems" if len(errors) > 1 else "a problem"
        raise SourceError(f"it has {count}", robot_files.document, hint, errors)
    srdf_request = {SRDF: srdf} if srdf else {}
    texts = (robot_files.text, *srdf_request.values(), *blobs.values())
    bodies = {sha256(blob).hexdigest(): blob for blob in texts} | files.images
    definition = sha256(robot_files.text).hexdigest()
    bundle = FileBundle(
        kind="urdf",
        root={
            "document": robot_files.document,
            "microversion": robot_files.microversion(),
            "element": "",
            "configuration": "",
        },
        definition=definition,
        requests={
            ROBOT: definition,
            **{request: sha256(blob).hexdigest() for request, blob in srdf_request.items()},
            **{f"mesh/{key}": sha256(blobs[key]).hexdigest() for key in sorted(blobs)},
            **{f"{IMAGE}{digest}": digest for digest in sorted(files.images)},
        },
        blobs=bodies,
        options={
            "bad_inertia": source.bad_inertia,
            **({NAME_OPTION: robot_files.srdf.name} if srdf and robot_files.srdf else {}),
        },
    )
    return bundle, (*srdf_reports, *files.found_elsewhere(), *files.missing, *files.lost_images(robot))


def _srdf(source: UrdfSourceSection, file: SrdfFile | None) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """Returns the text of the robot's SRDF, or b"" without an SRDF. Reports W-SRDF for a file that is not
    readable.

    Raises SourceError if the configuration names the file and it is not readable.
    """
    if file is None:
        return b"", ()
    why = file.why
    if not why:
        try:
            parse_srdf(file.text)
        except Malformed as error:
            why = f"it is not readable as an SRDF: {error.place}"
            if is_named_by_user(source):
                raise SourceError(why, file.name, "give an SRDF, or source.srdf=none") from None
    return (b"", (file.unread(why),)) if why else (file.text, ())


class _Files:
    """Reader of the mesh files of a robot and their images, each read once. `images`: digest → an image of a
    mesh."""

    def __init__(self, robot_files: Survey, *, skip: bool) -> None:
        self._survey = robot_files
        self._skip = skip
        self._meshes: dict[Path, LooseMesh | str] = {}
        self._moved: dict[str, Path] = {}
        self._textures: dict[str, Texture] = {}
        self._image_bytes: dict[str, bytes] = {}
        self._lost_textures: dict[tuple[str, str], str] = {}
        self.missing: list[Diagnostic] = []
        self.images: dict[str, bytes] = {}

    def blobs(self, robot: Urdf) -> dict[str, bytes]:
        """Returns the triangles of every mesh of the robot, by key, without those that are missing or
        damaged."""
        shapes = [shape for link in robot.links for shape in (*link.visuals, *link.collisions)]
        visual_keys = {mesh_key(shape) for link in robot.links for shape in link.visuals}
        triangles: dict[str, bytes] = {}
        problems: dict[str, Diagnostic] = {}
        for shape in shapes:
            key = mesh_key(shape)
            if shape.kind != "mesh" or key in triangles:
                continue
            place = self._place(shape.filename)
            mesh = self._mesh(place)
            if isinstance(mesh, str):
                problems[shape.filename] = self._problem(shape.filename, mesh, exists=place.file is not None)
            else:
                image = self._image(shape, mesh) if key in visual_keys else None
                mesh_body = body(mesh, key, shape.scale, shape.colour, image)
                triangles[key] = body_arrays.encode([mesh_body])
                self.images |= {digest: self._image_bytes[digest] for digest in mesh_body.textures if digest}
        self.missing = list(problems.values())
        return triangles

    def _image(self, shape: UrdfShape, mesh: LooseMesh) -> str:
        """Returns the digest of the image that a visual's own material gives the mesh, or ""."""
        if not shape.texture:
            return ""
        texture = self._texture(shape.texture)
        fault = texture.why or (NO_COORDINATES if mesh.texcoords is None else "")
        if fault:
            self._lost_textures[shape.filename, texture.name] = fault
        return "" if fault else texture.digest

    def _texture(self, name: str) -> Texture:
        if name not in self._textures:
            place = self._place(name)
            content = place.why if place.file is None else _bytes(place.file, png.MAX_BYTES)
            self._textures[name] = read_texture = texture(name, content)
            self._image_bytes.setdefault(read_texture.digest, read_texture.image)
        return self._textures[name]

    def _with_shared_images(self, mesh: LooseMesh | str) -> LooseMesh | str:
        """Returns the mesh with images that share their memory with those of other meshes."""
        if isinstance(mesh, str):
            return mesh
        for image in mesh.textures:
            if image is not None and image.image:
                self._image_bytes.setdefault(image.digest, image.image)
        textures = (
            image and replace(image, image=self._image_bytes.get(image.digest, b""))
            for image in mesh.textures
        )
        return replace(mesh, textures=tuple(textures))

    def _place(self, name: str) -> MeshPlace:
        place = self._survey.places.get(name) or self._survey.files.find(name)
        if place.searched and place.file is not None:
            self._moved[name] = place.file
        return place

    def _mesh(self, place: MeshPlace) -> LooseMesh | str:
        """Returns the file's mesh, or the reason for its absence."""
        if place.file is None:
            return place.why
        if place.file not in self._meshes:
            self._meshes[place.file] = self._with_shared_images(
                _content(place.file, self._survey.files.roots())
            )
        return self._meshes[place.file]

    def _problem(self, name: str, why: str, *, exists: bool) -> Diagnostic:
        text, where = f"mesh {name}: {why}", self._survey.document
        hint = "put the file at that path, or remove the <mesh>"
        if exists:
            # A reason that says what to install ends so.
            hint = "" if "pip install" in why else "export the file again"
        if self._skip:
            return Diagnostic("W-NO-MESH", text, where, hint)
        if exists:
            return Diagnostic("E-MESH-READ", text, where, hint)
        return Diagnostic("E-MESH-MISSING", text, where, hint)

    def lost_images(self, robot: Urdf) -> list[Diagnostic]:
        """Reports W-TEXTURE for the images that should give the visual meshes their colours and do not, and
        I-URDF-TEXTURE for other images."""
        images_by_mesh: dict[str, tuple[str, ...]] = {}
        for shape in (shape for link in robot.links for shape in link.visuals if shape.kind == "mesh"):
            mesh = self._mesh(self._place(shape.filename))
            if isinstance(mesh, str):
                continue
            if mesh.images:
                images_by_mesh[shape.filename] = mesh.images
            for image in mesh.textures:
                if image is not None and image.why:
                    self._lost_textures.setdefault((shape.filename, image.name), image.why)
        entries = [
            f"{PurePosixPath(name).name} ({', '.join(images[:3])})" for name, images in images_by_mesh.items()
        ]
        remainder = f" and {len(entries) - 5} more" if len(entries) > 5 else ""
        text = f"images of meshes are not carried over, only colours: {', '.join(entries[:5])}{remainder}"
        remarks = [Diagnostic("I-URDF-TEXTURE", text, self._survey.document)] if images_by_mesh else []
        return [*self._losses(), *remarks]

    def _losses(self) -> list[Diagnostic]:
        hint = "give the mesh a PNG in the robot's folders, and texture coordinates; its colour is carried"
        return [
            Diagnostic(
                "W-TEXTURE",
                f"the texture {name} of {PurePosixPath(mesh).name} is left out: {why}",
                self._survey.document,
                hint,
            )
            for (mesh, name), why in self._lost_textures.items()
        ]

    def found_elsewhere(self) -> list[Diagnostic]:
        """Reports I-MESH-FOUND for files that were found elsewhere: a diagnostic for each folder."""
        groups: dict[tuple[str, str], list[str]] = {}
        for name, file in self._moved.items():
            shown_path = PurePosixPath(self._survey.files.name_in_messages(file))
            named = PurePosixPath(name.replace("\\", "/"))
            if shown_path.name == named.name:
                pair = (_folder(name), f"{shown_path.parent}/")
            else:
                pair = (name, str(shown_path))
            groups.setdefault(pair, []).append(named.name)
        return [
            Diagnostic("I-MESH-FOUND", _moved(named, there, files), self._survey.document)
            for (named, there), files in groups.items()
        ]


def _folder(name: str) -> str:
    return name.replace("\\", "/").rpartition("/")[0] + "/"


def _moved(named_folder: str, folder: str, files: list[str]) -> str:
    if not folder.endswith("/"):
        return f"{named_folder} was not found; {folder} is used instead"
    file_list = ", ".join(files[:5]) + (f" and {len(files) - 5} more" if len(files) > 5 else "")
    return f"{file_list}: not found in {named_folder}, used from {folder}"


def _content(file: Path, roots: Sequence[Path]) -> LooseMesh | str:
    data = _bytes(file, LARGEST_MESH)
    if isinstance(data, str):
        return data
    try:
        return read(data, file.name, companions(file, data, roots))
    except Unreadable as error:
        return str(error)


def _bytes(file: Path, limit: int) -> bytes | str:
    """Returns the content of a file, or the reason why it is not read."""
    try:
        return regular_files.content(file, limit)
    except regular_files.FileTooLarge:
        return f"it is larger than {limit} bytes"
    except OSError as error:
        return f"it cannot be read: {error.strerror or type(error).__name__}"
