"""Secrets are blanked in what is told, never written to a file, and nothing else is harmed."""

import base64
import json
import re
from urllib.parse import quote

import pytest

from linkwright.pipeline.caching.actions import opened
from linkwright.pipeline.config.compose import compose_plan, session
from linkwright.pipeline.errors import ConfigError, SecretFound
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep.run import compose_sweep

KEY = {"ONSHAPE_ACCESS_KEY": "access-key", "ONSHAPE_SECRET_KEY": "access-key-and-more"}

ACCESS, SECRET, TOKEN = "AkEyOfTwentyFourLetters1", "SeCrEt/with+signs=and&more\\1", "t0ken-bearer-of"
ENVIRON = {"ONSHAPE_ACCESS_KEY": ACCESS, "ONSHAPE_SECRET_KEY": SECRET, "ONSHAPE_ACCESS_TOKEN": TOKEN}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def environ(monkeypatch):
    for name, value in ENVIRON.items():
        monkeypatch.setenv(name, value)


def packed(text):
    return base64.b64encode(text.encode()).decode()


def test_values_are_blanked_at_any_depth_and_keys_are_not():
    tree = {"access-key": ["is access-key", {"a": ("access-key-and-more", 1, None, True)}]}
    assert Secrets(KEY).within(tree) == {"access-key": ["is ***", {"a": ["***", 1, None, True]}]}


@pytest.mark.parametrize("short", ["e", "status", "7-chars"])
def test_a_text_that_is_too_short_for_a_key_is_not_blanked(short):
    text = "the status of 7-chars"
    secrets = Secrets({"ONSHAPE_ACCESS_KEY": short, "ONSHAPE_SECRET_KEY": short})
    assert secrets.blanked(text) == text
    secrets.check({"a.txt": text.encode()})


FORMS = {
    "plain": (SECRET, "ONSHAPE_SECRET_KEY"),
    "in the middle": (f"x{ACCESS}y", "ONSHAPE_ACCESS_KEY"),
    "token": (TOKEN, "ONSHAPE_ACCESS_TOKEN"),
    "Basic": (f"Basic {packed(f'{ACCESS}:{SECRET}')}", "ONSHAPE_ACCESS_KEY"),
    "base64": (packed(SECRET), "ONSHAPE_SECRET_KEY"),
    "base64 without its end": (packed(SECRET).rstrip("="), "ONSHAPE_SECRET_KEY"),
    "base64 in a URL": (quote(packed(f"{ACCESS}:{SECRET}"), safe=""), "ONSHAPE_ACCESS_KEY"),
    "in a URL": (quote(SECRET, safe=""), "ONSHAPE_SECRET_KEY"),
    "in a URL, small": (
        re.sub("%..", lambda code: code[0].lower(), quote(SECRET, safe="")),
        "ONSHAPE_SECRET_KEY",
    ),
    "in JSON": (json.dumps(SECRET), "ONSHAPE_SECRET_KEY"),
    "in JSON with \\/": (json.dumps(SECRET).replace("/", "\\/"), "ONSHAPE_SECRET_KEY"),
    "in XML": (f"<a b='{SECRET.replace('&', '&amp;')}'/>", "ONSHAPE_SECRET_KEY"),
}


@pytest.mark.parametrize("form", FORMS)
def test_file_with_a_secret_is_refused_with_its_place(form):
    text, variable = FORMS[form]
    secrets = Secrets(ENVIRON)
    with pytest.raises(SecretFound) as caught:
        secrets.check({"good.txt": b"fine", "robot.txt": f"one\ntwo\nthree {text}\n".encode()})
    assert caught.value.where == "robot.txt, line 3"
    assert variable in caught.value.message
    blanked = secrets.blanked(text)
    for part in (ACCESS, SECRET, TOKEN, packed(SECRET)[:20], packed(ACCESS)[:20]):
        assert part not in str(caught.value)
        assert part not in blanked


def test_secret_in_json_or_in_a_file_name_has_its_place():
    tree = {"links": [{"cad": "x"}, {"cad": {"name": f"Arm {SECRET}"}}]}
    for files, place in (
        ({"robot.json": json.dumps(tree).encode()}, "robot.json, links[1].cad.name"),
        ({f"assets/{TOKEN}.stl": b""}, "assets/***.stl"),
    ):
        with pytest.raises(SecretFound) as caught:
            Secrets(ENVIRON).check(files)
        assert caught.value.where == place


