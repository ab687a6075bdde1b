"""Lists the files of a robot without reading the robot: its text and the files that it names.

Needs no array or XML library, as it shows whether a robot was built before.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.stages.fetch.urdf import expand, plain, srdf_file, text
from linkwright.stages.fetch.urdf.mesh_paths import MeshPlace, MeshPlaces
from linkwright.stages.fetch.urdf.meshes.companions import NAMING_FILES, companions
from linkwright.stages.fetch.urdf.ros_packages import Packages
from linkwright.stages.fetch.urdf.srdf_file import SrdfFile
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files
from linkwright.stages.robot.system.install import installed

if TYPE_CHECKING:
    from linkwright.stages.fetch.urdf.section import UrdfSourceSection

READER = 3
"""Raised with every change of the result for the same files."""

LARGEST_MESH = 1 << 29
"""Larger mesh files are not read [bytes]."""

LARGEST_ROBOT = 1 << 32
"""The meshes of a robot have no more than this together [bytes]."""


@dataclass(frozen=True, slots=True)
class Survey:
    """A robot's text after xacro, as UTF-8, its SRDF, and the places of the mesh files and of the images of
    its materials, by the names that the text has for them."""

    document: str
    text: bytes
    srdf: SrdfFile | None
    places: Mapping[str, MeshPlace]
    files: MeshPlaces

    def digests(self) -> list[list[str]]:
        """Of each name: where the file is, as messages name it, and the SHA-256 of all it holds.

        SourceError where the files are larger together than is read.
        """
        files = {place.file for place in self.places.values() if place.file is not None}
        if sum(_size(file) for file in files) > LARGEST_ROBOT:
            msg = f"its meshes have more than {LARGEST_ROBOT / 1e9:.3g} GB"
            raise SourceError(
                msg, self.document, "use coarser meshes: a simulation does not need so many triangles"
            )
        return [[name, *self._digest(self.places[name])] for name in sorted(self.places)]

    def microversion(self) -> str:
        """The identity of the robot: the SHA-256 of all files read."""
        beside = [] if self.srdf is None else [sha256(self.srdf.text).hexdigest()]
        content = json.dumps([sha256(self.text).hexdigest(), *beside, self.digests()])
        return sha256(content.encode()).hexdigest()

    def _digest(self, place: MeshPlace) -> tuple[str, str]:
        if place.file is None:
            return "", place.why
        return self.files.shown(place.file), _content_digest(place.file, self.files.roots())


def survey(source: UrdfSourceSection, environ: Mapping[str, str]) -> Survey:
    """ConfigError where xacro is needed, and is not installed or the file not trusted; SourceError where
    the file is not readable as a URDF."""
    path = Path(source.path).absolute()
    given = {name: Path(folder).absolute() for name, folder in source.packages.items()}
    packages = Packages(path.parent, given, environ)
    content = text.read(path, path.name)
    if expand.is_named(path):
        content = text.uncommented(expand.expanded(source, content, environ, packages.find))
    else:
        plain.require(content, path.name)
    places = MeshPlaces(path.parent, packages, text.meshdir(content))
    found = {name: places.find(name) for name in [*text.meshes(content), *text.images(content)]}
    public = _public(found, places)
    folders = _folders(path.parent, packages)
    content = text.without(text.renamed(content, public), folders)
    named = {public.get(name, name): place for name, place in found.items()}
    return Survey(
        path.name, content.encode(), srdf_file.read(source, text.robot_name(content), folders), named, places
    )


def identity(source: UrdfSourceSection, environ: Mapping[str, str]) -> dict[str, Any]:
    """The permanent identity of the source, as plain data."""
    seen = survey(source, environ)
    return {
        "kind": "urdf",
        "document": seen.document,
        "text": sha256(seen.text).hexdigest(),
        "srdf": seen.srdf and [seen.srdf.name, sha256(seen.srdf.text).hexdigest(), seen.srdf.why],
        "meshes": seen.digests(),
        "bad_inertia": source.bad_inertia,
        "missing_meshes": source.missing_meshes,
        "reader": READER,
        "libraries": {name: installed(name) for name in ("trimesh", "pycollada", "numpy")},
    }


def _public(found: Mapping[str, MeshPlace], places: MeshPlaces) -> dict[str, str]:
    """Other names for those that reveal where on this computer a file is."""
    names: dict[str, str] = {}
    folders: dict[str, int] = {}
    for name, place in found.items():
        if not places.is_private(name):
            continue
        shown = places.public(place.file) if place.file and not place.searched else ""
        if not shown:
            parent, _, last = name.replace("\\", "/").rpartition("/")
            shown = f"elsewhere/{folders.setdefault(parent, len(folders) + 1)}/{last}"
        names[name] = shown
    return names


def _folders(folder: Path, packages: Packages) -> dict[str, str]:
    """Folders of this computer that the text may name, and what stands for them."""
    named = {str(place): f"package://{name}" for name, place in packages.found.items()}
    own = {str(folder): ".", str(packages.root): ".", str(Path.home()): "~"}
    return {place: name for place, name in {**own, **named}.items() if len(place) > 1}


def _size(file: Path) -> int:
    """A file's size [bytes]; 0 where it is too large to be read, or is not there any more."""
    try:
        size = file.stat().st_size
    except OSError:
        return 0
    return size if size <= LARGEST_MESH else 0


def _content_digest(file: Path, roots: Sequence[Path]) -> str:
    """The SHA-256 of a file, and of the files that it names; its size where it is too large to be read."""
    try:
        if file.suffix.lower() not in NAMING_FILES:
            return regular_files.digest(file, LARGEST_MESH)
        data = regular_files.content(file, LARGEST_MESH)
    except regular_files.FileTooLarge:
        return "too large"
    except OSError as error:
        return error.strerror or type(error).__name__
    whole, beside = sha256(data), companions(file, data, roots)
    found = {name: content for name, content in beside.images.items() if isinstance(content, bytes)}
    for name, content in sorted({**found, **beside.files}.items()):
        whole.update(f"{name}\0{sha256(content).hexdigest()}".encode())
    return whole.hexdigest()
