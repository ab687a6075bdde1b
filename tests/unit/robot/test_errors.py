"""Errors at the border: one message, one exit status."""

import inspect

import pytest

from linkwright.pipeline import errors
from linkwright.stages.robot import errors as tree


@pytest.mark.parametrize(("error", "status"), [
    (errors.ConfigError("x"), 2), (errors.AuthError("x"), 1), (errors.AssemblyError("x"), 1),
    (errors.OutputError("x"), 1), (errors.CacheError("x"), 1), (errors.ValidationFailed("x"), 3),
    (KeyboardInterrupt(), 130), (ZeroDivisionError("x"), 1),
], ids=lambda value: type(value).__name__)  # fmt: skip
def test_the_exit_status_of(error, status):
    assert errors.exit_status(error) == status


def test_a_message_says_where_what_and_what_to_do():
    error = errors.NotFound("there is no such element", where="source.url", hint="check the address")
    assert errors.render(error) == ("error: source.url: there is no such element\n  → check the address")


def test_a_fault_of_the_program_says_where_its_traceback_is():
    text = errors.render(ZeroDivisionError("division by zero"))
    assert "bug in linkwright" in text
    assert "ZeroDivisionError: division by zero" in text
    assert "build.log" in text


def test_the_whole_tree_can_be_had_here():
    classes = {name for name, value in vars(tree).items() if inspect.isclass(value)}
    assert classes - {"Iterable"} <= set(errors.__all__)