@pytest.mark.parametrize(
    ("dotenv", "variables"),
    [(f"ONSHAPE_SECRET_KEY='{TOKEN}'\n", {}),
     (f"ONSHAPE_ACCESS_KEY=a\nONSHAPE_SECRET_KEY={TOKEN}\n", {"ONSHAPE_ACCESS_TOKEN": "another-one"}),
     (f"ONSHAPE_SECRET_BEARER={TOKEN}\n", {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"})],
    ids=["half a key", "behind a token", "behind a key"],
)  # fmt: skip
def test_a_key_that_no_build_would_use_is_a_secret_too(tmp_path, dotenv, variables):
    (tmp_path / ".env").write_text(dotenv)
    assert Secrets(variables).blanked(f"is {TOKEN}") == "is ***"


WAYS = {
    "name": "name=${oc.env:ONSHAPE_ACCESS_KEY}",
    "output": "output=out/${oc.env:ONSHAPE_ACCESS_KEY}",
    "cache.dir": "cache.dir=${oc.env:ONSHAPE_ACCESS_TOKEN}",
    "names.links.a": "names.links.a=x${oc.env:ONSHAPE_ACCESS_KEY}",
    "source.path": "source.path=${oc.env:ONSHAPE_ACCESS_KEY}.zip",
    "source.max_calls": "source.max_calls=${oc.env:ONSHAPE_ACCESS_KEY}",
    "no_such_key": "no_such_key=${oc.env:ONSHAPE_SECRET_KEY}",
    "ground.size[0]": "ground.size=['${oc.env:ONSHAPE_ACCESS_KEY}',1]",
    'joints["***"].damping': f"joints.{ACCESS}*.damping=1",
    "joints.***": f"joints.{ACCESS}.damping=1",
}


@pytest.mark.parametrize("key", WAYS)
def test_configuration_with_a_secret_is_refused_by_its_key(environ, key):
    with pytest.raises(ConfigError) as caught:
        compose_plan(["source=bundle", WAYS[key]])
    assert "E-SECRET" in [problem.code for problem in caught.value.problems]
    assert not any(secret in str(caught.value) for secret in ENVIRON.values())
    if "*" not in key:
        problems = [problem for problem in caught.value.problems if problem.where == key]
        assert [problem.code for problem in problems] == ["E-SECRET"]
        assert "holds the value of ONSHAPE_" in problems[0].message
    assert compose_plan(["source=sample", "name=arm"]).plan.name == "arm"


def test_a_robots_file_is_judged_too_and_its_hydra_keys(environ, tmp_path):
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "mine.yaml").write_text(
        "# @package _global_\ndefaults: [override /source: sample]\n"
        f"names: {{links: {{'{SECRET}': arm}}}}\n"
        "hydra: {sweep: {subdir: '${oc.env:ONSHAPE_ACCESS_KEY}'}}\n"
    )
    with pytest.raises(ConfigError) as caught:
        compose_plan(["robot=mine"])
    places = [problem.where for problem in caught.value.problems if problem.code == "E-SECRET"]
    assert places == ["names.links.***", "hydra.sweep.subdir"]


def test_sweep_with_a_secret_writes_nothing(environ, tmp_path):
    arguments = ["source=sample", f"name=a,{ACCESS}", "output=x${oc.env:ONSHAPE_ACCESS_TOKEN}"]
    with session() as composer:
        asked = composer.with_params(*composer.read(arguments, multirun=True))
        with pytest.raises(ConfigError) as caught:
            compose_sweep(composer, asked, lambda _: [])
    assert not any(secret in str(caught.value) for secret in ENVIRON.values())
    assert {"name", "every job: output"} <= {problem.where for problem in caught.value.problems}
    assert list(tmp_path.iterdir()) == []


def test_the_cache_keeps_no_secret(tmp_path):
    with opened("use", str(tmp_path / "cache"), ENVIRON) as cache:
        replies = cache.replies()
        with pytest.raises(SecretFound) as caught:
            replies.put("/documents/d/x", json.dumps({"parts": [{"name": SECRET}]}).encode())
        assert caught.value.where == "/documents/d/x, parts[0].name"
        for act in (
            lambda: replies.remember("state", {"state": [TOKEN]}),
            lambda: cache.memo("graph", 1, {})("view", {}, lambda: ACCESS.encode()),
            lambda: cache.keep({f"assets/{TOKEN}.stl": b"x"}),
        ):
            with pytest.raises(SecretFound):
                act()
        replies.put("/documents/d/y", b"{}")
    kept = b"".join(path.read_bytes() for path in (tmp_path / "cache").rglob("*") if path.is_file())
    assert not any(secret.encode() in kept for secret in ENVIRON.values())
    assert b"/documents/d/y" in kept
