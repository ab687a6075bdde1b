"""A file alone sends the API key to no port of this computer."""

import pytest

import linkwright
from linkwright.pipeline.config.compose import compose_plan, session
from linkwright.pipeline.sweep.run import jobs_of
from linkwright.stages.robot.errors import ConfigError
from tests.support.users import URL, write

LOCAL = "http://127.0.0.1:8123"
ADDRESS = URL.replace("https://cad.onshape.com", LOCAL)
OTHER = ADDRESS.replace("8123", "9999")
ONSHAPE = "# @package _global_\ndefaults:\n  - override /source: onshape\n"
SAMPLE = "# @package _global_\ndefaults:\n  - override /source: sample\n"

VARIABLE = URL.replace("https://cad.onshape.com", "${vars.host}")
PART = f'# @package _global_\nsource: {{url: "{ADDRESS}"}}\n'
OWN_SOURCE = f'kind: onshape\nurl: "{ADDRESS}"\n'


def file_naming(address: str) -> str:
    return f'{ONSHAPE}source: {{url: "{address}"}}\n'


def put(folder, path, text):
    file = folder / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def refused(folder, *arguments, environ=None, dirs=()):
    with pytest.raises(ConfigError) as caught:
        compose_plan(arguments, dirs, folder, environ=environ or {})
    return str(caught.value)


