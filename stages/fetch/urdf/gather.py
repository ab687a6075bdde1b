"""A URDF and its meshes as a bundle."""

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
from linkwright.stages.fetch.urdf.srdf_file import NAME, SRDF, SrdfFile, is_asked
from linkwright.stages.fetch.urdf.survey import LARGEST_MESH, Survey, survey
from linkwright.stages.formats import png, triangles
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
"""The request that stands for the robot's text."""

_SKIP = (
    "put the files at the paths in the URDF, name packages by source.packages={name: FOLDER}, or build "
    "without them: source.missing_meshes=skip"
)


def gather(
    source: UrdfSourceSection, environ: Mapping[str, str]
) -> tuple[FileBundle, tuple[Diagnostic, ...]]:
    """The bundle of a robot's file, and the diagnostics of how its meshes were found.

    SourceError names all errors of the text and all meshes that are missing or damaged.
    """
    seen = survey(source, environ)
    srdf, unread = _srdf(source, seen.srdf)
    robot = parse(seen.text, seen.document)
    files = _Files(seen, skip=source.missing_meshes == "skip")
    blobs = files.blobs(robot)
    errors = [one for one in (*robot.diagnostics, *files.missing) if one.level == "error"]
    if errors:
        hint = _SKIP if any(one.code in ("E-MESH-MISSING", "E-MESH-READ") for one in errors) else ""
        count = f"{len(errors)} problems" if len(errors) > 1 else "a problem"
        raise SourceError(f"it has {count}", seen.document, hint, errors)
    beside = {SRDF: srdf} if srdf else {}
    texts = (seen.text, *beside.values(), *blobs.values())
    bodies = {sha256(blob).hexdigest(): blob for blob in texts} | files.images
    definition = sha256(seen.text).hexdigest()
    bundle = FileBundle(
        kind="urdf",
        root={
            "document": seen.document,
            "microversion": seen.microversion(),
            "element": "",
            "configuration": "",
        },
        definition=definition,
        requests={
            ROBOT: definition,
            **{request: sha256(blob).hexdigest() for request, blob in beside.items()},
            **{f"mesh/{key}": sha256(blobs[key]).hexdigest() for key in sorted(blobs)},
            **{f"{IMAGE}{digest}": digest for digest in sorted(files.images)},
        },
        blobs=bodies,
        options={"bad_inertia": source.bad_inertia, **({NAME: seen.srdf.name} if srdf and seen.srdf else {})},
    )
    return bundle, (*unread, *files.found_elsewhere(), *files.missing, *files.lost_images(robot))


def _srdf(source: UrdfSourceSection, file: SrdfFile | None) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """The text of the robot's SRDF, empty without one; W-SRDF for one that was found and is not readable.

    SourceError where the configuration names it and it is not readable.
    """
    if file is None:
        return b"", ()
    why = file.why
    if not why:
        try:
            parse_srdf(file.text)
        except Malformed as error:
            why = f"it is not readable as an SRDF: {error.place}"
            if is_asked(source):
                raise SourceError(why, file.name, "give an SRDF, or source.srdf=none") from None
    return (b"", (file.unread(why),)) if why else (file.text, ())


