"""Composes trees with Hydra's defaults lists, and notes the files of each.

Hydra makes its own node and the defaults list anew for each tree, which takes most of the time. Here what
the choices of options lead to is kept while Hydra is initialized, and a tree is a copy of it with values.
"""

import copy
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from hydra import __version__, version
from hydra._internal import defaults_list
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.config_repository import ConfigRepository, IConfigRepository
from hydra.conf import ConfigSourceInfo
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.default_element import ResultDefault
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import ConfigCompositionException
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config.files.reach import OutsideError, is_plain
from linkwright.pipeline.config.hydra.files import Guarded

PRIMARY = "build"

SEARCHPATH = "hydra.searchpath="

_NODE = "/hydra/"
"""The path by which the merged files of Hydra's own node are one file; no path of Hydra begins so."""

_LOADED: dict[str, ConfigResult] = {}
"""Files that are installed, by their paths: the same for all trees of a process."""

_NODES: dict[tuple[tuple[str, str], ...], DictConfig] = {}
"""Hydra's own node, merged of installed files, by their paths and packages."""


@lru_cache(maxsize=4096)
def parsed(override: str) -> Override:
    """An override, read by Hydra's parser; its exceptions where it cannot be read."""
    return OverridesParser.create().parse_override(override)


class Repository(ConfigRepository):
    """Hydra's files, without those outside the folders of the search path; each is loaded once.

    `is_of_conf`: no file of a user is among them.
    """

    is_of_conf = False

    def initialize_sources(self, config_search_path: ConfigSearchPath) -> None:
        super().initialize_sources(config_search_path)
        guarded = [source for source in self.sources if isinstance(source, Guarded)]
        folders = tuple(source.folder for source in guarded)
        for source in guarded:
            source.folders = folders
        self._loaded: dict[str, ConfigResult] = {}

    def is_installed(self, config_path: str) -> bool:
        """Whether a file is no user's."""
        source = self._find_object_source(config_path, ObjectType.CONFIG)
        if not isinstance(source, Guarded):
            return source is not None
        place = source.file(config_path)
        return place is not None and source.installed(place)

    def load_config(self, config_path: str) -> ConfigResult | None:
        loaded = _LOADED if self.is_installed(config_path) else self._loaded
        if config_path not in loaded:
            found = super().load_config(config_path)
            if found is None:
                return None
            loaded[config_path] = found
        return loaded[config_path]

    def _find_object_source(self, config_path: str, object_type: ObjectType | None) -> ConfigSource | None:
        if is_plain(config_path):
            return super()._find_object_source(config_path, object_type)
        inside = [source for source in self.sources if isinstance(source, Guarded) and source.at(config_path)]
        if not inside:
            raise OutsideError(config_path)
        for source in inside:
            if (
                source.is_config(config_path)
                if object_type == ObjectType.CONFIG
                else source.is_group(config_path)
            ):
                return source
        return None


@dataclass(frozen=True, slots=True)
class ChosenTree:
    """What the choices of options lead to: a tree without the values of the command line, and the files of
    it. `typed`: those of the choices that set values too, such as `~joints`."""

    config: DictConfig
    files: Mapping[str, Any]
    typed: frozenset[str]