WAYS = {
    "a robot": ({"robot/mine.yaml": file_naming(ADDRESS)}, ["robot=mine"]),
    "a robot by its path": ({"x/mine.yaml": file_naming(ADDRESS)}, ["robot=x/mine.yaml"]),
    "an experiment": (
        {"robot/mine.yaml": file_naming(URL), "experiment/e.yaml": file_naming(ADDRESS)},
        ["robot=mine", "experiment=e"],
    ),
    "a source of the user's": (
        {"robot/mine.yaml": "# @package _global_\n", "source/mine.yaml": OWN_SOURCE},
        ["robot=mine", "source=mine"],
    ),
    "a part of a robot": (
        {"robot/mine.yaml": ONSHAPE.replace("  - o", "  - part\n  - o"), "robot/part.yaml": PART},
        ["robot=mine"],
    ),
    "a variable": (
        {"robot/mine.yaml": f"{file_naming(VARIABLE)}vars: {{host: '{LOCAL}'}}\n"},
        ["robot=mine"],
    ),
    "a variable that an address on the command line names": (
        {"robot/mine.yaml": f"{file_naming(URL)}vars: {{it: '{ADDRESS}'}}\n"},
        ["robot=mine", "source.url=${vars.it}"],
    ),
    "a name": ({"robot/mine.yaml": file_naming(ADDRESS.replace("127.0.0.1", "LocalHost"))}, ["robot=mine"]),
    "https": ({"robot/mine.yaml": file_naming(ADDRESS.replace("http:", "https:"))}, ["robot=mine"]),
    "IPv6": ({"robot/mine.yaml": file_naming(ADDRESS.replace("127.0.0.1", "[::1]"))}, ["robot=mine"]),
    "offline": ({"robot/mine.yaml": file_naming(ADDRESS)}, ["robot=mine", "source.offline=true"]),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_a_host_on_this_computer_in_a_file_is_refused(tmp_path, way):
    files, arguments = WAYS[way]
    for path, text in files.items():
        put(tmp_path, path, text)
    message = refused(tmp_path, *arguments)
    assert "E-TRUST source.url: a file must not send the API key to a port of this computer" in message
    assert "set LINKWRIGHT_HOST=http" in message
    assert "LINKWRIGHT_HOST names another host" in refused(
        tmp_path, *arguments, environ={"LINKWRIGHT_HOST": "http://127.0.0.1:9999"}
    )


def test_the_environment_names_one_host_exactly(tmp_path):
    write(tmp_path, mine=file_naming(ADDRESS))
    for named in (LOCAL, f"{LOCAL}/", f" {LOCAL} "):
        plan = compose_plan(["robot=mine"], (), tmp_path, environ={"LINKWRIGHT_HOST": named}).plan
        assert plan.source.url.origin == LOCAL
    for named in (
        "1",
        "127.0.0.1:8123",
        "https://127.0.0.1:8123",
        "http://localhost:8123",
        "http://127.0.0.1",
        "*",
    ):
        assert "E-TRUST" in refused(tmp_path, "robot=mine", environ={"LINKWRIGHT_HOST": named})
    (tmp_path / ".env").write_text(f"LINKWRIGHT_HOST={LOCAL}\n")
    assert "E-TRUST" in refused(tmp_path, "robot=mine")
    assert "E-TRUST" in refused(
        tmp_path, "robot=mine", environ={"LINKWRIGHT_TRUST": str(tmp_path / "robot/mine.yaml")}
    )


def test_a_file_cannot_set_the_environment(tmp_path):
    write(
        tmp_path, mine=f"{file_naming(ADDRESS)}hydra: {{job: {{env_set: {{LINKWRIGHT_HOST: '{LOCAL}'}}}}}}\n"
    )
    assert "E-TRUST source.url" in refused(tmp_path, "robot=mine")


@pytest.mark.parametrize(
    "arguments",
    [
        ["robot=mine", f"source.url='{ADDRESS}'"],
        ["robot=mine", f"++source.url='{ADDRESS}'"],
        ["robot=mine", f"source.\"url\"='{ADDRESS}'"],
        ["robot=other", "source=onshape", f"source.url='{ADDRESS}'"],
    ],
)
def test_the_command_line_names_any(tmp_path, arguments):
    write(tmp_path, mine=file_naming(URL), other="# @package _global_\n")
    assert compose_plan(arguments, (), tmp_path, environ={}).plan.source.url.origin == LOCAL


def test_the_command_line_names_one_host_and_a_file_no_other(tmp_path):
    write(tmp_path, mine=file_naming(URL))
    put(tmp_path, "experiment/e.yaml", f'# @package _global_\nsource: {{url: "{OTHER}"}}\n')
    assert "E-TRUST source.url" in refused(tmp_path, "robot=mine", "experiment=e")
    # What is typed wins over the experiment.
    arguments = ["robot=mine", "experiment=e", f"source.url='{ADDRESS}'"]
    assert compose_plan(arguments, (), tmp_path, environ={}).plan.source.url.origin == LOCAL


def test_a_sweep_of_a_file_is_a_file_and_a_sweep_on_the_command_line_is_typed(tmp_path):
    params = f"hydra: {{sweeper: {{params: {{source.url: \"'{ADDRESS}','{OTHER}'\"}}}}}}\n"
    write(tmp_path, mine=file_naming(URL) + params, plain=file_naming(URL))
    with session((), tmp_path, environ={}) as composer:
        asked = composer.with_params(*composer.read(["robot=mine"], multirun=True))
        with pytest.raises(ConfigError, match=r"E-TRUST job 0 \(.*\): source\.url: a file must not"):
            jobs_of(composer, asked, lambda plan: ())
    with session((), tmp_path, environ={}) as composer:
        typed = ["robot=plain", f"source.url='{ADDRESS}','{OTHER}'"]
        asked = composer.with_params(*composer.read(typed, multirun=True))
        sweep = jobs_of(composer, asked, lambda plan: ())
    assert [job.plan.source.url.text for job in sweep.jobs] == [ADDRESS, OTHER]


def test_python_names_any_in_its_data_and_overrides_but_not_by_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, mine=file_naming(ADDRESS))
    data = {"source": {"kind": "onshape", "url": ADDRESS}}
    with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY") as caught:
        linkwright.build(data)
    assert "E-TRUST" not in str(caught.value)
    with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY") as caught:
        linkwright.build("robot=mine", f"source.url='{ADDRESS}'")
    assert "E-TRUST" not in str(caught.value)
    with pytest.raises(ConfigError, match=r"E-TRUST source\.url"):
        linkwright.build("robot=mine")


def test_onshapes_own_hosts_stay_allowed_in_files(tmp_path):
    write(tmp_path, mine=file_naming(URL.replace("cad.", "my-company.")))
    assert compose_plan(["robot=mine"], (), tmp_path, environ={}).plan.source.url.origin.endswith(
        "onshape.com"
    )
