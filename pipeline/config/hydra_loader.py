"""Composes trees with Hydra, and notes the files of each.

Hydra tells a tree without its files; its public way to the files computes the whole defaults list again,
which takes more than half as long as the composition.
"""

from collections.abc import Sequence

from hydra import compose
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.config_repository import IConfigRepository
from hydra.core.default_element import ResultDefault
from hydra.core.global_hydra import GlobalHydra
from omegaconf import DictConfig

PRIMARY = "build"


class Loader(ConfigLoaderImpl):
    """Hydra's loader; `paths` are those of the files of the last composition, in the order of their merge."""

    paths: Sequence[str] = ()

    def _compose_config_from_defaults_list(
        self, defaults: list[ResultDefault], repo: IConfigRepository
    ) -> DictConfig:
        self.paths = [default.config_path or "" for default in defaults]
        return super()._compose_config_from_defaults_list(defaults=defaults, repo=repo)


def use_loader() -> None:
    """Gives Hydra, which must be initialized, a `Loader`."""
    hydra = GlobalHydra.instance().hydra
    assert hydra is not None
    hydra.config_loader = Loader(hydra.config_loader.get_search_path())


def composed(overrides: Sequence[str]) -> tuple[DictConfig, Sequence[str]]:
    """The tree of `build` with its `hydra` node, and the paths of its files in the search path."""
    config = compose(PRIMARY, list(overrides), return_hydra_config=True)
    loader = GlobalHydra.instance().config_loader()
    assert isinstance(loader, Loader)
    return config, loader.paths
