"""A file sends the API key to no port of this computer, unless the user names the port."""

import pytest

import linkwright
from linkwright.pipeline.config.compose import session
from linkwright.pipeline.sweep.run import compose_sweep
from linkwright.stages.robot.errors import ConfigError
from tests.support import users
from tests.support.users import GLOBAL, URL, put, write

LOCAL = "http://127.0.0.1:8123"
ADDRESS = URL.replace("https://cad.onshape.com", LOCAL)
OTHER = ADDRESS.replace("8123", "9999")
VARIABLE = URL.replace("https://cad.onshape.com", "${vars.host}")
ONSHAPE = f"{GLOBAL}defaults:\n  - override /source: onshape\n"
PART = f'{GLOBAL}source: {{url: "{ADDRESS}"}}\n'


def naming(address):
    """A robot's file that names an address."""
    return f'{ONSHAPE}source: {{url: "{address}"}}\n'


def origin(folder, *arguments, environ=None):
    return users.composed(folder, *arguments, environ=environ or {}).plan.source.url.origin


def refused(folder, *arguments, environ=None):
    return users.refused(folder, *arguments, environ=environ or {})


MINE = "robot/mine.yaml"
WAYS = {
    "a robot": ({MINE: naming(ADDRESS)}, []),
    "a robot by its path": ({"x/mine.yaml": naming(ADDRESS)}, ["robot=x/mine.yaml"]),
    "an experiment": ({MINE: naming(URL), "experiment/e.yaml": naming(ADDRESS)}, ["experiment=e"]),
    "a source of the user": ({MINE: GLOBAL, "source/m.yaml": f"kind: onshape\nurl: {ADDRESS}"}, ["source=m"]),
    "a part of a robot": ({MINE: ONSHAPE.replace("  - o", "  - part\n  - o"), "robot/part.yaml": PART}, []),
    "a variable": ({MINE: f"{naming(VARIABLE)}vars: {{host: '{LOCAL}'}}\n"}, []),
    "a variable that an address on the command line names": (
        {MINE: f"{naming(URL)}vars: {{it: '{ADDRESS}'}}\n"}, ["source.url=${vars.it}"],
    ),
    "a name": ({MINE: naming(ADDRESS.replace("127.0.0.1", "LocalHost"))}, []),
    "https": ({MINE: naming(ADDRESS.replace("http:", "https:"))}, []),
    "IPv6": ({MINE: naming(ADDRESS.replace("127.0.0.1", "[::1]"))}, []),
    "offline": ({MINE: naming(ADDRESS)}, ["source.offline=true"]),
    "the variable that allows it, set by the file": (
        {MINE: f"{naming(ADDRESS)}hydra: {{job: {{env_set: {{LINKWRIGHT_HOST: '{LOCAL}'}}}}}}\n"}, [],
    ),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_a_host_on_this_computer_in_a_file_is_refused(tmp_path, way):
    files, typed = WAYS[way]
    put(tmp_path, files)
    arguments = typed if typed[:1] == ["robot=x/mine.yaml"] else ["robot=mine", *typed]
    message = refused(tmp_path, *arguments)
    assert "E-TRUST source.url: a file must not send the API key to a port of this computer" in message
    assert "set LINKWRIGHT_HOST=http" in message
    other = refused(tmp_path, *arguments, environ={"LINKWRIGHT_HOST": "http://127.0.0.1:9999"})
    assert "LINKWRIGHT_HOST names another host" in other


def test_the_environment_names_a_single_host_exactly(tmp_path):
    write(tmp_path, mine=naming(ADDRESS))
    for named in (LOCAL, f"{LOCAL}/", f" {LOCAL} "):
        assert origin(tmp_path, "robot=mine", environ={"LINKWRIGHT_HOST": named}) == LOCAL
    wrong = "1 127.0.0.1:8123 https://127.0.0.1:8123 http://localhost:8123 http://127.0.0.1 *"
    for environ in (
        *({"LINKWRIGHT_HOST": named} for named in wrong.split()),
        {"LINKWRIGHT_TRUST": str(tmp_path / "robot/mine.yaml")},
    ):
        assert "E-TRUST" in refused(tmp_path, "robot=mine", environ=environ), environ
    put(tmp_path, {".env": f"LINKWRIGHT_HOST={LOCAL}\n"})
    assert "E-TRUST" in refused(tmp_path, "robot=mine")
    write(tmp_path, mine=naming(URL.replace("cad.", "my-company.")))
    assert origin(tmp_path, "robot=mine").endswith("onshape.com"), "those of Onshape stay allowed"


@pytest.mark.parametrize("arguments", [
    ["robot=mine", f"source.url='{ADDRESS}'"],
    ["robot=mine", f"++source.url='{ADDRESS}'"],
    ["robot=mine", f"source.\"url\"='{ADDRESS}'"],
    ["robot=other", "source=onshape", f"source.url='{ADDRESS}'"],
    ["robot=mine", "experiment=e", f"source.url='{ADDRESS}'"],
])  # fmt: skip
def test_the_command_line_names_any_and_wins_over_files(tmp_path, arguments):
    write(tmp_path, mine=naming(URL), other=GLOBAL)
    put(tmp_path, {"experiment/e.yaml": f'{GLOBAL}source: {{url: "{OTHER}"}}\n'})
    assert origin(tmp_path, *arguments) == LOCAL


def test_host_in_a_file_is_refused_in_a_sweep_too(tmp_path):
    params = f"hydra: {{sweeper: {{params: {{source.url: \"'{ADDRESS}','{OTHER}'\"}}}}}}\n"
    write(tmp_path, mine=naming(URL) + params, plain=naming(URL))
    with session((), tmp_path, environ={}) as composer:
        asked = composer.with_params(*composer.read(["robot=mine"], multirun=True))
        with pytest.raises(ConfigError, match=r"E-TRUST job 0 \(.*\): source\.url: a file must not"):
            compose_sweep(composer, asked, lambda plan: ())
    with session((), tmp_path, environ={}) as composer:
        typed = ["robot=plain", f"source.url='{ADDRESS}','{OTHER}'"]
        asked = composer.with_params(*composer.read(typed, multirun=True))
        sweep = compose_sweep(composer, asked, lambda plan: ())
    assert [job.plan.source.url.text for job in sweep.jobs] == [ADDRESS, OTHER]


def test_python_may_name_any_host_but_no_file_may(tmp_path, monkeypatch):
    monkeypatch.chdir(write(tmp_path, mine=naming(ADDRESS)))
    data = {"source": {"kind": "onshape", "url": ADDRESS}}
    for arguments in ([data], ["robot=mine", f"source.url='{ADDRESS}'"]):
        with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY") as caught:
            linkwright.build(*arguments)
        assert "E-TRUST" not in str(caught.value)
    with pytest.raises(ConfigError, match=r"E-TRUST source\.url"):
        linkwright.build("robot=mine")
