"""Reads files for Hydra: each text is parsed once, and users' files and interpolations have limits.

Hydra reads any file, parses it again for each composition, and OmegaConf resolves an interpolation again
wherever it is used: ten lines of `${a}${a}...` expand as far as ten lines of aliases.
"""

import copy
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

from hydra._internal.core_plugins import file_config_source, importlib_resources_config_source
from hydra._internal.sources_registry import SourcesRegistry
from hydra.errors import ConfigCompositionException
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf
from omegaconf.base import Container
from omegaconf.errors import InterpolationResolutionError

from linkwright.pipeline import observed
from linkwright.pipeline.config.files import reach, yaml_file

MAX_INTERPOLATIONS = 2000
"""Largest number of interpolations that a value may resolve."""

MAX_CHARACTERS = 1 << 20
"""Largest number of characters in the results of a value's interpolations."""

_RESOLVE_METHOD = "_maybe_resolve_interpolation"
_EVALUATE_METHOD = "_evaluate_custom_resolver"

_ENVIRONMENT_RESOLVER = "oc.env"
_PURE_RESOLVERS = (
    "hydra", "oc.coerce", "oc.create", "oc.decode", "oc.deprecated", "oc.dict.keys", "oc.dict.values",
    "oc.select",
)  # fmt: skip
"""Resolvers whose value depends only on the configuration and on the program."""


class GuardedSource(ConfigSource):
    """A source of files in a folder, which reads no file outside `folders`, the folders of the search path.

    Hydra's own sources join any path to their folder.
    """

    folders: Sequence[Path] = ()

    @property
    def folder(self) -> Path:
        raise NotImplementedError

    def at(self, config_path: str) -> Path | None:
        """Returns the path of a file or folder, or None if it is outside."""
        return reach.place(self.folder, config_path, self.folders)

    def is_group(self, config_path: str) -> bool:
        place = self.at(config_path)
        return place is not None and (
            place.is_dir() if self.is_installed(place) else observed.is_folder(place)
        )

    def file(self, config_path: str) -> Path | None:
        """Returns the path of a file, or None if it is outside."""
        return self.at(self._normalize_file_name(config_path))

    def is_config(self, config_path: str) -> bool:
        place = self.file(config_path)
        return place is not None and (
            place.is_file() if self.is_installed(place) else observed.is_file(place)
        )

    def load_config(self, config_path: str) -> ConfigResult:
        place = self.file(config_path)
        if place is None or not place.exists():
            msg = f"no such file: {config_path}"
            raise ConfigLoadError(msg)
        if self.is_installed(place):
            return _config_result(self, str(place), place.read_text(encoding="utf-8"))
        result = _config_result(self, str(observed.real_path(place)), yaml_file.text(place))
        _check_override_order(result.config, config_path.removesuffix(".yaml"))
        return result

    def is_installed(self, place: Path) -> bool:
        """Tells whether a file is part of the installation, so that it needs no check."""
        return False


# The classes have the names of Hydra's classes: Hydra registers its own repeatedly, and skips an equal name.


class FileConfigSource(GuardedSource, file_config_source.FileConfigSource):
    """Hydra's source of files in folders, which checks each file first."""

    @property
    def folder(self) -> Path:
        return Path(self.path)


class ImportlibResourcesConfigSource(
    GuardedSource, importlib_resources_config_source.ImportlibResourcesConfigSource
):
    """Hydra's source of files in packages, which also finds a robot's file by its path."""

    @property
    def folder(self) -> Path:
        return _package_folder(self.path)

    def is_installed(self, place: Path) -> bool:
        return place.is_relative_to(self.folder)


@lru_cache(maxsize=8)
def _package_folder(name: str) -> Path:
    return Path(str(resources.files(name))).resolve()


def _config_result(source: ConfigSource, name: str, text: str) -> ConfigResult:
    config, header = _parsed(name, text)
    # A copy, since Hydra removes the defaults list from the result.
    copied = copy.deepcopy(config)
    return ConfigResult(source.provider, f"{source.scheme()}://{source.path}", copied, dict(header))


def _check_override_order(config: Container, name: str) -> None:
    """Raises ConfigCompositionException if an override precedes another entry of a file's defaults list.

    Hydra 1.3 and 1.4 find this too, but fail to report it if the override chooses several options.
    """
    plain = OmegaConf.to_container(config, resolve=False)
    defaults = plain.get("defaults") if isinstance(plain, dict) else None
    overridden = ""
    for entry in defaults if isinstance(defaults, list) else ():
        text = " ".join(map(str, entry)) if isinstance(entry, dict) else str(entry)
        if text.startswith("override "):
            overridden = text.removeprefix("override ")
        elif overridden and text != "_self_":
            raise ConfigCompositionException(
                f"In {name}: Override '{overridden}' is defined before '{text}'."
            )


@lru_cache(maxsize=64)
def _parsed(name: str, text: str) -> tuple[Container, dict[str, str | None]]:
    """Returns the content and the header of a file; errors name the file."""
    stream = io.StringIO(text, newline=None)
    header = ConfigSource._get_header_dict(stream.read(512))
    stream.seek(0)
    stream.name = name
    yaml_file.require_mapping(text, name)
    return OmegaConf.load(stream), header


def _is_in_hydra_node(node: Any) -> bool:
    """Tells whether a node is in Hydra's own configuration, such as folders named after the time."""
    return node is not None and f"{node._get_full_key(None)}.".startswith("hydra.")


@contextmanager
def guarded_reading() -> Iterator[None]:
    """Makes Hydra read files through the sources above while the block runs. Interpolations are counted, and
    the values that they read outside of the configuration are recorded."""
    sources = SourcesRegistry.instance().types
    original_sources = dict(sources)
    sources |= {kind.scheme(): kind for kind in (FileConfigSource, ImportlibResourcesConfigSource)}
    resolve: Callable[..., Any] = getattr(Container, _RESOLVE_METHOD)
    depth = count = characters = 0
    outermost: Any = None

    def resolve_with_count(self: Container, *args: Any, **options: Any) -> Any:
        nonlocal depth, count, characters, outermost
        if not depth:
            count = characters = 0
            outermost = options.get("value")
        depth += 1
        try:
            count += 1
            if count > MAX_INTERPOLATIONS or characters > MAX_CHARACTERS:
                msg = "its interpolations expand to more than is allowed"
                raise InterpolationResolutionError(msg)
            resolved = resolve(self, *args, **options)
            value = None if resolved is None else resolved._value()
            characters += len(value) if isinstance(value, str) else 0
            return resolved
        finally:
            depth -= 1

    evaluate: Callable[..., Any] = getattr(Container, _EVALUATE_METHOD)

    def evaluate_with_record(
        self: Container, *, inter_type: str, inter_args: Sequence[Any], **options: Any
    ) -> Any:
        if inter_type == _ENVIRONMENT_RESOLVER and inter_args:
            observed.record_variable(str(inter_args[0]))
        elif inter_type not in _PURE_RESOLVERS and depth and not _is_in_hydra_node(outermost):
            # At depth 0 files are merged: the value is resolved again where it is used.
            observed.record_momentary_value()
        return evaluate(self, inter_type=inter_type, inter_args=inter_args, **options)

    setattr(Container, _RESOLVE_METHOD, resolve_with_count)
    setattr(Container, _EVALUATE_METHOD, evaluate_with_record)
    try:
        yield
    finally:
        setattr(Container, _RESOLVE_METHOD, resolve)
        setattr(Container, _EVALUATE_METHOD, evaluate)
        sources |= original_sources
