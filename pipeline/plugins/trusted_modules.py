"""Modules of the working folder that the user trusts: Python finds these there, and no others."""

import importlib
import sys
from collections.abc import Iterable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType

from linkwright.pipeline.terminal import pasted


class NotTrusted(ModuleNotFoundError):
    """A module is in the working folder, and no trusted module.

    It is an error that an import of an optional module expects, since any file may have the name of such a
    module.
    """

    def __init__(self, name: str, trusted: Sequence[str]) -> None:
        self.line = pasted.word(f"plugins=[{','.join((*trusted, name))}]")
        super().__init__(f"{name} is in the working folder and not trusted; if you trust it: {self.line}")
        self.name = name


class TrustedModules(MetaPathFinder):
    """Finds trusted modules, the submodules of trusted packages and the packages around both in `folder`."""

    def __init__(self, folder: Path, names: Iterable[str]) -> None:
        self.folder = folder
        self.names = tuple(names)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The module's spec; None for what is not in the folder. NotTrusted for what is there untrusted."""
        around = name.rpartition(".")[0]
        if around and not self._leads_to_trusted(around):
            return None
        spec = PathFinder.find_spec(name, [str(self.folder.joinpath(*around.split(".")))])
        if spec is None or self._is_trusted(name):
            return spec
        if not self._leads_to_trusted(name):
            raise NotTrusted(name, self.names)
        # Python looks for submodules here before it asks this finder.
        spec.submodule_search_locations = []
        return spec

    def _is_trusted(self, name: str) -> bool:
        return any(f"{name}.".startswith(f"{trusted}.") for trusted in self.names)

    def _leads_to_trusted(self, name: str) -> bool:
        return any(trusted.startswith(f"{name}.") for trusted in self.names)


def trust(names: Sequence[str]) -> None:
    """Lets Python find these modules in the working folder, after all other places."""
    here = Path.cwd()
    known = [finder for finder in sys.meta_path if isinstance(finder, TrustedModules)]
    if known and (known[0].folder, known[0].names) == (here, tuple(names)):
        return
    for finder in known:
        sys.meta_path.remove(finder)
    sys.meta_path.append(TrustedModules(here, names))
    importlib.invalidate_caches()
