"""Lists the files of a robot without reading the robot: its text and the files that it names.

It needs no array or XML library, as it shows whether a robot was built before.
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

READER = 4
"""Version of the reader, to be raised with every change of the result for the same files."""

LARGEST_MESH = 1 << 29
"""Largest size of a mesh file that is read [bytes]."""

LARGEST_ROBOT = 1 << 32
"""Largest total size of the meshes of a robot [bytes]."""


@dataclass(frozen=True, slots=True)
class Survey:
    """The files of a robot."""

    document: str
    """The name of the robot's file."""

    text: bytes
    """The robot's text after xacro, in UTF-8."""

    srdf: SrdfFile | None
    places: Mapping[str, MeshPlace]
    """The places of the mesh files and of the images of materials, by their names in the text."""

    files: MeshPlaces

    def digests(self) -> list[list[str]]:
        """Returns, for each name, the place of the file in messages, and the SHA-256 of its content.

        Raises SourceError if the files together are too large.
        """
        files = {place.file for place in self.places.values() if place.file is not None}
        if sum(_size(file) for file in files) > LARGEST_ROBOT:
            msg = f"its meshes have more than {LARGEST_ROBOT / 1e9:.3g} GB"
            raise SourceError(msg, self.document, "use coarser meshes: a simulation needs fewer triangles")
        return [[name, *self._digest(self.places[name])] for name in sorted(self.places)]

    def microversion(self) -> str:
        """Returns the identity of the robot: the SHA-256 of all files read."""
        srdf_digest = [] if self.srdf is None else [sha256(self.srdf.text).hexdigest()]
        content = json.dumps([sha256(self.text).hexdigest(), *srdf_digest, self.digests()])
        return sha256(content.encode()).hexdigest()

    def _digest(self, place: MeshPlace) -> tuple[str, str]:
        if place.file is None:
            return "", place.why
        return self.files.name_in_messages(place.file), _content_digest(place.file, self.files.roots())


def survey(source: UrdfSourceSection, environ: Mapping[str, str]) -> Survey:
    """Surveys a source.

    Raises ConfigError if xacro is needed, and is not installed or the file is not trusted; SourceError if the
    file is not readable as a URDF.
    """
    path = Path(source.path).absolute()
    configured_packages = {name: Path(folder).absolute() for name, folder in source.packages.items()}
    packages = Packages(path.parent, configured_packages, environ)
    content = text.read(path, path.name)
    if expand.is_named(path):
        content = text.without_comments(expand.expand_xacro(source, content, environ, packages.find))
    else:
        plain.require(content, path.name)
    places = MeshPlaces(path.parent, packages, text.meshdir(content))
    files = {name: places.find(name) for name in [*text.meshes(content), *text.images(content)]}
    public_names = _public_names(files, places)
    folders = _folders(path.parent, packages)
    content = text.without_folders(text.with_renamed_files(content, public_names), folders)
    places_by_name = {public_names.get(name, name): place for name, place in files.items()}
    return Survey(
        path.name,
        content.encode(),
        srdf_file.read(source, text.robot_name(content), folders),
        places_by_name,
        places,
    )


def identity(source: UrdfSourceSection, environ: Mapping[str, str]) -> dict[str, Any]:
    """Returns the permanent identity of the source, as plain data."""
    files = survey(source, environ)
    return {
        "kind": "urdf",
        "document": files.document,
        "text": sha256(files.text).hexdigest(),
        "srdf": files.srdf and [files.srdf.name, sha256(files.srdf.text).hexdigest(), files.srdf.why],
        "meshes": files.digests(),
        "bad_inertia": source.bad_inertia,
        "missing_meshes": source.missing_meshes,
        "reader": READER,
        "libraries": {name: installed(name) for name in ("trimesh", "pycollada", "numpy")},
    }


def _public_names(files: Mapping[str, MeshPlace], places: MeshPlaces) -> dict[str, str]:
    """Returns replacements for names that reveal where on this computer a file is."""
    names: dict[str, str] = {}
    folders: dict[str, int] = {}
    for name, place in files.items():
        if not places.is_private(name):
            continue
        public_name = places.public_name(place.file) if place.file and not place.searched else ""
        if not public_name:
            parent, _, last = name.replace("\\", "/").rpartition("/")
            public_name = f"elsewhere/{folders.setdefault(parent, len(folders) + 1)}/{last}"
        names[name] = public_name
    return names


def _folders(folder: Path, packages: Packages) -> dict[str, str]:
    """Returns the folders of this computer that the text may name → their replacements."""
    package_folders = {str(place): f"package://{name}" for name, place in packages.found.items()}
    own_folders = {str(folder): ".", str(packages.root): ".", str(Path.home()): "~"}
    return {place: name for place, name in {**own_folders, **package_folders}.items() if len(place) > 1}


def _size(file: Path) -> int:
    """Returns a file's size [bytes]; 0 if it is too large to be read, or is gone."""
    try:
        size = file.stat().st_size
    except OSError:
        return 0
    return size if size <= LARGEST_MESH else 0


def _content_digest(file: Path, roots: Sequence[Path]) -> str:
    """Returns the SHA-256 of a file and of the files that it names, or the reason why it cannot be read."""
    try:
        if file.suffix.lower() not in NAMING_FILES:
            return regular_files.digest(file, LARGEST_MESH)
        data = regular_files.content(file, LARGEST_MESH)
    except regular_files.FileTooLarge:
        return "too large"
    except OSError as error:
        return error.strerror or type(error).__name__
    digest, companion_files = sha256(data), companions(file, data, roots)
    images = {name: content for name, content in companion_files.images.items() if isinstance(content, bytes)}
    for name, content in sorted({**images, **companion_files.files}.items()):
        digest.update(f"{name}\0{sha256(content).hexdigest()}".encode())
    return digest.hexdigest()
