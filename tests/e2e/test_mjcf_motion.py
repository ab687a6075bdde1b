"""The files written for an MJCF move as it does, in a scene with all that is in it."""

import mujoco
import numpy as np
import pytest

from tests.support.mjcfs import SOLID, built, model, written
from tests.support.same_motion import Pair, farthest

pytestmark = pytest.mark.usefixtures("guests_at_home", "no_score")

MASS = SOLID.format(mass=1)

SPRINGS = f"""<body name="base" pos="0 0 1">{MASS}
<joint name="swing" axis="0 1 0" stiffness="3" springref=".4" ref=".1" damping=".2" frictionloss=".05"
  armature=".01" range="-1 1" solreflimit=".03 .8" solimplimit=".8 .9 .01" margin=".02"/>
<body name="slider" pos=".3 0 0">{MASS}
<joint name="slide" type="slide" axis="1 0 0" stiffness="40" springref="-.02"/>
<body name="bob" pos="0 .2 0">{MASS}<joint name="ball" type="ball" stiffness="2" damping=".1"/>
</body></body></body>"""

FLUID = (
    '<option gravity=".5 0 -4" wind="1 0 0" density="1.2" viscosity=".02" integrator="RK4" timestep=".004">'
    '<flag eulerdamp="disable"/></option>'
)

TENDONS = f"""<site name="ceiling" pos="0 0 1.4"/><body name="base" pos="0 0 1">{MASS}
<joint name="shoulder" axis="0 1 0"/><geom name="pulley" type="cylinder" size=".05 .02" zaxis="0 1 0"/>
<site name="over" pos="0 0 .1"/>
<body name="fore" pos=".3 0 0">{MASS}<joint name="elbow" axis="0 1 0"/><site name="end" pos=".3 0 -.05"/>
</body></body>"""

TENDONS_MORE = """<tendon>
<fixed name="both" stiffness="4" springlength=".1" damping=".1" limited="true" range="-.5 .5">
  <joint joint="shoulder" coef="1"/><joint joint="elbow" coef="-.5"/></fixed>
<spatial name="cord" stiffness="60" springlength="0 .5" damping=".3"><site site="ceiling"/>
  <geom geom="pulley" sidesite="over"/><site site="end"/></spatial></tendon>
<actuator><general name="pull" tendon="cord" dyntype="filter" dynprm=".05" gainprm="20" biastype="affine"
  biasprm="0 -3 -.2" ctrlrange="-1 1" ctrllimited="true"/><motor name="twist" tendon="both" gear="3"/>
<position name="hold" joint="elbow" kp="8"/></actuator>
<sensor><tendonpos name="length" tendon="cord"/><actuatorfrc name="effort" actuator="pull"/>
<framepos name="at" objtype="body" objname="fore"/><framequat name="turn" objtype="xbody" objname="fore"/>
<framelinvel name="speed" objtype="body" objname="fore" reftype="xbody" refname="base"/></sensor>"""

LOOSE = f"""<geom name="floor" type="plane" size="3 3 .1" friction=".7 .01 .001" solref=".01 1"/>
<light name="sun" pos="0 0 3" dir="0 0 -1"/><camera name="front" pos="2 0 1" xyaxes="0 1 0 -.4 0 1"/>
<body name="arm" pos="0 0 .4">{MASS}<joint name="lift" axis="0 1 0" damping=".5"/>
<geom name="beam" type="capsule" fromto="0 0 0 .5 0 0" size=".03" condim="4" solimp=".95 .99 .002"/>
<camera name="wrist" pos=".5 0 .1" euler=".1 .2 .3"/><light name="lamp" pos=".2 0 0"/>
<site name="palm" pos=".5 0 0" type="box" size=".01 .02 .03"/></body>
<body name="ball" pos=".45 .01 .6"><freejoint name="ball"/>
  <geom name="ball" type="sphere" size=".05" mass=".2" priority="1"/></body>
<body name="door" pos="1 1 .5"><joint name="hinge" axis="0 0 1" damping=".1"/>
  <geom size=".1 .2 .3" type="box"/></body><body name="target" mocap="true" pos="0 0 1"/>"""

