"""Secrets are blanked in what is told, and nothing else is harmed."""

import pytest

from pipeline.secrets import Secrets

KEY = {"ONSHAPE_ACCESS_KEY": "access-key", "ONSHAPE_SECRET_KEY": "access-key-and-more"}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_values_are_blanked_at_any_depth_and_keys_are_not():
    tree = {"access-key": ["is access-key", {"a": ("access-key-and-more", 1, None, True)}]}
    assert Secrets(KEY).within(tree) == {"access-key": ["is ***", {"a": ["***", 1, None, True]}]}


@pytest.mark.parametrize("short", ["e", "status", "7-chars"])
def test_a_text_that_is_too_short_for_a_key_is_not_blanked(short):
    text = "the status of 7-chars"
    assert Secrets({"ONSHAPE_ACCESS_KEY": short, "ONSHAPE_SECRET_KEY": short}).blanked(text) == text
