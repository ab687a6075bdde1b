"""`linkwright snapshot`: what the robots of a repository come to, as texts that are kept and compared."""

import io
import json
import socket
import zipfile
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import Offline
from linkwright.pipeline.snapshots.compare import differences
from linkwright.pipeline.snapshots.offline import offline
from linkwright.pipeline.snapshots.text import read_entries
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.sample import sample_document
from tests.support.command import environment, linkwright
from tests.support.users import MY_ARM, write

HEAD = "# @package _global_\n"
SAMPLE = f"{HEAD}defaults:\n  - override /source: sample\n"
ARM = f"{SAMPLE}  - override /root: fixed\njoints: {{lift: {{limits: [0, 0.03]}}}}\n"
SOLID = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
URDF = f"""\
<robot name="pair"><link name="a">{SOLID.format("2")}</link><link name="b">{SOLID.format("0.5")}</link>
<joint name="hinge" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>
"""
PAIR = f"{HEAD}defaults:\n  - override /source: urdf\nsource: {{path: models/pair.urdf}}\n"
KEY = "AkZq7Distinct0Access1Key"


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A repository with one robot, whose source is a small URDF in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path.parent / f"{tmp_path.name}-cache"))
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "pair.urdf").write_text(URDF)
    return write(tmp_path, pair=PAIR)


def experiment(folder, **experiments):
    (folder / "experiment").mkdir(exist_ok=True)
    for name, text in experiments.items():
        (folder / "experiment" / f"{name}.yaml").write_text(HEAD + text)


def kept(folder):
    return {file.name: file.read_text() for file in sorted((folder / "snapshots").glob("*.txt"))}


def section(text, name):
    """A section of a snapshot, read by hand."""
    _, _, rest = text.partition(f"[{name}]\n")
    return dict(line.split(": ", 1) for line in rest.partition("\n\n")[0].splitlines())


def test_snapshot_has_choices_and_figures(here):
    assert run(["snapshot"]) == 0
    (text,) = kept(here).values()
    assert text.splitlines()[:2] == ["linkwright snapshot 1", "robot: pair"]
    assert section(text, "choices")["source"] == "urdf"
    assert section(text, "configuration") == {
        "name": "pair", "source.kind": "urdf", "source.path": "models/pair.urdf",
    }  # fmt: skip
    figures = section(text, "figures")
    assert figures["until"] == "graph"
    assert (figures["links"], figures["joints"], figures["mass"]) == ("2", "1", "2.5")
    assert run(["snapshot", "--check"]) == 0


def test_snapshot_has_only_keys_that_are_no_defaults(here):
    chosen = PAIR.replace("source: {", "  - override /root: free\nsource: {")
    keys = "ground: {kind: plane, size: [9, 9]}\njoints: {hinge: {damping: 0.5}}\n"
    write(here, pair=chosen + keys)
    run(["snapshot"])
    configuration = section(kept(here)["pair.txt"], "configuration")
    entries = {"ground.size": "[9.0, 9.0]", "joints.hinge.damping": "0.5", "root.base": "free"}
    assert configuration.items() >= entries.items()
    assert not {"ground.kind", "joints.hinge.friction"} & configuration.keys()
    assert section(kept(here)["pair.txt"], "choices")["root"] == "free"


def test_a_motor_is_told_with_its_values(here, capsys):
    chosen = "actuators: {hinge: {motor: mine}}\njoints: {hinge: {limits: [-1, 1]}}\n"
    write(here, pair=PAIR + chosen)
    motor = here / "motors" / "mine.yaml"
    motor.parent.mkdir()
    data = "title: Mine\nvalues: {effort: {value: 3, source: the bench, kind: measured}}\n"
    motor.write_text(data)
    assert run(["snapshot"]) == 0
    assert str(here) not in kept(here)["pair.txt"]
    motor.write_text(data.replace("value: 3", "value: 4"))
    assert run(["snapshot", "--check"]) == 3
    assert "motors.mine.values.effort.value: 3.0 → 4.0" in capsys.readouterr().err


