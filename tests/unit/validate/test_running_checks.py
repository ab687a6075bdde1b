"""The checks that simulate: closed forms of what they measure, and a planted fault for each."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.geometry import Geometry, Touch
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras
from linkwright.stages.robot.model.poses import from_parts
from linkwright.stages.robot.model.scene import Ground, Scene
from linkwright.stages.validate import measured
from linkwright.stages.validate.checks.contact import start
from linkwright.stages.validate.checks.simulation import control_noise, energy, rest, time_step
from linkwright.stages.validate.simulate.energy import SECONDS, Drift, drift_of_energy
from linkwright.stages.validate.simulate.noise import control_ranges
from linkwright.stages.validate.simulate.running import touching
from tests.support.compiled import only, world_of
from tests.support.robots import joint, robot_with

GRAVITY = 9.81


def pendulum(mass=1.0, length=0.5, moment=1e-3, joint=""):
    """A body that hangs along -z, on a hinge about y."""
    return (
        f'<body name="bob" pos="0 0 2"><joint name="swing" axis="0 1 0" {joint}/>'
        f'<inertial mass="{mass}" pos="0 0 {-length}" diaginertia="{moment} {moment} {moment}"/></body>'
    )


def test_pendulum_keeps_its_energy():
    verdict = only(energy.check(world_of(pendulum())), "energy")
    assert verdict.passed
    assert 0.0 < verdict.value < 1e-6


def test_drift_of_a_short_pendulum_is_that_of_runge_and_kutta():
    """Small swings are those of a linear oscillator, whose energy the method of fourth order multiplies in
    each step by 1 - z⁶/72 + z⁸/576, z = ω h."""
    length = 1e-4
    compiled = world_of(pendulum(length=length, moment=1e-13))
    (first, whole), (second, halved), *_ = drift_of_energy(compiled.model).by_step
    for step, drift in ((first, whole), (second, halved)):
        z = math.sqrt(GRAVITY / length) * step
        kept = (1 - z**6 / 72 + z**8 / 576) ** round(SECONDS / step)
        # The largest kinetic energy is that of the start: the pendulum starts where it hangs.
        assert drift == pytest.approx((1 - kept) / SECONDS, rel=0.02)
    assert whole > 1e-6
    assert whole / halved > 8
    assert only(energy.check(compiled), "energy").passed


@pytest.mark.parametrize("kind", ["hinge", "ball"])
def test_chain_that_tumbles_keeps_its_energy(kind):
    links = "".join(
        f'<body name="b{n}" pos=".3 0 0"><joint name="j{n}" type="{kind}"/>'
        '<inertial mass=".5" pos=".1 .02 .03" diaginertia=".001 .002 .0025"/>'
        for n in range(3)
    )
    free = '<body name="b"><freejoint name="f"/><inertial mass="1" pos=".1 0 0" diaginertia=".01 .02 .03"/>'
    verdict = only(energy.check(world_of(free + links + "</body>" * 4)), "energy")
    assert verdict.passed
    assert verdict.value > 0.0


def test_inertia_of_nothing_is_an_error():
    """Its swings, √(g / l) = 990 rad/s, are too fast for a sixteenth of the step, where ω h is 3.1."""
    more = '<option timestep="0.05"/>'
    verdict = only(energy.check(world_of(pendulum(length=1e-5, moment=1e-13), more=more)), "energy")
    assert verdict.fails
    assert verdict.findings[0].attribute == "timestep"


def test_energy_that_is_not_finite_is_an_error():
    """The finer steps must not make it the integrator's own error: no infinity is an eighth of another."""
    compiled = world_of(pendulum())
    compiled.model.opt.gravity[:] = math.nan
    assert not drift_of_energy(compiled.model).is_conserved
    assert not Drift(((0.002, math.inf), (0.001, math.inf))).is_conserved


def test_force_that_takes_energy_is_an_error(monkeypatch):
    """A damper that is left in: the energy falls by 2 · ½ b ω² per second, where ½ I ω² is the most."""
    monkeypatch.setattr("linkwright.stages.validate.simulate.energy.PASSIVE", ())
    text = pendulum(length=0.0, moment=1.0, joint='damping="0.01"')
    verdict = only(energy.check(world_of(text)), "energy")
    assert verdict.fails
    assert verdict.value == pytest.approx((1 - math.exp(-0.02 * SECONDS)) / SECONDS, rel=1e-6)


