"""Reads and writes a bundle as a zip file: `manifest.json` and `replies/<sha256>`.

A bundle may come from anyone, so it is not trusted: nothing is unpacked to disk, other names are refused,
sizes are checked before anything is inflated, no entry is inflated beyond its declared size, a reply may be
as large as its kind of source allows (`Source.largest_reply`), and every reply must match the digest that is
its name.

`manifest.json` is an object:

    format, kind   1 and "onshape"
    api            the version of the API that was asked, "v16"
    definition_api the version for the definition, "v17"; missing if it is the same
    root           {document, microversion, element, configuration} of the assembly
    definition     the digest of the assembly definition
    requests       {request: digest}: the path below /api/<api> with its query, and its reply

The manifest of a robot file has its kind ("urdf", "mjcf"), an empty api, the name of the file as the
document, and the digest of its text or model as the definition. It has a request `mesh/<key>` for each mesh,
whose body is in the compact form of triangles, a request `image/<sha256>` for each image (PNG) of the meshes,
and `options`, {name: text}, for the reader of the file.

Recordings of other clients can be turned into bundles: the assembly definition, and of each part studio in it
the mass properties, whole (`/partstudios/.../massproperties`) or of each part that is used
(`/parts/.../partid/<id>/massproperties`); without `.../tessellatedfaces` the robot has no meshes. A request
may hold any query: a recording has only the replies that it has. `pack` makes the zip.
"""

import io
import json
import re
import stat
import struct
import zipfile
import zlib
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    model_validator,
)

from linkwright.stages.fetch import SOURCES, source_class
from linkwright.stages.fetch.recording import MAX_BYTES, Recording
from linkwright.stages.robot.bundle import Bundle, FileBundle, OnshapeBundle
from linkwright.stages.robot.errors import SourceError

FORMAT = 1
_MANIFEST = "manifest.json"
_DEFINITION = "the definition"
_FOLDER = "replies/"
_REPLY = re.compile(r"replies/([0-9a-f]{64})")
_ENTRY = b"PK\x01\x02"  # the first bytes of each entry of a zip's directory
_MAX_ENTRIES = 20_000
"""Largest number of entries."""

_MAX_MANIFEST = 1 << 24
"""Largest size of manifest.json [bytes]."""

_MAX_RATIO = 400
"""Largest ratio of an entry's unpacked to its packed size."""

_MIN_SIZE_FOR_RATIO = 1 << 20
"""Unpacked size up to which the ratio is not checked [bytes]."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The time of every entry, so that the zip does not depend on when it is made."""

_UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    NotImplementedError,
    OSError,
    RuntimeError,
    ValueError,
)

_Digest = Annotated[str, StringConstraints(strict=True, pattern=r"^[0-9a-f]{64}$")]
_Text = Annotated[str, StringConstraints(strict=True, min_length=1)]
_Version = Annotated[str, StringConstraints(strict=True, pattern=r"^(v\d+)?$")]
_MaybeText = Annotated[str, StringConstraints(strict=True, min_length=0)]


def _checked_kind(kind: str) -> str:
    if kind in SOURCES and source_class(kind).recorded:
        return kind
    msg = f"there are no bundles of the kind {kind!r}"
    raise ValueError(msg)


