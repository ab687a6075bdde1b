"""Files that were written to run code, or to use up time, memory or a crash of what reads them: through the
real command each is one clear message, nothing of it runs, and nothing is left."""

import contextlib
import os
import signal
import socket
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest

from linkwright.stages.fetch.mjcf import gather
from linkwright.stages.fetch.urdf import expand
from tests.support.command import called, environment, linkwright, tree
from tests.support.mjcfs import model

pytestmark = pytest.mark.slow

XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
SECRET = "a-secret-of-the-environment"
ESCAPE = (
    "${(lambda: [c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"
    ".__init__.__globals__['system']('touch ran'))()}"
)
"""An expression that gets around xacro's filter and runs a shell command."""


SOON = 5
"""The time of a guest [s] where it is looked for that this time ends; a user's guest has a minute or two."""


def refused(here, *arguments, status=1, written="outputs", seconds=None):
    """What the command says of a source that it refuses: one error, and no trace of this computer.

    `seconds`: the time that a guest has, instead of the usual one.
    """
    before = tree(here)
    environ = environment(here, seeded=False, ONSHAPE_SECRET_KEY=SECRET, ONSHAPE_ACCESS_KEY=SECRET)
    options = ["until=graph", "name=r", *arguments]
    if seconds is None:
        done = linkwright(here, *options, environ=environ, timeout=400)
    else:
        with contextlib.ExitStack() as stack:
            for module in (expand, gather):
                bounds = replace(module.BOUNDS, seconds=seconds)
                stack.enter_context(patch.object(module, "BOUNDS", bounds))
            done = called(here, *options, environ=environ)
    shown = done.stdout + done.stderr
    assert done.returncode == status, shown
    assert len([line for line in done.stderr.splitlines() if line.startswith("error:")]) == 1, shown
    assert not [word for word in ("Traceback", SECRET, "root:", str(here)) if word in shown], shown
    assert {Path(path).parts[0] for path in tree(here) - before} <= {written}
    return done.stderr


# URDF and xacro.


@pytest.mark.parametrize(
    "inside",
    [
        f'<link name="{ESCAPE}"/>',
        '<link name="$(env ONSHAPE_SECRET_KEY)"/>',
        "<link name=\"${load_yaml('/etc/passwd')}\"/>",
        '<xacro:include filename="/etc/passwd"/><link name="a"/>',
        '<link name="a" xacro:if="1"/>',
    ],
)
@pytest.mark.parametrize(("name", "status"), [("r.urdf", 1), ("r.urdf.xacro", 2)])
def test_no_file_runs_that_nobody_trusts(tmp_path, inside, name, status):
    (tmp_path / name).write_text(f'<robot {XMLNS} name="r">{inside}</robot>')
    output_text = refused(tmp_path, "source=urdf", f"source.path={name}", status=status)
    assert "xacro FILE > robot.urdf" in output_text
    assert "source.trust=true" in output_text


@pytest.mark.parametrize(
    ("inside", "output_text"),
    [
        ('<link name="$(env ONSHAPE_SECRET_KEY)"/>', "ONSHAPE_SECRET_KEY"),
        ('<link name="${python.sum(python.range(10**12))}"/>', f"took longer than {SOON} s"),
        ('<link name="${len(str(10) * 5 * 10**9)}"/>', "needed more than 2.15 GB"),
        ('<link name="${str(10) * 10**8}"/>', "made more than 16.8 MB"),
        ("<xacro:macro name='m'><xacro:m/><xacro:m/></xacro:macro><xacro:m/>", "call themselves"),
        ('<link name="${(lambda: 1 and __import__)()}"/>', "xacro cannot expand it"),
        ("<link name=\"${load_yaml('/dev/zero')}\"/>", "xacro cannot expand it"),
        ("<xacro:include filename='x.pipe'/><link name='a'/>", f"took longer than {SOON} s"),
    ],
)
def test_what_is_trusted_has_bounds(tmp_path, inside, output_text):
    (tmp_path / "r.xacro").write_text(f'<robot {XMLNS} name="r">{inside}</robot>')
    os.mkfifo(tmp_path / "x.pipe")
    seconds = SOON if "longer" in output_text else None
    options = ["source=urdf", "source.path=r.xacro", "source.trust=true"]
    assert output_text in refused(tmp_path, *options, seconds=seconds)


# MJCF.

COPIES = '<worldbody><replicate count="{}">{}</replicate></worldbody>'
ATTACH = '<attach model="m" body="x" prefix="{}"/>'


def nest(depth):
    """Models in models, each in the one above twice: 2 to the power of `depth` bodies."""
    twice = ATTACH.format("a") + ATTACH.format("b")
    files = {
        f"m{i}.xml": f'<mujoco><asset><model name="m" file="m{i + 1}.xml"/></asset>'
        f'<worldbody><body name="x">{twice}</body></worldbody></mujoco>'
        for i in range(depth)
    }
    last = '<mujoco><worldbody><body name="x"><geom size=".1"/></body></worldbody></mujoco>'
    return {**files, f"m{depth}.xml": last}