def test_what_takes_energy_by_design_is_left_out_and_put_back():
    option = '<option integrator="implicitfast" density="1.2" viscosity="1"/>'
    more = option + '<actuator><motor joint="swing"/></actuator>'
    joint = 'damping="1" frictionloss=".1" stiffness="3" range="-.01 .01" limited="true"'
    compiled = world_of(pendulum(joint=joint), more=more)
    model = compiled.model
    before = (model.opt.integrator, model.opt.timestep, model.opt.disableflags, model.opt.enableflags)
    assert only(energy.check(compiled), "energy").passed
    assert before == (model.opt.integrator, model.opt.timestep, model.opt.disableflags, model.opt.enableflags)


BALLS = (
    '<geom name="floor" type="plane" size="1 1 1"/>'
    '<body name="low" pos="0 0 {low}"><freejoint/><geom type="sphere" size=".1"/></body>'
    '<body name="high" pos="0 0 {high}"><joint type="slide" axis="0 0 1"/>'
    '<geom type="sphere" size=".1"/></body>'
)


@pytest.mark.parametrize(
    ("low", "high", "depths"),
    [(0.0996, 0.2992, {}), (0.0994, 0.3, {("low", "the ground"): 0.6}), (0.1, 0.293, {("high", "low"): 7.0})],
)
def test_start_deeper_than_half_a_millimetre_is_an_error(low, high, depths):
    (result,) = start.check(world_of(BALLS.format(low=low, high=high)))
    assert result.passed == (not depths)
    assert result.fails == bool(depths)
    for (body, other), depth in depths.items():
        assert result.value == pytest.approx(1e-3 * depth, abs=1e-9)
        (finding,) = result.findings
        assert finding.element == f'body "{body}"'
        assert f"{depth:g} mm inside {other}" in finding.message


def test_contact_of_a_flex_is_that_of_no_body():
    cloth = (
        '<flexcomp name="cloth" type="grid" count="3 3 1" spacing=".1 .1 .1" radius=".01" mass="1" dim="2">'
        '<edge equality="true"/></flexcomp>'
    )
    model = world_of(BALLS.format(low=3, high=5) + cloth).model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon
    assert touching(model, data) == []


HOME = '<keyframe><key name="home" qpos="0 0 {} 1 0 0 0 0"/></keyframe>'


def test_at_qpos0_it_is_a_warning_where_there_is_a_home():
    compiled = world_of(BALLS.format(low=0.05, high=0.4), more=HOME.format(0.1))
    assert only(start.check(compiled), "start at home").passed
    assert only(start.check(compiled), "start at qpos0").warns


@pytest.mark.parametrize("fixed", [True, False])
def test_base_in_the_ground_is_an_error_unless_it_is_fixed(fixed):
    compiled = world_of(BALLS.format(low=0.1, high=0.4), robot_with([], fixed=fixed), more=HOME.format(0.05))
    verdict = only(start.check(compiled), "start at home")
    assert (verdict.fails, verdict.warns) == (not fixed, fixed)
    assert "50 mm inside the ground" in verdict.findings[0].message


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize(
    ("thing", "called"),
    [
        ('<geom name="crate" type="box" size=".1 .1 .1" pos="0 0 .05"/>', 'geom "crate"'),
        ('<geom type="box" size=".1 .1 .1" pos="0 0 .05"/>', "a geom of the world"),
        (
            '<body name="crate"><geom type="box" size=".1 .1 .1" pos="0 0 .05"/></body>',
            'body "crate" of the scene',
        ),
    ],
)
def test_obstacle_is_an_error_and_named_whatever_the_base(thing, called, fixed):
    robot = robot_with([], fixed=fixed)
    text = BALLS.format(low=0.1, high=0.4).replace('name="low"', f'name="{robot.root.name}"')
    compiled = world_of(thing + text, robot, more=HOME.format(0.1))
    verdict = only(start.check(compiled), "start at home")
    assert verdict.fails
    assert [finding.element for finding in verdict.findings] == [f'body "{robot.root.name}"']
    assert f"mm inside {called}: move it in scene.xml" in verdict.findings[0].message
    assert called in verdict.detail


def test_contact_as_reported_is_a_warning_and_deeper_an_error():
    text, more = BALLS.format(low=0.1, high=0.293), HOME.format(0.1)
    for depth, fails in ((0.007, False), (0.003, True)):
        geometry = Geometry((), {}, touching=(Touch("low", "high", depth),))
        verdict = only(start.check(world_of(text, more=more, geometry=geometry)), "start at home")
        assert (verdict.fails, verdict.warns) == (fails, not fails)


STANDING = {
    "as its source has it": (MjcfExtras(), (0.0, 0.0, 0.0), None),
    "elsewhere": (MjcfExtras(), (0.0, 0.0, -0.01), None),
    "on a ground that is not the source's": (MjcfExtras(), (0.0, 0.0, 0.0), Ground(np.eye(4), (1, 0, 0))),
    "as a robot whose source is no MJCF": (None, (0.0, 0.0, 0.0), None),
}


