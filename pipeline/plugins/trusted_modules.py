"""Lets Python find modules in the working folder only if the user trusts them."""

import importlib
import sys
from collections.abc import Iterable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType

from linkwright.pipeline.terminal import pasted


class NotTrusted(ModuleNotFoundError):
    """A module is in the working folder, and is not a trusted module.

    It is a ModuleNotFoundError, which imports of optional modules handle: a file in the working folder may
    happen to have the name of such a module.
    """

    def __init__(self, name: str, trusted: Sequence[str]) -> None:
        self.line = pasted.word(f"plugins=[{','.join((*trusted, name))}]")
        super().__init__(f"{name} is in the working folder and not trusted; if you trust it: {self.line}")
        self.name = name


class TrustedModules(MetaPathFinder):
    """Finds in `folder` trusted modules, submodules of trusted packages, and the parent packages of both."""

    def __init__(self, folder: Path, names: Iterable[str]) -> None:
        self.folder = folder
        self.names = tuple(names)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Returns the module's spec; None if the module is not in the folder. Raises NotTrusted if it is in
        the folder, but not trusted."""
        parent = name.rpartition(".")[0]
        if parent and not self._leads_to_trusted(parent):
            return None
        spec = PathFinder.find_spec(name, [str(self.folder.joinpath(*parent.split(".")))])
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
    folder = Path.cwd()
    finders = [finder for finder in sys.meta_path if isinstance(finder, TrustedModules)]
    if finders and (finders[0].folder, finders[0].names) == (folder, tuple(names)):
        return
    for finder in finders:
        sys.meta_path.remove(finder)
    sys.meta_path.append(TrustedModules(folder, names))
    importlib.invalidate_caches()