def test_interpolations_are_as_written_wherever_it_runs(here, monkeypatch):
    """Also where they come to a default of the key, or stand within a list."""
    keys = 'joints: {hinge: {limits: [-1, "${vars.reach}"], damping: "${oc.env:DAMPING,null}"}}\n'
    write(here, pair=f"{PAIR}{keys}vars: {{reach: 0.3}}\n")
    run(["snapshot"])
    before = kept(here)
    configuration = section(before["pair.txt"], "configuration")
    assert configuration["joints.hinge.limits"] == '[-1.0, "${vars.reach}"]'
    assert configuration["joints.hinge.damping"] == "${oc.env:DAMPING,null}"
    monkeypatch.setenv("DAMPING", "0.7")
    assert run(["snapshot", "--check"]) == 0
    run(["snapshot"])
    assert kept(here) == before


def test_changed_key_figure_or_order_is_shown(here, capsys):
    run(["snapshot"])
    (here / "models" / "pair.urdf").write_text(URDF.replace('value="0.5"', 'value="0.75"'))
    write(here, pair=f"{PAIR}ground: {{size: [9, 9]}}\n")
    capsys.readouterr()
    assert run(["snapshot", "--check"]) == 3
    assert capsys.readouterr().err.startswith(
        "error: snapshots/pair.txt: the robot has changed\n"
        "  1 key changed:\n"
        "    ground.size: (default) → [9.0, 9.0]\n"
        "  1 figure changed:\n"
        "    mass: 2.5 → 2.75\n"
        "  → if the change is intended: linkwright snapshot, or pytest --linkwright-update\n"
    )
    assert run(["snapshot"]) == 0
    assert "mass: 2.5 → 2.75" in capsys.readouterr().out
    assert run(["snapshot", "--check"]) == 0
    both = ('"*": {damping: 1}', '"h*": {damping: 2}')
    for order, status in ((both, 0), (both[::-1], 3)):
        write(here, pair=f"{PAIR}joints: {{{', '.join(order)}}}\n")
        if status == 0:
            run(["snapshot"])
        assert run(["snapshot", "--check"]) == status
    assert "the order of its keys changed, from joints.h*.damping on" in capsys.readouterr().err


def test_missing_and_left_over_snapshots_are_settled(here, capsys):
    write(here, other=PAIR)
    run(["snapshot"])
    (here / "robot" / "other.yaml").unlink()
    (here / "snapshots" / "pair.txt").unlink()
    (here / "snapshots" / "notes.txt").write_text("mine\n")
    capsys.readouterr()
    assert run(["snapshot", "--check"]) == 3
    output = capsys.readouterr().err
    assert "snapshots/pair.txt: there is no snapshot of robot=pair" in output
    assert "linkwright snapshot, or pytest --linkwright-update" in output
    assert "snapshots/other.txt: left over" in output
    assert run(["snapshot"]) == 0
    assert "snapshots/other.txt: removed" in capsys.readouterr().out
    assert sorted(kept(here)) == ["notes.txt", "pair.txt"]
    write(here, pair=f"{PAIR}name: two\n")
    assert run(["snapshot", "--check"]) == 3
    assert run(["snapshot"]) == 0
    assert sorted(kept(here)) == ["notes.txt", "two.txt"], "that of a renamed robot is left over"


def test_experiment_has_a_snapshot_with_its_robot_or_with_each(here):
    write(here, other=PAIR, _base=f"{HEAD}nonsense: 1\n")
    experiment(
        here, own="defaults:\n  - override /robot: pair\nground: {size: [9, 9]}\n", any="zero: saved\n"
    )
    assert run(["snapshot"]) == 0
    snapshots = kept(here)
    assert sorted(snapshots) == ["other.txt", "other_any.txt", "pair.txt", "pair_any.txt", "pair_own.txt"]
    assert section(snapshots["pair_own.txt"], "configuration")["ground.size"] == "[9.0, 9.0]"
    assert section(snapshots["pair_own.txt"], "choices")["robot"] == "pair"
    assert section(snapshots["other_any.txt"], "configuration")["zero"] == "saved"


def test_robot_that_cannot_be_composed_stops_no_other(here, capsys):
    run(["snapshot"])
    write(here, pair=f"{PAIR}foo: 1\n", whole=PAIR)
    assert run(["snapshot"]) == 2
    output = capsys.readouterr().err
    assert "robot=pair: error" in output
    assert "E-KEY foo" in output
    assert sorted(kept(here)) == ["pair.txt", "whole.txt"]  # that of before may still be right
    (here / "models" / "pair.urdf").write_text("<robot")
    assert run(["snapshot", "--check"]) == 1


