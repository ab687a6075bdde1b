"""Code of the user's own, named by `_target_`: only of modules that `plugins` names, which the command line
gives or a trusted file."""

import importlib
import importlib.util
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.config.files.trust import TARGET, covered
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.plugins.trusted_modules import NotTrusted, trust
from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.text.globs import listed

if TYPE_CHECKING:
    from linkwright.stages.validate.user_checks import OwnCheck


NOW_IN = "a check imports these from linkwright: from linkwright import Check, Finding, CompiledModel"

LOOKED_FOR = "it is looked for where Python looks, and in the working folder"


def target(entry: Mapping[str, Any], plugins: Sequence[str], where: str) -> Any:
    """The function or class that the `_target_` of an entry names. ConfigError where its module is none of
    `plugins`, cannot be imported, or lacks it."""
    path = str(entry[TARGET])
    module, _, name = path.rpartition(".")
    if not covered(path, plugins):
        msg = f"{path} is of no module that plugins names"
        raise ConfigError(msg, where, f"if you trust it: {pasted.word(f'plugins=[{module or path}]')}")
    trust(plugins)
    try:
        found = importlib.import_module(module)
    except NotTrusted as error:
        msg = f"{module} imports {error.name} of the working folder, which plugins does not name"
        raise ConfigError(msg, where, f"if you trust it: {error.line}") from error
    except Exception as error:
        msg = f"the module {module} cannot be imported: {type(error).__name__}: {error}"
        raise ConfigError(msg, where, NOW_IN if _gone(error) else LOOKED_FOR) from error
    code = getattr(found, name, None)
    if not callable(code):
        public = sorted(one for one, value in vars(found).items() if callable(value) and one[0] != "_")
        msg = f"{module} has no function or class {name}"
        raise ConfigError(msg, where, f"it has {listed(public)}" if public else "")
    return code


def _gone(error: Exception) -> bool:
    """Whether a module of ours is imported by a name that it had before there was one package."""
    name = error.name if isinstance(error, ModuleNotFoundError) else None
    return (name or "").partition(".")[0] in ("pipeline", "stages")


def named(plan: Plan) -> None:
    """ConfigError where code that `validate.checks` names cannot be found. What is of no trusted module is
    reported where the configuration is composed; so is a module of `plugins` that does not exist."""
    if not plan.plugins:
        return
    trust(plan.plugins)
    for plugin in plan.plugins:
        if not _is_there(plugin):
            msg = f"there is no module {plugin}"
            raise ConfigError(msg, "plugins", LOOKED_FOR)
    for number, entry in enumerate(plan.validate.checks):
        if covered(entry[TARGET], plan.plugins):
            target(entry, plan.plugins, _place(number))


def own(plan: Plan) -> "tuple[OwnCheck, ...]":
    """The user's own checks of a build, each with its keys. ConfigError where one cannot be found."""
    if not plan.validate.checks:
        return ()
    # Late: most robots have no plug-in.
    from linkwright.stages.validate.user_checks import OwnCheck

    return tuple(
        OwnCheck(
            entry[TARGET],
            target(entry, plan.plugins, _place(number)),
            {key: value for key, value in entry.items() if key != TARGET},
        )
        for number, entry in enumerate(plan.validate.checks)
    )


def _place(number: int) -> str:
    return f"validate.checks[{number}]"


def with_sources(known: dict[str, Any], plan: Plan) -> dict[str, Any] | None:
    """The validate stage's part of a cache key, with what its results depend on too: the text of the user's
    own code. None, so that nothing is kept, where that has no text."""
    if not plan.validate.checks:
        return known
    text = sources(plan.plugins)
    return None if text is None else {**known, "plugins": text}


def sources(plugins: Sequence[str]) -> str | None:
    """The digest of the text of these modules, with all of a package's; None where one has no text."""
    trust(plugins)
    digests = []
    for plugin in plugins:
        files = list(_files(plugin))
        if not files:
            return None
        digests += [f"{plugin} {file.name} {sha256(file.read_bytes())}" for file in files]
    return sha256("\n".join(digests).encode())


def _is_there(plugin: str) -> bool:
    try:
        return importlib.util.find_spec(plugin) is not None
    except (ImportError, ValueError):
        return False


def _files(plugin: str) -> Iterator[Path]:
    try:
        spec = importlib.util.find_spec(plugin)
    except (ImportError, ValueError):
        return
    if spec is None:
        return
    for folder in spec.submodule_search_locations or ():
        yield from sorted(Path(folder).rglob("*.py"))
    if not spec.submodule_search_locations and spec.origin and spec.origin.endswith(".py"):
        yield Path(spec.origin)