@pytest.mark.parametrize(
    ("files", "output_text"),
    [
        ({"m0.xml": f'<mujoco><asset><model name="m" file="m0.xml"/></asset>'
                    f'<worldbody><body>{ATTACH.format("a")}</body></worldbody></mujoco>'}, "MuJoCo"),
        ({"m0.xml": model("", '<asset><mesh name="m" file="m0.xml"/></asset>')}, "MuJoCo cannot compile it"),
        ({"m0.xml": '<mujoco><include file="m0.xml"/></mujoco>'}, "MuJoCo cannot compile it"),
        (nest(26), "MuJoCo's compiler"),
        ({"m0.xml": "<mujoco>" + COPIES.format(20_000, "<body/>") + "</mujoco>"}, "come to 20000"),
        (
            {
                "m0.xml": '<mujoco><worldbody><replicate count="3000"><include file="i.xml"/></replicate>'
                "</worldbody></mujoco>",
                "i.xml": '<mujoco><replicate count="3000"><body><geom/></body></replicate></mujoco>',
            },
            f"MuJoCo's compiler took longer than {SOON} s",
        ),
        ({"m0.xml": model("<body/>", '<size nkey="2000000000"/>')}, "<size nkey>"),
        ({"m0.xml": model("<body/>", '<size nuser_geom="2000000000"/>')}, "<size nuser_geom>"),
        ({"m0.xml": model("<body/>", '<size memory="1000T"/>')}, "MuJoCo cannot compile it"),
        ({"m0.xml": model("<body/>", '<sensor><user dim="2000000000"/></sensor>')}, "<user dim>"),
        ({"m0.xml": model("<body/>", '<asset><hfield nrow="60000" ncol="60000"/></asset>')},
         "<hfield> has"),
        ({"m0.xml": model('<body><flexcomp type="grid" count="300 300 300"/></body>')},
         "come to 2.7e+07"),
        ({"m0.xml": model("<body>" * 20_000 + "</body>" * 20_000)}, "MuJoCo cannot compile it"),
        ({"m0.xml": model(f'<body name="{"a" * 30_000_000}"/>')}, "letters"),
        ({"m0.xml": model("<body/>" * 1_000_000)}, "1000000 bodies"),
        ({"m0.xml": model("<body/>", '<asset><mesh file="/proc/kmsg"/></asset>')}, "/proc/kmsg"),
        ({"m0.xml": model("<body/>", '<asset><mesh file="/dev/zero"/></asset>')}, "/dev/zero"),
        ({"m0.xml": model("<body/>", '<asset><mesh file="x.pipe"/></asset>')}, "x.pipe"),
        ({"m0.xml": model("<body/>", '<asset><texture file="x.socket"/></asset>')}, "x.socket"),
        ({"m0.xml": '<mujoco><include file="x.huge"/></mujoco>'}, "x.huge"),
    ],
    ids=lambda value: "",
)  # fmt: skip
def test_a_hostile_mjcf_is_one_error(tmp_path, files, output_text):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    _with_odd_files(tmp_path)
    seconds = SOON if "longer" in output_text else None
    assert output_text in refused(tmp_path, "source=mjcf", "source.path=m0.xml", seconds=seconds)


@pytest.mark.parametrize("name", ["/dev/zero", "/proc/kmsg", "x.pipe", "x.socket", "x.huge"])
def test_a_mesh_of_a_urdf_that_is_no_file_is_one_error(tmp_path, name):
    shape = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="a">{shape}</link></robot>')
    _with_odd_files(tmp_path)
    output_text = refused(tmp_path, "source=urdf", "source.path=r.urdf")
    assert "E-MESH" in output_text


@pytest.mark.parametrize("kind", ["urdf", "mjcf", "bundle"])
@pytest.mark.parametrize(
    ("name", "status"), [("/dev/zero", 2), ("x.pipe", 2), ("x.socket", 2), ("x.huge", 1), ("/proc/kmsg", 1)]
)
def test_a_source_that_is_no_file_is_one_error(tmp_path, kind, name, status):
    _with_odd_files(tmp_path)
    refused(tmp_path, f"source={kind}", f"source.path={name}", status=status)


def _with_odd_files(folder):
    os.mkfifo(folder / "x.pipe")
    here = Path.cwd()
    with socket.socket(socket.AF_UNIX) as server:
        os.chdir(folder)
        server.bind("x.socket")
        os.chdir(here)
    with (folder / "x.huge").open("wb") as file:
        file.truncate(1 << 42)


def test_an_interrupt_while_a_guest_works_leaves_nothing(tmp_path):
    """Ctrl-C in a terminal goes to the command alone: the guest is in a session of its own."""
    import subprocess
    import time

    from tests.support.command import COMMAND
    from tests.support.processes import gone

    (tmp_path / "r.xacro").write_text(
        f'<robot {XMLNS} name="r"><link name="${{python.sum(python.range(10**12))}}"/></robot>'
    )
    command = [str(COMMAND), "source=urdf", "source.path=r.xacro", "source.trust=true", "name=r"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment(tmp_path), stderr=subprocess.PIPE, text=True
    ) as run:
        until = time.monotonic() + 60
        while not (guests := _guests_of(run.pid)) and time.monotonic() < until:
            time.sleep(0.05)
        assert guests
        run.send_signal(signal.SIGINT)
        _, output_text = run.communicate(timeout=60)
    assert run.returncode == 130, output_text
    assert "Traceback" not in output_text
    # A guest that was about to start when the interrupt came ends by itself, a moment later.
    assert gone(guests)


def _guests_of(pid):
    """The guests of a process (Linux)."""
    pids = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(path.read_text().rpartition(")")[2].split()[1])
            line = (path.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if parent == pid and b"guestmain.py" in line:
            pids.append(int(path.parent.name))
    return pids