class Loader(ConfigLoaderImpl):
    """Hydra's loader; `files` are those of the last base by their paths, in the order of their merge: each
    as the part of the tree that it sets, None for those of Hydra itself."""

    files: Mapping[str, Any] = {}

    def __init__(self, config_search_path: ConfigSearchPath) -> None:
        super().__init__(config_search_path)
        self.repository = Repository(config_search_path)
        self._repositories: dict[tuple[str, ...], Repository] = {}
        self._bases: dict[tuple[str, ...], ChosenTree] = {}

    def composed(self, overrides: Sequence[str]) -> tuple[DictConfig, Mapping[str, Any]]:
        """As `composed` below."""
        typed = [parsed(override) for override in overrides]
        repository = self._searching(tuple(text for text in overrides if text.startswith(SEARCHPATH)))
        values = [one for one in typed if _is_value(one, repository)]
        choices = tuple(one.input_line or "" for one in typed if one not in values)
        base = _of_conf(choices) if repository.is_of_conf else self.base(choices, repository)
        config = copy.deepcopy(base.config)
        set_too = [one for one in typed if one in values or one.input_line in base.typed]
        ConfigLoaderImpl._apply_overrides_to_config(set_too, config)
        lines = config.hydra.overrides
        for one in typed:
            (lines.hydra if one.is_hydra_override() else lines.task).append(one.input_line)
        config.hydra.runtime.cwd = os.getcwd()  # noqa: PTH109
        # Hydra 1.4 has an interpolation there.
        if OmegaConf.is_missing(config.hydra.job, "override_dirname"):
            config.hydra.job.override_dirname = ",".join(sorted(lines.task))
        return config, base.files

    def _searching(self, searchpath: tuple[str, ...]) -> Repository:
        """The files that this override of the search path leads to."""
        if searchpath not in self._repositories:
            repository: Any = Repository(self.config_search_path)
            self._process_config_searchpath(PRIMARY, list(map(parsed, searchpath)), repository)
            repository.is_of_conf = not searchpath
            self._repositories[searchpath] = repository
        return self._repositories[searchpath]

    def base(self, choices: tuple[str, ...], repository: Repository) -> ChosenTree:
        """What these choices lead to."""
        if choices not in self._bases:
            self._bases[choices] = self.new_base(choices, repository)
        return self._bases[choices]

    def new_base(self, choices: tuple[str, ...], repository: Repository | None = None) -> ChosenTree:
        """What these choices lead to, composed anew; without a `repository` of the files of `conf`."""
        repository = repository or self._searching(())
        listed = defaults_list.create_defaults_list(
            repository, PRIMARY, list(map(parsed, choices)), prepend_hydra=True, skip_missing=False
        )
        config = self._compose_config_from_defaults_list(defaults=listed.defaults, repo=repository)
        OmegaConf.set_struct(config, True)
        OmegaConf.set_struct(config.hydra.runtime.choices, False)
        runtime = config.hydra.runtime
        runtime.choices.update(listed.overrides.known_choices)
        runtime.version, runtime.version_base = __version__, version.getbase()
        runtime.config_sources = [
            ConfigSourceInfo(path=source.path, schema=source.scheme(), provider=source.provider)
            for source in repository.get_sources()
        ]
        config.hydra.job.config_name = PRIMARY
        typed = frozenset(override.input_line or "" for override in listed.config_overrides)
        return ChosenTree(config, self.files, typed)

    def _compose_config_from_defaults_list(
        self, defaults: list[ResultDefault], repo: IConfigRepository
    ) -> DictConfig:
        own = [default for default in defaults if _path(default).startswith("hydra/")]
        others = [default for default in defaults if default not in own]
        self.files = {_path(default): None for default in defaults}
        self._node = self._merged(own, repo)
        merged = [ResultDefault(config_path=_NODE), *others]
        return super()._compose_config_from_defaults_list(defaults=merged, repo=repo)

    def _merged(self, defaults: list[ResultDefault], repo: IConfigRepository) -> DictConfig:
        """The node `hydra` of Hydra's own files."""
        key = tuple((_path(default), default.package or "") for default in defaults)
        is_installed = isinstance(repo, Repository) and all(repo.is_installed(path) for path, _ in key)
        nodes = _NODES if is_installed else {}
        if key not in nodes:
            nodes[key] = super()._compose_config_from_defaults_list(defaults=defaults, repo=repo)
        return nodes[key]

    def _load_single_config(self, default: ResultDefault, repo: IConfigRepository) -> ConfigResult:
        path = _path(default)
        if path == _NODE:
            return ConfigResult("hydra", path, copy.deepcopy(self._node), {})
        loaded = copy.copy(super()._load_single_config(default, repo))
        if not default.package:
            # Not embedded, so no copy yet: Hydra merges later files into the nodes of earlier ones.
            loaded.config = copy.deepcopy(loaded.config)
        if not path.startswith("hydra/"):
            self.files = {**self.files, path: OmegaConf.to_container(loaded.config, resolve=False)}
        return loaded


def _is_value(override: Override, repository: Repository) -> bool:
    """Whether an override sets a value, and chooses no option."""
    is_group = not isinstance(override.value(), dict) and repository.group_exists(override.key_or_group)
    return bool(override.is_force_add()) and not is_group


def _path(default: ResultDefault) -> str:
    return default.config_path or ""


@lru_cache(maxsize=64)
def _of_conf(choices: tuple[str, ...]) -> ChosenTree:
    """What these choices lead to without files of a user: the same for all builds of a process."""
    return _loader().new_base(choices)


def _loader() -> Loader:
    loader = GlobalHydra.instance().config_loader()
    assert isinstance(loader, Loader)
    return loader


def use_loader() -> None:
    """Gives Hydra, which must be initialized, a `Loader`."""
    hydra = GlobalHydra.instance().hydra
    assert hydra is not None
    hydra.config_loader = Loader(hydra.config_loader.get_search_path())


def composed(overrides: Sequence[str]) -> tuple[DictConfig, Mapping[str, Any]]:
    """The tree of `build` with its `hydra` node, and its files by their paths in the search path: each as the
    part of the tree that it sets."""
    try:
        return _loader().composed(overrides)
    except OmegaConfBaseException as error:
        raise ConfigCompositionException from error


_MAP = "_create_interpolation_map"


@contextmanager
def swift() -> Iterator[None]:
    """Inside, Hydra 1.3 gathers what interpolations of a defaults list may name only for a list that has
    one: else that takes half of the time of a defaults list."""
    gather: Callable[..., Any] | None = getattr(defaults_list, _MAP, None)
    if gather is None:
        yield
        return

    def gathered(overrides: Any, defaults: Any, self_added: bool) -> Any:
        needed = any(default.is_interpolation() for default in defaults if not default.is_self())
        return gather(overrides, defaults, self_added) if needed else None

    setattr(defaults_list, _MAP, gathered)
    try:
        yield
    finally:
        setattr(defaults_list, _MAP, gather)


@contextmanager
def aside() -> Iterator[None]:
    """Sets aside the Hydra instance of a calling program that itself runs under Hydra."""
    theirs = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        yield
    finally:
        GlobalHydra.instance().hydra = theirs
