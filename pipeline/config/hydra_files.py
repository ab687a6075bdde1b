"""Limits for the user's files that Hydra reads, and for their interpolations.

Hydra reads any file, and OmegaConf resolves an interpolation again wherever it is used: ten lines of
`${a}${a}...` expand as far as ten lines of aliases.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydra._internal.core_plugins import file_config_source
from hydra._internal.sources_registry import SourcesRegistry
from hydra.plugins.config_source import ConfigResult
from omegaconf.base import Container
from omegaconf.errors import InterpolationResolutionError

from pipeline.config import yaml_file

MOST_RESOLVED = 2000
"""Most interpolations that one value may resolve."""

LONGEST = 1 << 20
"""Most characters that they may have together."""

_RESOLVE = "_maybe_resolve_interpolation"


class FileConfigSource(file_config_source.FileConfigSource):
    """Hydra's file source, which checks each file first.

    It has the name of Hydra's class: Hydra registers its own repeatedly, and skips an equal name.
    """

    def load_config(self, config_path: str) -> ConfigResult:
        path = Path(self.path) / self._normalize_file_name(config_path)
        if path.exists():
            yaml_file.text(path)
        return super().load_config(config_path)


@contextmanager
def guarded() -> Iterator[None]:
    """Inside, Hydra (which must be initialized) reads only checked files, and interpolations are counted."""
    sources, scheme = SourcesRegistry.instance().types, FileConfigSource.scheme()
    own, sources[scheme] = sources[scheme], FileConfigSource
    resolve: Callable[..., Any] = getattr(Container, _RESOLVE)
    depth = count = letters = 0

    def counted(self: Container, *args: Any, **more: Any) -> Any:
        nonlocal depth, count, letters
        if not depth:
            count = letters = 0
        depth += 1
        try:
            count += 1
            if count > MOST_RESOLVED or letters > LONGEST:
                msg = "its interpolations expand to more than is allowed"
                raise InterpolationResolutionError(msg)
            found = resolve(self, *args, **more)
            value = None if found is None else found._value()
            letters += len(value) if isinstance(value, str) else 0
            return found
        finally:
            depth -= 1

    setattr(Container, _RESOLVE, counted)
    try:
        yield
    finally:
        setattr(Container, _RESOLVE, resolve)
        sources[scheme] = own
