"""Loads the user's own code, which `_target_` names.

It must be in a module that `plugins` names, and only the command line or a trusted file may set `plugins`.
"""

import importlib
import importlib.util
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.config.files.trust import TARGET_KEY, is_in_modules
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.plugins.trusted_modules import NotTrusted, trust
from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.validate.user_checks import UserCheck


IMPORT_HINT = "a check imports these from linkwright: from linkwright import Check, Finding, CompiledModel"

SEARCH_HINT = "it is looked for where Python looks, and in the working folder"


def target(entry: Mapping[str, Any], plugins: Sequence[str], where: str) -> Any:
    """Returns the function or class that the `_target_` of an entry names. Raises ConfigError if its module
    is not in `plugins`, cannot be imported, or lacks it."""
    path = str(entry[TARGET_KEY])
    module, _, name = path.rpartition(".")
    if not is_in_modules(path, plugins):
        msg = f"{path} belongs to no module that plugins names"
        raise ConfigError(msg, where, f"if you trust it: {pasted.word(f'plugins=[{module or path}]')}")
    trust(plugins)
    try:
        imported = importlib.import_module(module)
    except NotTrusted as error:
        msg = f"{module} imports {error.name} of the working folder, which plugins does not name"
        raise ConfigError(msg, where, f"if you trust it: {error.line}") from error
    except Exception as error:
        msg = f"the module {module} cannot be imported: {type(error).__name__}: {error}"
        raise ConfigError(msg, where, IMPORT_HINT if _uses_earlier_names(error) else SEARCH_HINT) from error
    code = getattr(imported, name, None)
    if not callable(code):
        public = sorted(
            attribute
            for attribute, value in vars(imported).items()
            if callable(value) and attribute[0] != "_"
        )
        msg = f"{module} has no function or class {name}"
        raise ConfigError(msg, where, f"it has {name_list(public)}" if public else "")
    return code


def _uses_earlier_names(error: Exception) -> bool:
    """Tells whether code imports linkwright's modules by their earlier names `pipeline` and `stages`."""
    name = error.name if isinstance(error, ModuleNotFoundError) else None
    return (name or "").partition(".")[0] in ("pipeline", "stages")


def require_code(plan: Plan) -> None:
    """Raises ConfigError if code that `validate.checks` names cannot be found, or a module of `plugins` does
    not exist. Code of a module that is not trusted is reported where the configuration is composed."""
    if not plan.plugins:
        return
    trust(plan.plugins)
    for plugin in plan.plugins:
        if not _exists(plugin):
            msg = f"there is no module {plugin}"
            raise ConfigError(msg, "plugins", SEARCH_HINT)
    for number, entry in enumerate(plan.validate.checks):
        if is_in_modules(entry[TARGET_KEY], plan.plugins):
            target(entry, plan.plugins, _check_key(number))


def objective_function(plan: Plan) -> Callable[..., Any] | None:
    """Returns the user's own objective; None if the configuration has none. Raises ConfigError if it cannot
    be found."""
    if plan.objective is None or plan.objective.target is None:
        return None
    function: Callable[..., Any] = target({TARGET_KEY: plan.objective.target}, plan.plugins, "objective")
    return function


def user_checks(plan: Plan) -> "tuple[UserCheck, ...]":
    """Returns the user's own checks of a build, each with its keys. Raises ConfigError if a check cannot be
    found."""
    if not plan.validate.checks:
        return ()
    # Late: most robots have no plug-in.
    from linkwright.stages.validate.user_checks import UserCheck

    return tuple(
        UserCheck(
            entry[TARGET_KEY],
            target(entry, plan.plugins, _check_key(number)),
            {key: value for key, value in entry.items() if key != TARGET_KEY},
        )
        for number, entry in enumerate(plan.validate.checks)
    )


def _check_key(index: int) -> str:
    return f"validate.checks[{index}]"


def with_sources(keys: dict[str, Any], plan: Plan) -> dict[str, Any] | None:
    """Returns the validate stage's part of a cache key, with the text of the user's own code, on which the
    results depend too. None, so that nothing is kept, if the text of that code is unknown."""
    if not plan.validate.checks:
        return keys
    text = sources_digest(plan.plugins)
    return None if text is None else {**keys, "plugins": text}


def sources_digest(plugins: Sequence[str]) -> str | None:
    """Returns a digest of the source texts of these modules, for packages with all their modules, and of the
    packages that they are in, whose code runs first; None if the text of one of the modules is unknown."""
    trust(plugins)
    digests = []
    for plugin in plugins:
        files = list(_files(plugin))
        if not files:
            return None
        words = plugin.split(".")
        parents = [".".join(words[:depth]) for depth in range(1, len(words))]
        files += [file for parent in parents for file in _own_text(parent)]
        digests += [f"{plugin} {name} {sha256(file.read_bytes())}" for name, file in files]
    return sha256("\n".join(digests).encode())


def _exists(plugin: str) -> bool:
    return _spec(plugin) is not None


def _spec(module: str) -> ModuleSpec | None:
    try:
        return importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None


def _files(plugin: str) -> Iterator[tuple[str, Path]]:
    """Yields the files of a module or package, each with its path inside the package."""
    spec = _spec(plugin)
    folders = spec.submodule_search_locations if spec is not None else None
    for folder in folders or ():
        files = sorted(Path(folder).rglob("*.py"))
        yield from ((file.relative_to(folder).as_posix(), file) for file in files)
    if not folders:
        yield from _own_text(plugin)


def _own_text(module: str) -> Iterator[tuple[str, Path]]:
    """Yields the file with the text of a module itself, with the module's name."""
    spec = _spec(module)
    if spec is not None and spec.origin and spec.origin.endswith(".py"):
        yield module, Path(spec.origin)