ROUND = f"""<geom name="floor" type="plane" size="3 3 .1"/>
<body name="trunk" pos="0 0 .3"><freejoint name="root"/>
<geom name="egg" type="ellipsoid" size=".1 .15 .2" mass="2"/>
<body name="leg" pos=".2 0 0">{MASS}<joint name="hip" axis="0 1 0" range="-.6 .6"/>
<geom name="foot" type="ellipsoid" size=".05 .1 .05" pos=".1 0 -.05" euler="0 .3 0" friction="1.4"/>
</body></body>"""

BITS = f"""<geom name="floor" type="plane" size="3 3 .1" contype="4" conaffinity="4"/>
<body name="base" pos="0 0 .3">{MASS}<freejoint/><geom name="a" size=".1" contype="4" conaffinity="2"/>
<body name="b" pos="0 0 .3">{MASS}<joint name="jb" axis="0 1 0"/><geom name="b" size=".1" contype="1"
  conaffinity="4"/>
<body name="c" pos="0 0 .3">{MASS}<joint name="jc" axis="1 0 0"/><geom name="c" size=".1" contype="0"
  conaffinity="0"/>
<body name="d" pos="0 0 .15">{MASS}<joint name="jd" axis="0 1 0" range="-2 2"/>
<geom name="d" size=".08" contype="2" conaffinity="1"/></body></body></body></body>"""

TIES = f"""<body name="base" pos="0 0 1">{MASS}<joint name="j" axis="0 1 0"/>
<body name="left" pos=".2 0 0">{MASS}<joint name="l" axis="0 1 0"/><site name="tip"/></body>
<body name="right" pos="-.2 0 0">{MASS}<joint name="r" axis="0 1 0"/></body></body>
<body name="hung" pos=".2 .3 1">{MASS}<joint name="h" axis="1 0 0"/></body>"""

TIES_MORE = """<equality><joint name="curve" joint1="l" joint2="r" polycoef="0 .5 .3 0 0" solref=".03 1"/>
<connect name="bond" body1="left" body2="hung" anchor="0 .15 0" solref=".04 .9" solimp=".8 .9 .01"/>
</equality>"""

CASES = {
    "springs": (SPRINGS, ""),
    "fluid": (SPRINGS, FLUID),
    "tendons": (TENDONS, TENDONS_MORE),
    "loose": (LOOSE, '<actuator><motor name="lift" joint="lift"/></actuator>'),
    "ellipsoids": (ROUND, '<actuator><position name="hip" joint="hip" kp="20"/></actuator>'),
    "bits": (
        BITS,
        '<contact><pair geom1="a" geom2="c" condim="4" friction=".5"/>'
        '<exclude body1="b" body2="d"/></contact>',
    ),
    "ties": (TIES, TIES_MORE),
}


@pytest.mark.parametrize("case", CASES)
def test_the_scene_of_an_mjcf_moves_as_the_file(case, tmp_path):
    """For a second, without controls and with some, each joint's value to 1e-9; named bodies, geoms, sites,
    cameras and lights, and what sensors read, after a tenth of a second."""
    world, more = CASES[case]
    path = written(tmp_path, model(world, more))
    reported, failed = built(path, tmp_path / "out")
    original, made = (mujoco.MjModel.from_xml_path(str(file)) for file in (path, tmp_path / "out/scene.xml"))
    assert (original.nv, original.nu, original.ntendon) == (made.nv, made.nu, made.ntendon)
    assert farthest(original, made).off < 1e-9
    assert not [problem.message for problem in reported if problem.code == "W-MJCF-LEFT"]
    assert not failed
    was, now = Pair(original, made).start(-1)
    for data, compiled in ((was, original), (now, made)):
        mujoco.mj_step(compiled, data, round(0.1 / compiled.opt.timestep))
        mujoco.mj_forward(compiled, data)
    for kind in ("body", "geom", "site", "camera", "light"):
        prefix = {"body": "x", "camera": "cam_x", "light": "light_x"}.get(kind, f"{kind}_x")
        for number in range(_count(original, kind)):
            if name := getattr(original, kind)(number).name:
                place = getattr(made, kind)(name).id
                there, here = getattr(was, f"{prefix}pos")[number], getattr(now, f"{prefix}pos")[place]
                assert np.allclose(there, here, atol=1e-9), (kind, name)
    for number in range(original.nsensor):
        name = original.sensor(number).name
        assert np.allclose(was.sensor(name).data, now.sensor(name).data, atol=1e-7), name


def _count(loaded, kind):
    return int(getattr(loaded, {"camera": "ncam"}.get(kind, f"n{kind}")))