class _Root(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")

    document: _Text
    microversion: _Text
    element: _MaybeText
    configuration: _MaybeText


class _Manifest(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")

    format: Literal[1]
    kind: Annotated[str, AfterValidator(_checked_kind)]
    api: _Version
    definition_api: _Version = ""
    root: _Root
    definition: _Digest
    requests: dict[_Text, _Digest]
    options: dict[_Text, _MaybeText] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _checked_root(self) -> Self:
        if self.kind == "onshape" and not (self.api and self.root.element and self.root.configuration):
            msg = "an Onshape assembly has an api, an element and a configuration"
            raise ValueError(msg)
        return self


def read(data: bytes, where: str) -> Recording:
    """Returns the recording in a zip's bytes; `where` names the file in messages.

    Raises SourceError for every invalid file: not a zip, damaged, names that leave the folder, links, too
    many or too large entries, wrong digests, missing entries, another format.
    """
    entries = _entries(data, where)
    if _MANIFEST not in entries:
        raise _refused("it has no manifest.json, so it is not a bundle", where)
    manifest = _manifest(entries.pop(_MANIFEST), where)
    blobs = {name.removeprefix(_FOLDER): body for name, body in entries.items()}
    for name, body in blobs.items():
        if sha256(body).hexdigest() != name:
            raise _refused(f"its reply {name} does not match its digest: the file was changed", where)
    size_limit_of = source_class(manifest.kind).largest_reply
    for request, name in sorted({_DEFINITION: manifest.definition, **manifest.requests}.items()):
        if name not in blobs:
            raise _refused(f"it lacks the reply {name} ({request})", where)
        limit = size_limit_of(request)
        if len(blobs[name]) > limit:
            why = f"its reply {name} ({request}) has {len(blobs[name])} bytes; at most {limit} are read"
            raise _refused(why, where)
    return Recording(
        kind=manifest.kind,
        api=manifest.api,
        root=manifest.root.model_dump(),
        definition=manifest.definition,
        requests=dict(manifest.requests),
        blobs=blobs,
        options=dict(manifest.options),
        definition_api=manifest.definition_api,
    )


def is_bundle(file: Path) -> bool:
    """Tells whether a file is a zip with the names of a bundle, whatever its entries hold."""
    try:
        with zipfile.ZipFile(file) as archive:
            names = set(archive.namelist())
    except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError):
        return False
    return _MANIFEST in names and all(map(_REPLY.fullmatch, names - {_MANIFEST}))


def pack(bundle: Bundle) -> bytes:
    """Packs a bundle as a zip: the same bundle gives the same bytes, with the same zlib."""
    manifest = {
        "format": FORMAT,
        "kind": bundle.kind,
        **_kind_fields(bundle),
        "root": dict(bundle.root),
        "definition": bundle.definition,
        "requests": dict(bundle.requests),
    }
    text = json.dumps(manifest, indent=1, sort_keys=True, ensure_ascii=False)
    entries = {_MANIFEST: text.encode() + b"\n"}
    entries |= {_FOLDER + name: bundle.blobs[name] for name in sorted(bundle.blobs)}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, body in entries.items():
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3  # as on Unix, wherever it is made
            info.external_attr = 0o644 << 16
            archive.writestr(info, body)
    return file.getvalue()


def _kind_fields(bundle: Bundle) -> dict[str, object]:
    """Returns the manifest's keys for this kind of bundle only; the `api` of a file is empty."""
    if isinstance(bundle, OnshapeBundle):
        version_field = {"definition_api": bundle.definition_api} if bundle.definition_api else {}
        return {"api": bundle.api, **version_field}
    options = bundle.options if isinstance(bundle, FileBundle) else {}
    return {"api": "", **({"options": dict(options)} if options else {})}


def _entries(data: bytes, where: str) -> dict[str, bytes]:
    """Returns the zip's entries by name. Raises SourceError for a name or size that a bundle must not
    have."""
    # The library makes an object of each entry before any can be counted.
    if data.count(_ENTRY) > 2 * _MAX_ENTRIES:
        raise _refused(f"it has more entries than the {_MAX_ENTRIES} that are read", where)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            infos = [info for info in archive.infolist() if info.filename != _FOLDER]
            _check_names(infos, where)
            _check_sizes(infos, where)
            return {info.filename: _inflated(archive, info) for info in infos}
    except _UNREADABLE as error:
        kind = "damaged" if zipfile.is_zipfile(io.BytesIO(data)) else "not a zip file"
        raise _refused(f"it is {kind} ({type(error).__name__}: {error})", where) from None


def _inflated(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    """Returns an entry's bytes, read in pieces: in one go the library would inflate everything before it
    checks the size."""
    with archive.open(info) as entry:
        body = entry.read(info.file_size)
        # The check sum is compared only when the end is read.
        if len(body) != info.file_size or entry.read(1):
            msg = f"{info.filename} does not have the size in its header"
            raise ValueError(msg)
    return body


def _check_names(infos: list[zipfile.ZipInfo], where: str) -> None:
    if len(infos) > _MAX_ENTRIES:
        raise _refused(f"it has {len(infos)} entries; at most {_MAX_ENTRIES} are read", where)
    earlier_names: set[str] = set()
    for info in infos:
        name = info.orig_filename
        if name.startswith(("/", "\\")) or ":" in name or ".." in re.split(r"[/\\]", name):
            raise _refused(f"its entry {name!r} points outside of the bundle", where)
        if stat.S_ISLNK(info.external_attr >> 16):
            raise _refused(f"its entry {name!r} is a link", where)
        if name != _MANIFEST and not _REPLY.fullmatch(name):
            raise _refused(f"its entry {name!r} is neither manifest.json nor replies/<sha256>", where)
        if info.flag_bits & 1:
            raise _refused(f"its entry {name!r} is encrypted", where)
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            # Other methods let a file of a few bytes ask for gigabytes of working memory.
            raise _refused(f"its entry {name!r} is packed by another method than deflate", where)
        if name in earlier_names:
            raise _refused(f"its entry {name!r} occurs twice", where)
        earlier_names.add(name)


def _check_sizes(infos: list[zipfile.ZipInfo], where: str) -> None:
    total = sum(info.file_size for info in infos)
    if total > MAX_BYTES:
        raise _refused(f"it would unpack to {total} bytes; at most {MAX_BYTES} are read", where)
    for info in infos:
        if info.filename == _MANIFEST and info.file_size > _MAX_MANIFEST:
            raise _refused(f"its manifest.json would unpack to {info.file_size} bytes", where)
        bound = _MAX_RATIO * max(info.compress_size, 1)
        if info.file_size > _MIN_SIZE_FOR_RATIO and info.file_size > bound:
            raise _refused(f"its entry {info.filename!r} is compressed too strongly to be a reply", where)


def _manifest(body: bytes, where: str) -> _Manifest:
    try:
        data = json.loads(body)
    except (ValueError, RecursionError):
        raise _refused("its manifest.json is not JSON", where) from None
    if not isinstance(data, dict):
        raise _refused("its manifest.json is not a JSON object", where)
    file_format = data.get("format")
    if isinstance(file_format, int) and file_format > FORMAT:
        msg = f"not readable as a bundle: it has format {file_format}, and this version reads {FORMAT}"
        raise SourceError(msg, where, "update linkwright")
    try:
        return _Manifest.model_validate(data)
    except ValidationError as error:
        faults = "; ".join(
            f"{'.'.join(str(step) for step in problem['loc'])}: {problem['msg']}"
            for problem in error.errors()[:3]
        )
        raise _refused(f"its manifest.json is malformed ({faults})", where) from None


def _refused(why: str, where: str) -> SourceError:
    msg = f"not readable as a bundle: {why}"
    return SourceError(msg, where, "make the bundle again, or copy it again from its source")