@pytest.mark.parametrize("how", STANDING)
def test_what_its_source_has_so_is_a_warning(how):
    """The sphere is 50 mm in a plane of the world: a robot that stands so in its MJCF, stands so."""
    extras, place, ground = STANDING[how]
    robot = replace(robot_with([], fixed=False), mjcf=extras)
    root = from_parts(np.eye(3), np.array(place))
    scene = Scene(root, (("home", root),), ground)
    compiled = world_of(BALLS.format(low=0.1, high=0.4), robot, more=HOME.format(0.05), scene=scene)
    verdict = only(start.check(compiled), "start at home")
    in_source = how == "as its source has it"
    assert (verdict.warns, verdict.fails) == (in_source, not in_source)


SERVO = (
    '<actuator><position name="servo" joint="swing" kp="{kp}" kv="{kv}"/></actuator>'
    '<keyframe><key name="home" qpos="{q}" ctrl="{q}"/></keyframe>'
)


def test_servo_sags_by_the_weight_over_its_stiffness():
    """At rest kp · sag is the torque of the weight, m g l sin(q)."""
    kp, q, sag = 100.0, 1.0, 0.0
    for _ in range(50):
        sag = 0.5 * GRAVITY * math.sin(q - sag) / kp
    verdict = only(rest.check(world_of(pendulum(), more=SERVO.format(kp=kp, kv=20, q=q))), "rests at home")
    assert verdict.passed
    assert verdict.value == pytest.approx(sag / rest.MAX_SAG, rel=1e-3)


def test_servo_that_is_too_weak_is_a_warning():
    weak = world_of(pendulum(), more=SERVO.format(kp=5, kv=5, q=1.0))
    verdict = only(rest.check(weak), "rests at home")
    assert verdict.warns
    assert verdict.findings[0].element == 'actuator "servo"'


def test_actuator_of_a_tendon_does_not_hold_the_joint_of_its_number():
    other = '<body name="other" pos="0 3 2"><joint name="slack"/><geom size=".1"/></body>'
    more = '<tendon><fixed name="rope"><joint joint="slack" coef="1"/></fixed></tendon>'
    more += '<actuator><motor name="winch" tendon="rope"/></actuator>'
    more += '<keyframe><key name="home" qpos="1 0"/></keyframe>'
    robot = robot_with([joint("revolute", "base", "bob")])
    verdict = only(rest.check(world_of(pendulum() + other, robot, more=more)), "rests at home")
    assert {finding.element for finding in verdict.findings} == {'joint "swing"'}


@pytest.mark.parametrize("ground", [True, False])
def test_undriven_joint_and_falling_base_are_warnings(ground):
    """A base can stand only where something carries it: without a ground it floats in space."""
    swing = pendulum().replace("bob", "other").replace("swing", "idle").replace('0 1 0"', '0 1 0" ref="60"')
    base = '<body name="base" pos="5 0 1"><freejoint name="base"/><geom type="sphere" size=".1"/></body>'
    text = pendulum() + swing.replace('pos="0 0 -0.5"', 'pos="-0.5 0 0"') + base
    text += '<geom type="plane" size="1 1 1" pos="0 0 -9"/>' if ground else ""
    more = '<actuator><position joint="swing" kp="100" kv="20"/></actuator>'
    robot = robot_with([joint("revolute", "base", name) for name in ("bob", "other")])
    without_name = text.replace('name="base"/>', "/>")
    for whole, base in ((text, 'joint "base"'), (without_name, 'joint of body "base"')):
        verdict = only(rest.check(world_of(whole, robot, more=more)), "rests at home")
        assert verdict.warns
        assert {finding.element for finding in verdict.findings} == {'joint "idle"', *[base] * ground}


def test_what_lies_beside_the_robot_need_not_rest():
    ball = '<body name="ball" pos="5 0 1"><freejoint/><geom type="sphere" size=".1"/></body>'
    robot = robot_with([joint("revolute", "base", "bob")])
    ground = '<geom type="plane" size="1 1 1" pos="0 0 -9"/>'
    for beside, rests in ((ball, True), (ball.replace("ball", "base"), False)):
        more = SERVO.format(kp=1000, kv=20, q=0.0).replace('qpos="0.0"', 'qpos="0 5 0 1 1 0 0 0"')
        compiled = world_of(pendulum() + beside + ground, robot, more=more)
        assert only(rest.check(compiled), "rests at home").passed == rests