class _Files:
    """The mesh files of a robot and their images, each read once. `images`: those that its meshes have, by
    digest."""

    def __init__(self, seen: Survey, *, skip: bool) -> None:
        self._seen = seen
        self._skip = skip
        self._read: dict[Path, LooseMesh | str] = {}
        self._moved: dict[str, Path] = {}
        self._textures: dict[str, Texture] = {}
        self._known: dict[str, bytes] = {}
        self._without: dict[tuple[str, str], str] = {}
        self.missing: list[Diagnostic] = []
        self.images: dict[str, bytes] = {}

    def blobs(self, robot: Urdf) -> dict[str, bytes]:
        """The triangles of every mesh of the robot, by key, without those that are missing or damaged."""
        shapes = [shape for link in robot.links for shape in (*link.visuals, *link.collisions)]
        seen = {mesh_key(shape) for link in robot.links for shape in link.visuals}
        found: dict[str, bytes] = {}
        lacking: dict[str, Diagnostic] = {}
        for shape in shapes:
            key = mesh_key(shape)
            if shape.kind != "mesh" or key in found:
                continue
            place = self._place(shape.filename)
            mesh = self._mesh(place)
            if isinstance(mesh, str):
                lacking[shape.filename] = self._problem(shape.filename, mesh, there=place.file is not None)
            else:
                image = self._image(shape, mesh) if key in seen else None
                made = body(mesh, key, shape.scale, shape.colour, image)
                found[key] = triangles.encode([made])
                self.images |= {digest: self._known[digest] for digest in made.textures if digest}
        self.missing = list(lacking.values())
        return found

    def _image(self, shape: UrdfShape, mesh: LooseMesh) -> str:
        """The digest of the image that a visual's own material gives the mesh, "" for none."""
        if not shape.texture:
            return ""
        texture = self._texture(shape.texture)
        why = texture.why or (NO_COORDINATES if mesh.texcoords is None else "")
        if why:
            self._without[shape.filename, texture.name] = why
        return "" if why else texture.digest

    def _texture(self, name: str) -> Texture:
        if name not in self._textures:
            place = self._place(name)
            content = place.why if place.file is None else _bytes(place.file, png.LARGEST)
            self._textures[name] = found = texture(name, content)
            self._known.setdefault(found.digest, found.image)
        return self._textures[name]

    def _once(self, mesh: LooseMesh | str) -> LooseMesh | str:
        """The mesh with images that other meshes have too in memory only once."""
        if isinstance(mesh, str):
            return mesh
        for one in mesh.textures:
            if one is not None and one.image:
                self._known.setdefault(one.digest, one.image)
        once = (one and replace(one, image=self._known.get(one.digest, b"")) for one in mesh.textures)
        return replace(mesh, textures=tuple(once))

    def _place(self, name: str) -> MeshPlace:
        place = self._seen.places.get(name) or self._seen.files.find(name)
        if place.searched and place.file is not None:
            self._moved[name] = place.file
        return place

    def _mesh(self, place: MeshPlace) -> LooseMesh | str:
        """The file's mesh, or the reason for its absence."""
        if place.file is None:
            return place.why
        if place.file not in self._read:
            self._read[place.file] = self._once(_content(place.file, self._seen.files.roots()))
        return self._read[place.file]

    def _problem(self, name: str, why: str, *, there: bool) -> Diagnostic:
        text, where = f"mesh {name}: {why}", self._seen.document
        hint = "export the file again" if there else "put the file at that path, or remove the <mesh>"
        if self._skip:
            return Diagnostic("W-NO-MESH", text, where, hint)
        if there:
            return Diagnostic("E-MESH-READ", text, where, hint)
        return Diagnostic("E-MESH-MISSING", text, where, hint)

    def lost_images(self, robot: Urdf) -> list[Diagnostic]:
        """W-TEXTURE for the images of the visual meshes that should give them their colours and do not,
        I-URDF-TEXTURE for others."""
        lost: dict[str, tuple[str, ...]] = {}
        for shape in (shape for link in robot.links for shape in link.visuals if shape.kind == "mesh"):
            mesh = self._mesh(self._place(shape.filename))
            if isinstance(mesh, str):
                continue
            if mesh.images:
                lost[shape.filename] = mesh.images
            for one in mesh.textures:
                if one is not None and one.why:
                    self._without.setdefault((shape.filename, one.name), one.why)
        shown = [f"{PurePosixPath(name).name} ({', '.join(found[:3])})" for name, found in lost.items()]
        more = f" and {len(shown) - 5} more" if len(shown) > 5 else ""
        text = f"images of meshes are not carried over, only colours: {', '.join(shown[:5])}{more}"
        others = [Diagnostic("I-URDF-TEXTURE", text, self._seen.document)] if lost else []
        return [*self._losses(), *others]

    def _losses(self) -> list[Diagnostic]:
        hint = "give the mesh a PNG in the robot's folders, and texture coordinates; its colour is carried"
        return [
            Diagnostic(
                "W-TEXTURE",
                f"the texture {name} of {PurePosixPath(mesh).name} is left out: {why}",
                self._seen.document,
                hint,
            )
            for (mesh, name), why in self._without.items()
        ]

    def found_elsewhere(self) -> list[Diagnostic]:
        """I-MESH-FOUND for files that were found elsewhere: one for each folder."""
        groups: dict[tuple[str, str], list[str]] = {}
        for name, file in self._moved.items():
            shown = PurePosixPath(self._seen.files.shown(file))
            named = PurePosixPath(name.replace("\\", "/"))
            if shown.name == named.name:
                pair = (_folder(name), f"{shown.parent}/")
            else:
                pair = (name, str(shown))
            groups.setdefault(pair, []).append(named.name)
        return [
            Diagnostic("I-MESH-FOUND", _moved(named, there, files), self._seen.document)
            for (named, there), files in groups.items()
        ]


def _folder(name: str) -> str:
    return name.replace("\\", "/").rpartition("/")[0] + "/"


def _moved(named: str, there: str, files: list[str]) -> str:
    if not there.endswith("/"):
        return f"{named} was not found; {there} is used instead"
    shown = ", ".join(files[:5]) + (f" and {len(files) - 5} more" if len(files) > 5 else "")
    return f"{shown}: not found in {named}, used from {there}"


def _content(file: Path, roots: Sequence[Path]) -> LooseMesh | str:
    data = _bytes(file, LARGEST_MESH)
    if isinstance(data, str):
        return data
    try:
        return read(data, file.name, companions(file, data, roots))
    except Unreadable as error:
        return str(error)


def _bytes(file: Path, most: int) -> bytes | str:
    """The content of a file, or the reason why it is not read."""
    try:
        return regular_files.content(file, most)
    except regular_files.FileTooLarge:
        return f"it is larger than {most} bytes"
    except OSError as error:
        return f"it cannot be read: {error.strerror or type(error).__name__}"