def test_the_last_line_tells_made_from_changed(here, capsys):
    broken = f"{PAIR}foo: 1\n"
    write(here, other=PAIR, bad=broken, worse=broken)
    lines = []
    for pair in (PAIR, PAIR, f"{PAIR}ground: {{size: [9, 9]}}\n"):
        write(here, pair=pair)
        assert run(["snapshot"]) == 2
        lines.append(capsys.readouterr().out.splitlines()[-1])
    assert lines == [
        "snapshots/: 4 snapshots, 2 made, 2 wrong",
        "snapshots/: 4 snapshots, none changed, 2 wrong",
        "snapshots/: 4 snapshots, 1 changed, 2 wrong",
    ]


@pytest.mark.parametrize("holder", ["variable", "file"])
def test_a_key_in_a_robot_is_refused_and_never_shown(here, monkeypatch, capsys, holder):
    """Also one that only a file beside the robots holds."""
    monkeypatch.delenv("ONSHAPE_SECRET_KEY", raising=False)
    if holder == "variable":
        monkeypatch.setenv("ONSHAPE_SECRET_KEY", KEY)
    (here / ".env").write_text(f"ONSHAPE_SECRET_KEY={KEY}\n" if holder == "file" else "")
    write(here, pair=f"{PAIR}vars: {{a: {KEY}, b: '${{oc.env:ONSHAPE_SECRET_KEY,none}}'}}\n", other=PAIR)
    monkeypatch.chdir(here.parent)
    assert run(["snapshot", str(here)]) == 2
    out, err = capsys.readouterr()
    assert "E-SECRET" in err
    assert KEY not in out + err + "".join(kept(here).values())


@pytest.fixture(scope="module")
def bundle():
    """A bundle of the sample, and the address of its assembly."""
    data = bundle_bytes(sample_document())
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        root = json.loads(archive.read("manifest.json"))["root"]
    place = f"{root['document']}/w/0a1b2c3d4e5f60718293a4b5/e/{root['element']}"
    return data, f"https://cad.onshape.com/documents/{place}"


def test_onshape_robot_has_figures_where_its_bundle_is_kept(here, bundle, capsys):
    data, url = bundle
    onshape = f"{HEAD}defaults:\n  - override /source: onshape\nsource: {{url: '{url}'}}\n"
    (here / "robot" / "pair.yaml").unlink()
    write(here, arm=onshape, other=MY_ARM)
    experiment(here, wide="defaults:\n  - override /robot: arm\nground: {size: [9, 9]}\n")
    assert run(["snapshot"]) == 0
    assert section(kept(here)["arm.txt"], "figures") == {"source": "none"}
    (here / "snapshots" / "arm.zip").write_bytes(data)
    assert run(["snapshot", "--check"]) == 3
    assert "source: none → snapshots/arm.zip" in capsys.readouterr().err
    assert run(["snapshot"]) == 0
    figures = section(kept(here)["arm.txt"], "figures")
    assert (figures["links"], figures["loops"], figures["parts"]) == ("11", "1", "28")
    assert section(kept(here)["arm_wide.txt"], "figures") == figures
    assert section(kept(here)["arm.txt"], "configuration")["source.url"] == url
    (here / "snapshots" / "other.zip").write_bytes(data)
    assert run(["snapshot"]) == 2
    assert "a bundle of another assembly" in capsys.readouterr().err


def test_a_xacro_file_is_not_run(here):
    (here / "models" / "pair.urdf.xacro").write_text(URDF)
    write(here, pair=PAIR.replace("pair.urdf", "pair.urdf.xacro"))
    assert run(["snapshot"]) == 0
    assert section(kept(here)["pair.txt"], "figures") == {"source": "none"}


def test_the_robots_of_another_folder_are_built_as_if_run_there(here, monkeypatch):
    write(here / "more", extra=PAIR)
    assert run(["snapshot", "--config-dir", "more"]) == 0
    assert sorted(kept(here)) == ["extra.txt", "pair.txt"]
    run(["snapshot"])
    expected = kept(here)
    (here / "snapshots" / "pair.txt").unlink()
    monkeypatch.chdir(here.parent)
    assert run(["snapshot", f"{here.name}/robot/"]) == 0
    assert kept(here) == expected
    assert Path.cwd() == here.parent


