"""Composes trees with Hydra, and notes the files of each.

Hydra tells a tree without its files; its public way to the files computes the whole defaults list again,
which takes more than half as long as the composition.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from hydra import compose
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.config_repository import ConfigRepository, IConfigRepository
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.default_element import ResultDefault
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import DictConfig, OmegaConf

from pipeline.config.hydra_files import Guarded
from pipeline.config.reach import OutsideError, is_plain

PRIMARY = "build"


class Repository(ConfigRepository):
    """Hydra's files, without those outside the folders of the search path."""

    def initialize_sources(self, config_search_path: ConfigSearchPath) -> None:
        super().initialize_sources(config_search_path)
        guarded = [source for source in self.sources if isinstance(source, Guarded)]
        folders = tuple(source.folder for source in guarded)
        for source in guarded:
            source.folders = folders

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


class Loader(ConfigLoaderImpl):
    """Hydra's loader; `files` are those of the last composition by their paths, in the order of their merge:
    each as the part of the tree that it sets, None for those of Hydra itself."""

    files: Mapping[str, Any] = {}

    def __init__(self, config_search_path: ConfigSearchPath) -> None:
        super().__init__(config_search_path)
        self.repository = Repository(config_search_path)

    def _compose_config_from_defaults_list(
        self, defaults: list[ResultDefault], repo: IConfigRepository
    ) -> DictConfig:
        self.files = {default.config_path or "": None for default in defaults}
        return super()._compose_config_from_defaults_list(defaults=defaults, repo=repo)

    def _load_single_config(self, default: ResultDefault, repo: IConfigRepository) -> ConfigResult:
        loaded = super()._load_single_config(default, repo)
        path = default.config_path or ""
        if not path.startswith("hydra/"):
            # A copy: Hydra merges later files into the nodes of earlier ones.
            self.files = {**self.files, path: OmegaConf.to_container(loaded.config, resolve=False)}
        return loaded


def use_loader() -> None:
    """Gives Hydra, which must be initialized, a `Loader`."""
    hydra = GlobalHydra.instance().hydra
    assert hydra is not None
    hydra.config_loader = Loader(hydra.config_loader.get_search_path())


def composed(overrides: Sequence[str]) -> tuple[DictConfig, Mapping[str, Any]]:
    """The tree of `build` with its `hydra` node, and its files by their paths in the search path: each as the
    part of the tree that it sets."""
    config = compose(PRIMARY, list(overrides), return_hydra_config=True)
    loader = GlobalHydra.instance().config_loader()
    assert isinstance(loader, Loader)
    return config, loader.files


@contextmanager
def aside() -> Iterator[None]:
    """Sets aside the Hydra instance of a calling program that itself runs under Hydra."""
    theirs = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        yield
    finally:
        GlobalHydra.instance().hydra = theirs
