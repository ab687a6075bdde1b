"""Composes trees with Hydra's defaults lists, and notes the files of each.

Hydra composes its own node and the defaults list again for each tree, which takes most of the time. Here the
tree of each choice of options is cached while Hydra is initialized; a result is a copy of it, with values
set.
"""

import copy
import os
import pickle
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

from linkwright.pipeline.config.files.reach import OutsideError, is_inside
from linkwright.pipeline.config.hydra.files import GuardedSource

PRIMARY = "build"

SEARCHPATH_PREFIX = "hydra.searchpath="

_HYDRA_NODE_PATH = "/hydra/"
"""The path that the merged files of Hydra's own node get, as if they were a single file. Hydra's paths never
begin with a slash."""

_INSTALLED_FILES: dict[str, ConfigResult] = {}
"""Installed files by their paths: the same for all trees of a process."""

_HYDRA_NODES: dict[tuple[tuple[str, str], ...], DictConfig] = {}
"""Hydra's own node, merged from installed files, by their paths and packages."""


@lru_cache(maxsize=4096)
def parsed(override: str) -> Override:
    """Returns an override, read by Hydra's parser; raises Hydra's exceptions if it is invalid."""
    return OverridesParser.create().parse_override(override)


class Repository(ConfigRepository):
    """Hydra's repository of files, without files outside the search path; each file is loaded once.

    `has_only_conf`: whether the search path has no folder of the user.
    """

    has_only_conf = False

    def initialize_sources(self, config_search_path: ConfigSearchPath) -> None:
        super().initialize_sources(config_search_path)
        guarded = [source for source in self.sources if isinstance(source, GuardedSource)]
        folders = tuple(source.folder for source in guarded)
        for source in guarded:
            source.folders = folders
        self._loaded: dict[str, ConfigResult] = {}

    def is_installed(self, config_path: str) -> bool:
        """Tells whether a file is part of the installation."""
        source = self._find_object_source(config_path, ObjectType.CONFIG)
        if not isinstance(source, GuardedSource):
            return source is not None
        place = source.file(config_path)
        return place is not None and source.is_installed(place)

    def load_config(self, config_path: str) -> ConfigResult | None:
        loaded = _INSTALLED_FILES if self.is_installed(config_path) else self._loaded
        if config_path not in loaded:
            result = super().load_config(config_path)
            if result is None:
                return None
            loaded[config_path] = result
        return loaded[config_path]

    def _find_object_source(self, config_path: str, object_type: ObjectType | None) -> ConfigSource | None:
        if is_inside(config_path):
            return super()._find_object_source(config_path, object_type)
        containing_sources = [
            source for source in self.sources if isinstance(source, GuardedSource) and source.at(config_path)
        ]
        if not containing_sources:
            raise OutsideError(config_path)
        for source in containing_sources:
            if (
                source.is_config(config_path)
                if object_type == ObjectType.CONFIG
                else source.is_group(config_path)
            ):
                return source
        return None


@dataclass(frozen=True, slots=True)
class ChosenTree:
    """The tree that follows from choices of options, without the values of the command line."""

    pickled: bytes
    """The tree; to copy it by pickle is five times as fast."""
    files: Mapping[str, Any]
    """Its files by their paths (see `Loader`)."""
    typed: frozenset[str]
    """The choices that also set values, such as `~joints`."""


