"""`linkwright bundle NAME OUT.zip`: packs the inputs of a build into one file."""

import contextlib
import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkwright.pipeline.errors import CacheError, ConfigError, OutputError
from linkwright.pipeline.output import access
from linkwright.pipeline.terminal import pasted
from linkwright.pipeline.terminal.output import say
from linkwright.stages.robot.text.plural import count

HELP = """\
linkwright bundle: pack the inputs of a build into one file, to build the robot
anywhere.

usage: linkwright bundle NAME OUT.zip [cache.dir=FOLDER]

  linkwright bundle my_arm my_arm.zip
                                    the inputs of the build in outputs/my_arm
  linkwright bundle builds/arm.failed arm.zip
                                    the folder of any build, also of a failed
                                    build

NAME is the robot's name, or the output folder of its build. The replies come
from the cache, so no API call is made. It is the cache that the build used (key
cache.dir, environment LINKWRIGHT_CACHE, or the platform's folder), unless
cache.dir= names another. OUT.zip is replaced if it is a bundle.

The zip holds the replies of the CAD system, unchanged; for a URDF its text
(after xacro) and the triangles of its meshes; for an MJCF the model that MuJoCo
compiled. It holds no API key and nothing about this computer. On any computer,
the same configuration builds the same robot files from it:

  linkwright robot=my_arm source=bundle source.path=my_arm.zip

exit status: 0 packed; 1 failed (the cache no longer has it); 2 wrong usage
"""

_USAGE = "linkwright bundle NAME OUT.zip; linkwright bundle --help shows more"
_CACHE = "cache.dir="


@dataclass(frozen=True, slots=True)
class Request:
    """The arguments: the build, the file to write, and the cache folder if it is given."""

    name: str
    out: Path
    cache: str | None


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ) -> int:
    """Packs the bundle and returns the exit status.

    ConfigError for wrong usage or an unknown build; CacheError where the cache no longer has the inputs of
    the build; OutputError where the build read nothing or the file cannot be written; SecretFound where
    the inputs hold an API key.
    """
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.output.builds import find

    asked = parse(arguments)
    folder = find(asked.name, "bundle")
    _check_place(asked.out)
    manifest = _manifest(folder)
    data, replies = _packed(folder, manifest, asked, environ)
    _write(asked.out, data)
    say(
        f"{asked.out}: {count(replies, 'reply', 'replies')}, {len(data) / 1e6:.2f} MB: all inputs of {folder}"
    )
    say(f"  → linkwright source=bundle {pasted.override('source.path', str(asked.out))}")
    return 0


def parse(arguments: Sequence[str]) -> Request:
    """Parses the arguments; ConfigError for missing or unknown arguments."""
    places = [argument for argument in arguments if not argument.startswith((_CACHE, "-"))]
    options = [argument for argument in arguments if argument.startswith("-")]
    caches = [argument.removeprefix(_CACHE) for argument in arguments if argument.startswith(_CACHE)]
    if options:
        msg = f"there is no option {options[0]}"
        raise ConfigError(msg, "bundle", _USAGE)
    if len(places) != 2:
        msg = f"expected a build and the file to write, got {count(len(places), 'argument')}"
        raise ConfigError(msg, "bundle", _USAGE)
    if caches and not caches[-1]:
        msg = "expected a folder"
        raise ConfigError(msg, "cache.dir", _USAGE)
    return Request(places[0], Path(places[1]), caches[-1] if caches else None)


def _check_place(out: Path) -> None:
    if not out.parent.is_dir():
        msg = f"{out} cannot be written: there is no folder {out.parent}"
        raise ConfigError(msg, "bundle", "make the folder, or choose another place")
    if out.exists() and not _is_older_bundle(out):
        msg = f"{out} exists and is not a bundle"
        raise ConfigError(msg, "bundle", "choose another name: only an older bundle is replaced")


def _is_older_bundle(out: Path) -> bool:
    # Late: the help of the verb needs none of it.
    from linkwright.stages.fetch.bundle.archive import is_bundle

    return out.is_file() and is_bundle(out)


def _manifest(folder: Path) -> str:
    """The digest of the build's inputs, from its report; OutputError where it read nothing."""
    report = json.loads((folder / "report.json").read_bytes())
    bundle = report.get("bundle")
    manifest = bundle.get("manifest") if isinstance(bundle, dict) else None
    if not isinstance(manifest, str):
        msg = "its report names no bundle: the build ended before everything was fetched"
        raise OutputError(msg, str(folder), "build it again; replies that were fetched are kept")
    return manifest


def _packed(folder: Path, manifest: str, asked: Request, environ: Mapping[str, str]) -> tuple[bytes, int]:
    """The zip's bytes and how many replies it holds."""
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.caching.actions import Cache
    from linkwright.pipeline.caching.bundles import named, recall
    from linkwright.pipeline.caching.store import Store
    from linkwright.pipeline.secrets import Secrets
    from linkwright.stages.fetch.bundle.archive import pack, read

    roots = _caches(folder, asked.cache, environ)
    for root in roots:
        bundle = recall(Cache(Store(root)), manifest) if root.is_dir() else None
        if bundle is not None:
            Secrets(environ).check(named(bundle))
            data = pack(bundle)
            # Read it back, so that a bundle that is too large fails here.
            return data, len(read(data, str(asked.out)).blobs)
    msg = f"the cache lacks inputs of {folder}"
    hint = (
        "build it again without cache.mode=bypass (only missing replies are fetched), or name the "
        "cache folder that the build used: cache.dir=FOLDER"
    )
    raise CacheError(msg, ", ".join(str(root) for root in roots), hint)


def _caches(folder: Path, named: str | None, environ: Mapping[str, str]) -> list[Path]:
    """The cache folders to search: the given folder, else the build's, then the default folder."""
    # Late: the help of the verb needs none of it.
    from linkwright.pipeline.caching.actions import folder as cache_folder

    wanted = [named] if named else [_configured(folder), None]
    return list(dict.fromkeys(cache_folder(one, environ) for one in wanted))


def _configured(folder: Path) -> str | None:
    """The key `cache.dir` of the build, if it had one."""
    # Late: the help of the verb needs none of it.
    import yaml

    from linkwright.pipeline.config.files import yaml_file

    try:
        plan: Any = yaml_file.read(folder / "config.yaml")
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return None
    cache = plan.get("cache") if isinstance(plan, dict) else None
    configured = cache.get("dir") if isinstance(cache, dict) else None
    return configured if isinstance(configured, str) else None


def _write(out: Path, data: bytes) -> None:
    """Writes the file atomically; OutputError where that fails. A link stands for its target, and an older
    bundle's mode and owner stay."""
    temporary = ""
    out = out.resolve() if out.is_symlink() else out
    try:
        with tempfile.NamedTemporaryFile(dir=out.parent, prefix=f".{out.name}.", delete=False) as file:
            temporary = file.name
            file.write(data)
        Path(temporary).chmod(0o644)
        access.copy(out, Path(temporary))
        Path(temporary).replace(out)
    except OSError as error:
        with contextlib.suppress(OSError):
            Path(temporary).unlink()
        msg = f"the bundle cannot be written: {error.strerror or error}"
        raise OutputError(msg, str(out), "choose another place, or free space there") from error