def shaky(kv):
    """An arm with a servo; damping that is not integrated implicitly is unstable above 2 I / step."""
    option = '<option integrator="Euler" timestep="0.002"/>'
    joint = 'limited="true" range="-60 60"'
    return world_of(pendulum(joint=joint), more=option + SERVO.format(kp=50, kv=kv, q=0.0))


def test_servo_that_noise_blows_up_is_an_error_though_it_rests():
    """The inertia about the joint is 0.251 kg m²: above 251 N m s/rad steps of 2 ms overshoot."""
    assert only(control_noise.check(shaky(5.0)), "control noise").passed
    compiled = shaky(400.0)
    assert only(rest.check(compiled), "rests at home").passed
    verdict = only(control_noise.check(compiled), "control noise")
    assert verdict.fails
    assert verdict.findings[0].element == 'joint "swing"'
    # Each run has the same noise.
    first, again = (control_noise.run_with_noise(compiled.model, 1.0) for _ in range(2))
    assert first == again


def test_noise_fills_the_range_of_each_control():
    more = (
        '<actuator><motor joint="swing" ctrlrange="-3 5"/><position joint="swing" kp="1"/>'
        '<motor joint="swing"/></actuator>'
    )
    compiled = world_of(pendulum(joint='range="-90 30" limited="true"'), more=more)
    ranges = control_ranges(compiled.model)
    assert ranges.tolist() == [[-3, 5], [pytest.approx(-math.pi / 2), pytest.approx(math.pi / 6)], [-1, 1]]


@pytest.mark.parametrize(
    ("limits", "ends"),
    [
        ((-1e6, 2.0), (2.0 - math.tau, 2.0)),
        ((-1.0, 1e6), (-1.0, math.tau - 1.0)),
        ((-1e6, 1e6), (-math.pi, math.pi)),
    ],
)
def test_servo_whose_joint_has_no_limit_on_a_side_gets_a_turn(limits, ends):
    """What the MJCF has for an open end, ±1e6 rad, is no target for a servo."""
    more = '<compiler angle="radian"/><actuator><position joint="swing" kp="1"/></actuator>'
    joint = f'range="{limits[0]} {limits[1]}" limited="true"'
    compiled = world_of(pendulum(joint=joint), more=more)
    assert control_ranges(compiled.model)[0].tolist() == pytest.approx(ends)


def spring(stiffness):
    """A mass of 1 kg on a spring without damping, away from where it rests."""
    text = (
        '<body name="b"><joint name="s" type="slide" axis="1 0 0" stiffness="1" springref=".1"/>'
        '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body>'
    )
    compiled = world_of(text, more='<option timestep="0.002" integrator="Euler"/>')
    compiled.model.jnt_stiffness[0] = stiffness
    return compiled


@pytest.mark.parametrize(("speed", "passes"), [(400.0, True), (600.0, False)])
def test_spring_that_double_the_step_misses_is_a_warning(speed, passes):
    """The symplectic step holds while ω h is below 2: at 4 ms up to 500 rad/s."""
    checks = list(time_step.check(spring(speed**2)))
    assert only(checks, "half the time step").passed
    double = only(checks, "double the time step")
    assert double.passed == passes
    assert double.warns == (not passes)


def test_what_blows_up_at_half_the_step_is_an_error():
    """A spring that pushes away grows as exp(ω t), whatever the step."""
    verdict = only(time_step.check(spring(-(200.0**2))), "half the time step")
    assert verdict.fails
    assert verdict.findings[0].element == 'joint "s"'
    assert verdict.findings[0].message.startswith("its ")


@pytest.mark.parametrize("check", [energy.check, rest.check, control_noise.check, time_step.check])
def test_what_cannot_move_is_not_simulated(check):
    assert list(check(world_of('<body name="b"><geom size="1"/></body>'))) == []


def test_speed_is_measured_of_the_scene_with_strict_alone(tmp_path):
    (tmp_path / "scene.xml").write_text(f"<mujoco><worldbody>{pendulum()}</worldbody></mujoco>")
    (tmp_path / "arm.xml").write_text("<mujoco/>")
    measures = measured(tmp_path, "arm", "strict")
    assert set(measures) == {"steps_per_second"}
    assert measures["steps_per_second"] > 0
    assert measured(tmp_path, "arm", "standard") == {}


@pytest.mark.parametrize("text", [None, "<mujoco/>", "<mujoco><worldbody><body/></mujoco>"])
def test_what_does_not_move_or_compile_has_no_speed(text, tmp_path):
    if text is not None:
        (tmp_path / "arm.xml").write_text(text)
    assert measured(tmp_path, "arm", "strict") == {}