class Loader(ConfigLoaderImpl):
    """Hydra's loader, which caches trees of choices.

    `files`: the files of the last tree by their paths, in the order of their merge: each as the part of the
    tree that it sets, None for Hydra's own.
    """

    files: Mapping[str, Any] = {}

    def __init__(self, config_search_path: ConfigSearchPath) -> None:
        super().__init__(config_search_path)
        self.repository = Repository(config_search_path)
        self._repositories: dict[tuple[str, ...], Repository] = {}
        self._bases: dict[tuple[str, ...], ChosenTree] = {}

    def composed(self, overrides: Sequence[str]) -> tuple[DictConfig, Mapping[str, Any]]:
        """Composes a tree, as the function `composed` describes."""
        parsed_overrides = [parsed(override) for override in overrides]
        repository = self._repository_of(
            tuple(text for text in overrides if text.startswith(SEARCHPATH_PREFIX))
        )
        values = [override for override in parsed_overrides if _is_value(override, repository)]
        choices = tuple(override.input_line or "" for override in parsed_overrides if override not in values)
        base = _conf_tree(choices) if repository.has_only_conf else self.base(choices, repository)
        config = pickle.loads(base.pickled)
        setting_overrides = [
            override
            for override in parsed_overrides
            if override in values or override.input_line in base.typed
        ]
        ConfigLoaderImpl._apply_overrides_to_config(setting_overrides, config)
        lines = config.hydra.overrides
        for override in parsed_overrides:
            (lines.hydra if override.is_hydra_override() else lines.task).append(override.input_line)
        config.hydra.runtime.cwd = os.getcwd()  # noqa: PTH109
        # Hydra 1.4 has an interpolation there.
        if OmegaConf.is_missing(config.hydra.job, "override_dirname"):
            config.hydra.job.override_dirname = ",".join(sorted(lines.task))
        return config, base.files

    def _repository_of(self, searchpath: tuple[str, ...]) -> Repository:
        """Returns the repository for overrides of the search path."""
        if searchpath not in self._repositories:
            repository: Any = Repository(self.config_search_path)
            self._process_config_searchpath(PRIMARY, list(map(parsed, searchpath)), repository)
            repository.has_only_conf = not searchpath
            self._repositories[searchpath] = repository
        return self._repositories[searchpath]

    def base(self, choices: tuple[str, ...], repository: Repository) -> ChosenTree:
        """Returns the tree of choices of options, cached."""
        if choices not in self._bases:
            self._bases[choices] = self.new_base(choices, repository)
        return self._bases[choices]

    def new_base(self, choices: tuple[str, ...], repository: Repository | None = None) -> ChosenTree:
        """Composes the tree of choices of options; by default from the files of `conf`."""
        repository = repository or self._repository_of(())
        defaults_result = defaults_list.create_defaults_list(
            repository, PRIMARY, list(map(parsed, choices)), prepend_hydra=True, skip_missing=False
        )
        config = self._compose_config_from_defaults_list(defaults=defaults_result.defaults, repo=repository)
        OmegaConf.set_struct(config, True)
        OmegaConf.set_struct(config.hydra.runtime.choices, False)
        runtime = config.hydra.runtime
        runtime.choices.update(defaults_result.overrides.known_choices)
        runtime.version, runtime.version_base = __version__, version.getbase()
        runtime.config_sources = [
            ConfigSourceInfo(path=source.path, schema=source.scheme(), provider=source.provider)
            for source in repository.get_sources()
        ]
        config.hydra.job.config_name = PRIMARY
        typed = frozenset(override.input_line or "" for override in defaults_result.config_overrides)
        return ChosenTree(pickle.dumps(config), self.files, typed)

    def _compose_config_from_defaults_list(
        self, defaults: list[ResultDefault], repo: IConfigRepository
    ) -> DictConfig:
        hydra_defaults = [default for default in defaults if _path(default).startswith("hydra/")]
        remaining = [default for default in defaults if default not in hydra_defaults]
        self.files = {_path(default): None for default in defaults}
        self._node = self._merged(hydra_defaults, repo)
        merged = [ResultDefault(config_path=_HYDRA_NODE_PATH), *remaining]
        return super()._compose_config_from_defaults_list(defaults=merged, repo=repo)

    def _merged(self, defaults: list[ResultDefault], repo: IConfigRepository) -> DictConfig:
        """Returns the node `hydra`, merged from Hydra's own files."""
        key = tuple((_path(default), default.package or "") for default in defaults)
        is_installed = isinstance(repo, Repository) and all(repo.is_installed(path) for path, _ in key)
        nodes = _HYDRA_NODES if is_installed else {}
        if key not in nodes:
            nodes[key] = super()._compose_config_from_defaults_list(defaults=defaults, repo=repo)
        return nodes[key]

    def _load_single_config(self, default: ResultDefault, repo: IConfigRepository) -> ConfigResult:
        path = _path(default)
        if path == _HYDRA_NODE_PATH:
            return ConfigResult("hydra", path, copy.deepcopy(self._node), {})
        loaded = copy.copy(super()._load_single_config(default, repo))
        if not default.package:
            # Not embedded, hence not a copy yet: Hydra merges later files into the nodes of earlier files.
            loaded.config = copy.deepcopy(loaded.config)
        if not path.startswith("hydra/"):
            self.files = {**self.files, path: OmegaConf.to_container(loaded.config, resolve=False)}
        return loaded


def _is_value(override: Override, repository: Repository) -> bool:
    """Tells whether an override sets a value, and does not choose an option."""
    is_group = not isinstance(override.value(), dict) and repository.group_exists(override.key_or_group)
    return bool(override.is_force_add()) and not is_group


def _path(default: ResultDefault) -> str:
    return default.config_path or ""


@lru_cache(maxsize=64)
def _conf_tree(choices: tuple[str, ...]) -> ChosenTree:
    """Returns the tree of choices of options without files of the user, which is the same for all builds of a
    process."""
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
    """Composes the tree of `build` with its `hydra` node. Also returns its files by their paths in the search
    path, each as the part of the tree that it sets."""
    try:
        return _loader().composed(overrides)
    except OmegaConfBaseException as error:
        raise ConfigCompositionException from error


_GATHER_FUNCTION = "_create_interpolation_map"


@contextmanager
def speed_up() -> Iterator[None]:
    """Speeds up Hydra 1.3 while the block runs: targets of interpolations are gathered only for defaults
    lists with an interpolation. For other lists this would take half of the time, without effect."""
    gather: Callable[..., Any] | None = getattr(defaults_list, _GATHER_FUNCTION, None)
    if gather is None:
        yield
        return

    def gathered(overrides: Any, defaults: Any, self_added: bool) -> Any:
        needed = any(default.is_interpolation() for default in defaults if not default.is_self())
        return gather(overrides, defaults, self_added) if needed else None

    setattr(defaults_list, _GATHER_FUNCTION, gathered)
    try:
        yield
    finally:
        setattr(defaults_list, _GATHER_FUNCTION, gather)


@contextmanager
def set_aside() -> Iterator[None]:
    """Sets aside the Hydra instance of a calling program, which may itself run under Hydra."""
    caller_hydra = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        yield
    finally:
        GlobalHydra.instance().hydra = caller_hydra
