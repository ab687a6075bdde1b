"""Produces the output of `--cfg` and `--info`: the configuration, and how it was composed."""

import contextlib
import io
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import yaml

from linkwright.pipeline.config.compose import Composed, session
from linkwright.pipeline.config.messages import nearest
from linkwright.pipeline.config.plain import as_written
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.key_path import Place
from linkwright.pipeline.options import INFO, Command
from linkwright.pipeline.secrets import Secrets


def configuration(command: Command, environ: Mapping[str, str] = os.environ) -> str:
    """Returns the validated configuration of a command, as YAML with secrets blanked.

    Interpolations stay unresolved without `--resolve`. Raises ConfigError as a build does, except for the
    checks that only a build needs, such as credentials.
    """
    with session(command.config_dirs, environ=environ) as composer:
        overrides, problems = composer.read(command.overrides)
        composed = composer.compose([override.hydra for override in overrides], problems)
    return _as_yaml(composed, command, environ)


def _as_yaml(composed: Composed, command: Command, environ: Mapping[str, str]) -> str:
    tree: dict[str, Any] = {}
    if command.subject != "hydra":
        tree = composed.plan.tree()
        if not command.resolve:
            _restore_interpolations(tree, as_written(composed.config), composed.computed)
    if command.subject != "job":
        node = as_written(composed.config.hydra)
        tree["hydra"] = {key: value for key, value in node.items() if key not in ("help", "hydra_help")}
    tree = Secrets(environ).within(tree)
    if command.package in ("", "_global_"):
        return _as_text(tree)
    part = _node_at(tree, command.package)
    return f"# @package {command.package}\n{_as_text(part)}" if isinstance(part, dict | list) else f"{part}\n"


def _as_text(tree: Any) -> str:
    return str(yaml.safe_dump(tree, sort_keys=False, allow_unicode=True))


def _restore_interpolations(tree: Any, unresolved: Any, places: Iterable[Place]) -> None:
    """Restores interpolations at their places, where the plan has those places."""
    for place in places:
        node, text = tree, unresolved
        with contextlib.suppress(KeyError, IndexError, TypeError):
            for name in place[:-1]:
                node, text = node[name], text[name]
            if place[-1] in node if isinstance(node, dict) else True:
                node[place[-1]] = text[place[-1]]


def _node_at(tree: Any, package: str) -> Any:
    """Returns the part of a tree at a path such as `mesh.tolerance`. Raises ConfigError for an unknown
    path."""
    node = tree
    for name in package.split("."):
        if isinstance(node, list) and name.isdigit() and int(name) < len(node):
            node = node[int(name)]
        elif isinstance(node, dict) and name in node:
            node = node[name]
        else:
            names = list(map(str, node)) if isinstance(node, dict) else []
            msg = "there is no such part of the configuration"
            hint = nearest(name, names) or f"there is: {', '.join(names) or 'nothing below'}"
            raise ConfigError(msg, f"--package {package}", hint)
    return node


def information(command: Command, environ: Mapping[str, str] = os.environ) -> Iterator[str]:
    """Yields how the configuration is composed, mostly as Hydra prints it: files, defaults, plug-ins, search
    path; last the configuration itself, if requested."""
    kinds = [kind for kind in INFO if command.subject in (kind, "all") and kind not in ("all", "config")]
    with session(command.config_dirs, environ=environ) as composer:
        overrides, problems = composer.read(command.overrides)
        for kind in kinds:
            text = _output_of(partial(composer.show, kind, overrides, problems))
            yield Secrets(environ).blanked(text.strip("\n") + "\n\n")
    if command.subject in ("config", "all"):
        yield configuration(command._replace(subject="job"), environ)


def _output_of(show: Callable[[], None]) -> str:
    """Returns what Hydra logs while `show` runs."""
    root = logging.getLogger()
    handlers, level = list(root.handlers), root.level
    stream = io.StringIO()
    # A sweep in the same process quiets Hydra's loggers, and switches off those that were there before it.
    settings = [(logger, logger.disabled, logger.level) for logger in _loggers("hydra")]
    for logger, *_ in settings:
        logger.disabled = False
        logger.setLevel(logging.NOTSET)
    try:
        with contextlib.redirect_stdout(stream):
            show()
    finally:
        root.handlers[:] = handlers
        root.setLevel(level)
        for logger, disabled, logger_level in settings:
            logger.disabled = disabled
            logger.setLevel(logger_level)
    return stream.getvalue()


def _loggers(package: str) -> list[logging.Logger]:
    """Returns the logger of a package and the existing loggers below it."""
    below = [name for name in logging.root.manager.loggerDict if name.startswith(f"{package}.")]
    return [logging.getLogger(name) for name in (package, *below)]
