"""Packs the inputs of a build from the cache into a bundle."""

import contextlib
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from linkwright.pipeline.caching.actions import Cache
from linkwright.pipeline.caching.actions import folder as cache_folder
from linkwright.pipeline.caching.bundles import readable_files, recall
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.config.files import yaml_file
from linkwright.pipeline.errors import CacheError, ConfigError, OutputError
from linkwright.pipeline.output import access
from linkwright.pipeline.output.builds import find
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.fetch.bundle.archive import is_bundle, pack, read


def pack_build(
    name: str, out: Path, cache: str | None, environ: Mapping[str, str]
) -> tuple[Path, bytes, int]:
    """Returns the folder of a build, the zip's bytes, and the number of replies in it.

    `name`: the name of the robot, or the output folder; `cache`: the cache folder, or None for the usual
    ones. Raises ConfigError for an unknown build, or if `out` must not be replaced; CacheError if the cache
    no longer has the inputs of the build; OutputError if the build read nothing; SecretFound if the inputs
    contain an API key.
    """
    folder = find(name, "bundle")
    _require_free(out)
    manifest = _manifest_digest(folder)
    roots = _cache_folders(folder, cache, environ)
    for root in roots:
        bundle = recall(Cache(Store(root)), manifest) if root.is_dir() else None
        if bundle is not None:
            Secrets(environ).check(readable_files(bundle))
            data = pack(bundle)
            # Read it back, so that a bundle that is too large fails here.
            return folder, data, len(read(data, str(out)).blobs)
    msg = f"the cache lacks inputs of {folder}"
    hint = (
        "build it again without cache.mode=bypass (only missing replies are fetched), or name the "
        "cache folder that the build used: cache.dir=FOLDER"
    )
    raise CacheError(msg, ", ".join(str(root) for root in roots), hint)


def _require_free(out: Path) -> None:
    if not out.parent.is_dir():
        msg = f"{out} cannot be written: there is no folder {out.parent}"
        raise ConfigError(msg, "bundle", "make the folder, or choose another place")
    if out.exists() and not (out.is_file() and is_bundle(out)):
        msg = f"{out} exists and is not a bundle"
        raise ConfigError(msg, "bundle", "choose another name: only an older bundle is replaced")


def _manifest_digest(folder: Path) -> str:
    """Returns the digest of the build's inputs, from its report; raises OutputError if it read nothing."""
    report = json.loads((folder / "report.json").read_bytes())
    bundle = report.get("bundle")
    manifest = bundle.get("manifest") if isinstance(bundle, dict) else None
    if not isinstance(manifest, str):
        msg = "its report names no bundle: the build ended before everything was fetched"
        raise OutputError(msg, str(folder), "build it again; replies that were fetched are kept")
    return manifest


def _cache_folders(folder: Path, named_cache: str | None, environ: Mapping[str, str]) -> list[Path]:
    """Returns the cache folders to search: the given folder, else the build's, then the default folder."""
    candidates = [named_cache] if named_cache else [_configured_cache(folder), None]
    return list(dict.fromkeys(cache_folder(place, environ) for place in candidates))


def _configured_cache(folder: Path) -> str | None:
    """Returns the key `cache.dir` of the build, if it had one."""
    try:
        plan: Any = yaml_file.read(folder / "config.yaml")
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return None
    cache = plan.get("cache") if isinstance(plan, dict) else None
    configured = cache.get("dir") if isinstance(cache, dict) else None
    return configured if isinstance(configured, str) else None


def write(out: Path, data: bytes) -> None:
    """Writes the file atomically; raises OutputError if that fails. It follows a link, and keeps the mode and
    the owner of an older bundle."""
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