@pytest.mark.parametrize(("arguments", "words"), [
    (["--chek"], "there is no option --chek"),
    (["a", "b"], "expected one folder, got 2"),
    (["nowhere"], "there is no folder nowhere"),
    (["pair"], "it takes a folder; without arguments all robots of ./robot are taken"),
    (["--config-dir"], "--config-dir needs a folder"),
    (["models"], "there is no robot"),
])  # fmt: skip
def test_wrong_usage_is_told(here, capsys, arguments, words):
    assert run(["snapshot", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_file_that_is_no_snapshot_stays(here, capsys):
    run(["snapshot"])
    file = here / "snapshots" / "pair.txt"
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    assert run(["snapshot", "--check"]) == 0
    file.write_text("mine\n")
    assert run(["snapshot"]) == 1
    assert "snapshots/pair.txt: it is not a snapshot" in capsys.readouterr().err
    assert kept(here) == {"pair.txt": "mine\n"}


@pytest.mark.slow
def test_bytes_are_the_same_with_any_hash_seed(tmp_path):
    texts = []
    for seed in ("0", "1", "77"):
        folder = write(tmp_path / f"at {seed}", arm=ARM)
        experiment(folder, wide='ground: {size: [9, 9]}\nvars: {a: "${oc.env:HOME}", text: "1"}\n')
        environ = {**environment(folder, seeded=False), "PYTHONHASHSEED": seed}
        done = linkwright(folder, "snapshot", environ=environ)
        assert done.returncode == 0, done.stderr
        texts.append(kept(folder))
        assert str(folder) not in "".join(kept(folder).values())
    assert texts[0] == texts[1] == texts[2]
    assert sorted(texts[0]) == ["arm.txt", "arm_wide.txt"]


VALUES = ["1", "true", "null", "[1]", "", " a ", "a\nb", "a: b", '"a', "\u2028", "ü", "${vars.a}", "1e5"]


def test_a_value_is_one_line_that_reads_as_it_alone(here):
    """Beside its value as another type, where it has one."""
    texts = {f"text_{number}": value for number, value in enumerate(VALUES)}
    other_values = {
        f"other_{number}": yaml.safe_load(value) if value in ("1", "true", "[1]") else "another"
        for number, value in enumerate(VALUES)
    }
    write(here, pair=PAIR + yaml.safe_dump({"vars": {"a": 0, **texts, **other_values}}))
    run(["snapshot"])
    configuration = section(kept(here)["pair.txt"], "configuration")
    entries = read_entries(kept(here)["pair.txt"])
    for number in range(len(VALUES)):
        line = configuration[f"vars.text_{number}"]
        assert (
            entries["configuration", f"vars.text_{number}"] == line != configuration[f"vars.other_{number}"]
        )


def test_offline_whoever_reaches_for_the_network_gets_an_error():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        with offline():
            with pytest.raises(Offline, match=f"127.0.0.1:{port}"):
                socket.create_connection(("127.0.0.1", port))
            with pytest.raises(Offline, match=r"example\.invalid"):
                socket.getaddrinfo("example.invalid", 443)
            if hasattr(socket, "AF_UNIX"):
                for end in socket.socketpair():
                    end.close()
        socket.create_connection(("127.0.0.1", port)).close()


def test_names_with_a_colon_hide_no_change():
    old, new = (
        f"linkwright snapshot 1\n\n[configuration]\nnames.links.Arm: left: {name}\n"
        "names.links.Arm: right: b\n"
        for name in ("a", "c")
    )
    assert differences(old, new) == [
        "1 key changed:", "  names.links.Arm: left: a; right: b → left: c; right: b",
    ]  # fmt: skip


def test_experiment_that_cannot_be_composed_keeps_its_snapshots(here):
    experiment(here, heavy="zero: saved\n")
    assert run(["snapshot"]) == 0
    snapshots = kept(here)
    experiment(here, heavy="zero: {saved\n")
    assert run(["snapshot"]) == 2
    assert kept(here) == snapshots
    (here / "experiment" / "heavy.yaml").unlink()
    assert run(["snapshot"]) == 0
    assert sorted(kept(here)) == ["pair.txt"]
