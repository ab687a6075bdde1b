"""Limits out of lists of features, where the definition has none."""

import dataclasses
import json
import math

import pytest

from linkwright.stages.fetch.bundle.archive import read
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.replies.recorded import RecordedAnswers
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.onshape.assembly import Assembly, Mate
from linkwright.stages.graph.onshape.mates.limits import with_limits
from linkwright.stages.robot.bundle import ElementKey, Features, OnshapeBundle
from linkwright.stages.robot.model.dofs import AS_TYPED
from linkwright.stages.robot.model.robot import MateRef
from tests.fake_onshape.replies import Replies
from tests.fake_onshape.settable import typed_arm
from tests.support.building import plan_of, robot_of
from tests.support.kit import ON
from tests.support.recorded import KBOT, kbot_definition, kbot_masses, needs_data, pack
from tests.support.reported import reports

THIRTY = math.radians(30)


def recorded(definition, replies):
    return gather(RecordedAnswers(read(pack(definition, replies), "recording"), "recording"))


def arm_replies(change=None, old=False, variables=True, **typed):
    """The arm's definition without limits, and its replies; `change` edits the root's features."""
    document = typed_arm(**typed)
    server, here = Replies(document, newest=16, old=old), f"/d/{document.id}/m/{document.microversion}"
    answers = {}
    for assembly in document.assemblies:
        base = f"{here}/e/{assembly.element}"
        body = json.loads(server.answer(f"/assemblies{base}/features", "").body)
        if change and assembly is document.root:
            change(body)
        answers[f"/assemblies{base}/features?configuration=default"] = json.dumps(body).encode()
        if variables:
            there = base.replace(f"/m/{document.microversion}", f"/w/{document.workspace}")
            query = "includeValuesAndReferencedVariables=true"
            kept = f"/variables{base}/variables?configuration=default&{query}"
            answers[kept] = server.answer(f"/variables{there}/variables", query).body
    for studio in document.studios:
        path = f"/partstudios{here}/e/{studio.element}/massproperties"
        query = "massAsGroup=false&useMassPropertyOverrides=true"
        answers[f"{path}?configuration=default&{query}"] = server.answer(path, query).body
    path = f"/assemblies{here}/e/{document.root.element}"
    return server.answer(path, "includeMateFeatures=true&includeMateConnectors=true").body, answers


def arm(change=None, keys=None, **how):
    return build_robot(recorded(*arm_replies(change, **how)), plan_of(**(keys or {})))


def limits(robot):
    return {dof.name: (dof.limits.lower, dof.limits.upper) for dof in robot.dofs}


def limit_warnings(robot):
    return {d.where: d.message for d in robot.diagnostics if d.code == "W-LIMIT"}


def parameter(body, mate, name):
    """A parameter of a mate in a list of features, in either envelope."""
    records = [feature.get("message", feature) for feature in body["features"]]
    entry = next(record for record in records if record["name"] == mate)
    inside = [element.get("message", element) for element in entry["parameters"]]
    return next(entry for entry in inside if entry["parameterId"] == name)


HIGH = 2 * THIRTY + math.radians(15)


@pytest.mark.parametrize("old", [True, False])
def test_typed_limits_are_read_in_both_envelopes_at_any_depth(old):
    robot = arm(old=old)
    assert limit_warnings(robot) == {}
    assert limits(robot)["turn"] == pytest.approx((-THIRTY, HIGH))
    assert limits(robot)["push"] == pytest.approx((0.0, 0.0127))
    assert limits(robot)["curl"] == (pytest.approx(-THIRTY), None)


def off(body):
    parameter(body, "Turn", "limitsEnabled")["value"] = False


def drop(body):
    body["features"] = [feature for feature in body["features"] if feature["name"] != "Turn"]


UNKNOWN = ("limitAxialZMin is '-#Reach'", "limitAxialZMax is '2 * #Reach + 15 deg'", "#Reach is not known")


@pytest.mark.parametrize(
    ("how", "turn", "words"),
    [
        ({"change": off}, (None, None), ["the joint has no limits: it turns freely"]),
        ({"change": drop}, (None, None), ["are unknown: the list of features lacks this mate"]),
        ({"low": "-5 mm"}, (None, HIGH), ["limitAxialZMin is '-5 mm'", "expected an angle, got a length"]),
        ({"low": "90 deg", "high": "-90 deg"}, (None, None), ["1.5708 is above its upper limit -1.5708"]),
        ({"variables": False}, (None, None), UNKNOWN),
        ({"variables": False, "keys": {"joints": {"turn": {"limits": [-1, 1]}}}}, (-1, 1), None),
    ],
    ids=["off", "dropped", "a length", "crossed", "without variables", "the user's"],
)
def test_limits_that_are_not_known_are_none_and_reported(how, turn, words):
    robot = arm(**how)
    assert limits(robot)["turn"] == (turn[0], turn[1] if turn[1] is None else pytest.approx(turn[1]))
    assert limits(robot)["push"] == pytest.approx((0.0, 0.0127))
    warnings = limit_warnings(robot)
    assert warnings.keys() == {*(["curl"] if "variables" in how else []), *(["turn"] if words else [])}
    assert not words or [word for word in words if word not in warnings["turn"]] == []


def test_joints_of_a_missing_list_are_reported():
    definition, replies = arm_replies()
    masses = {request: body for request, body in replies.items() if "massproperties" in request}
    warnings = limit_warnings(build_robot(recorded(definition, masses), plan_of()))
    assert warnings.keys() == {"turn", "push", "curl"}
    assert all("the list of features is missing" in message for message in warnings.values())


def configured(text, change=None):
    """The arm in this configuration."""
    definition, replies = arm_replies(change)
    data = json.loads(definition)
    data["rootAssembly"]["fullConfiguration"] = text
    return build_robot(recorded(json.dumps(data).encode(), replies), plan_of())


@pytest.mark.parametrize(
    ("settings", "upper"),
    [("size=Small", 20), ("size=Large", 70), ("open=true;size=Small", 20), ("size=Medium", None)],
)
def test_a_configured_limit_is_the_one_of_this_configuration(settings, upper):
    def by_size(body):
        mate = next(feature for feature in body["features"] if feature["name"] == "Turn")
        at = [entry["parameterId"] for entry in mate["parameters"]].index("limitAxialZMax")
        kind, value = "BTMConfiguredValueByEnum-1923", mate["parameters"][at]
        mate["parameters"][at] = {
            "btType": "BTMParameterConfigured-2222",
            "parameterId": "limitAxialZMax",
            "configurationParameterId": "size",
            "values": [
                {"btType": kind, "enumValue": option, "value": {**value, "expression": expression}}
                for option, expression in (("Small", "20 deg"), ("Large", "#Reach + 40 deg"))
            ],
        }

    robot = configured(settings, by_size)
    if upper is None:
        assert "nothing fits size = 'Medium'" in limit_warnings(robot)["turn"]
    else:
        assert limits(robot)["turn"][1] == pytest.approx(math.radians(upper))


def test_a_value_of_the_configuration_is_the_first_variable():
    robot = configured("Reach=10+deg")
    assert limits(robot)["turn"][0] == pytest.approx(math.radians(-10))
    assert limits(robot)["curl"][0] == pytest.approx(-THIRTY)


def test_limits_of_the_definition_are_used_where_it_has_them():
    document = typed_arm()
    definition, replies = arm_replies()
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}"
    bundle = recorded(Replies(document).answer(path, "includeMateFeatures=true").body, replies)
    assert bundle.features == ()
    old = build_robot(recorded(definition, replies), plan_of())
    settled = limits(build_robot(bundle, plan_of()))
    assert {name: pytest.approx(pair) for name, pair in limits(old).items()} == settled


OF_TYPE = {
    "REVOLUTE": ["AxialZMin", "AxialZMax"],
    "SLIDER": ["ZMin", "ZMax"],
    "CYLINDRICAL": ["ZMin", "ZMax", "AxialZMin", "AxialZMax"],
    "PIN_SLOT": ["XMin", "XMax", "AxialZMin", "AxialZMax"],
    "PLANAR": ["XMin", "XMax", "YMin", "YMax", "AxialZMin", "AxialZMax"],
    "PARALLEL": ["XMin", "XMax", "YMin", "YMax", "ZMin", "ZMax", "AxialZMin", "AxialZMax"],
    "BALL": ["EulerConeAngleMax"],
    "FASTENED": [],
}
TYPED = {
    "XMin": "10 mm", "XMax": "15 mm", "YMin": "20 mm", "YMax": "25 mm", "ZMin": "30 mm", "ZMax": "35 mm",
    **{f"Axial{side}{end}": "90 deg" for side in "XYZ" for end in ("Min", "Max")},
    "EulerConeAngleMax": "45 deg",
}  # fmt: skip
"""What a list of features says of any mate: all limits, whatever its type."""

UNITS = {"deg": math.radians(1), "mm": 0.001}


def in_si(typed):
    """The limits of these texts in SI, by the names of the API."""
    pairs = {name: text.split() for name, text in typed.items()}
    return {f"limit{name}": pytest.approx(float(n) * UNITS[unit]) for name, (n, unit) in pairs.items()}


def resolved(kind, typed, copies=("",), more=None):
    """Mates of this type in the root, whose list of features gives these limits; `more`: by name, what
    else their parameters say."""
    root = {"documentId": "d", "documentMicroversion": "m", "elementId": "e"}
    parameters = [
        {"parameterId": f"limit{name}", "expression": text, **(more or {}).get(name, {})}
        for name, text in typed.items()
    ]
    parameters += [{"parameterId": "limitsEnabled", "value": True}, {"expression": "7 m"}]
    body = {"features": [{"featureId": "f", "parameters": parameters}]}
    blobs, features = {"list": json.dumps(body).encode()}, (Features(ElementKey.of(root), "list"),)
    bundle = OnshapeBundle("onshape", {}, "", {}, blobs, api="v17", studios=(), features=features)
    mates = [Mate(MateRef((), "f", "Mate", kind, copy), "Mate", (), None) for copy in copies]
    return list(with_limits(Assembly(root=root, mates=mates), bundle).mates)


@pytest.mark.parametrize("kind", OF_TYPE)
def test_a_type_takes_the_limits_of_its_own_freedoms(kind):
    (mate,) = resolved(kind, TYPED)
    assert mate.limit_origin == AS_TYPED
    assert (mate.limits or {}) == in_si({name: TYPED[name] for name in OF_TYPE[kind]})


def test_a_length_is_no_cone():
    (mate,) = resolved("BALL", {"EulerConeAngleMax": "45 mm"})
    assert mate.limits == {}
    assert "limitEulerConeAngleMax is '45 mm'" in mate.limit_origin.unknown


def test_copies_of_a_mate_take_its_limits():
    mates = resolved("SLIDER", {"ZMin": "1 mm", "ZMax": "#lost"}, copies=("", "I1", "I2"))
    assert [mate.limits for mate in mates] == [{"limitZMin": pytest.approx(0.001)}] * 3
    assert all("#lost" in mate.limit_origin.unknown for mate in mates)


def sided(kind, side):
    """The limits of which only this `side` (Min or Max) was typed, and what the untouched say."""
    unit = {name: "deg" if "A" in name else "mm" for name in OF_TYPE[kind]}
    typed = {name: f"{index + 1} {unit[name]}" for index, name in enumerate(OF_TYPE[kind])}
    untouched = {name: f"0 {unit[name]}" for name in typed if not name.endswith(side)}
    empty = {"Min": "No minimum", "Max": "No maximum"}
    said = {
        name: {"isNull": False, "nullValue": empty[name[-3:]] if name in untouched else "", "value": 0.0}
        for name in typed
    }
    return {**typed, **untouched}, said


@pytest.mark.parametrize("side", ["Min", "Max", "Neither"])
@pytest.mark.parametrize("kind", OF_TYPE)
def test_untyped_limits_are_open_on_every_type_of_mate(kind, side):
    typed, said = sided(kind, side)
    (mate,) = resolved(kind, typed, more=said)
    want = in_si({name: text for name, text in typed.items() if name.endswith(side)})
    assert (mate.limits or {}) == want
    origin = mate.limit_origin
    assert (bool(origin.unknown), len(origin.open)) == (False, 0 if kind == "BALL" else len(want))
    assert not origin.doubts


EMPTY = {"isNull": False, "nullValue": "No maximum"}


@pytest.mark.parametrize(
    ("text", "more", "upper", "reason"),
    [
        *((zero, EMPTY, None, "open") for zero in ("0 deg", "0 mm", "0 in", "0.0*mm", "0", "0.000 rad")),
        *((zero, EMPTY, None, "open") for zero in ("", '0"', "0°")),
        *(
            (text, EMPTY, q, "doubts")
            for text, q in (("5 mm", 0.005), ("0 mm + 0 mm", 0), ("2 * 3 mm", 0.006))
        ),
        *(("0 mm", more, 0.0, "") for more in ({}, {"isNull": False, "nullValue": ""})),
        ("5 mm", {"isNull": True}, None, ""),
    ],
)
def test_a_limit_is_what_was_typed(text, more, upper, reason):
    """A zero beside a field that calls itself empty was not; an expression there counts with a doubt."""
    (mate,) = resolved("SLIDER", {"ZMin": "-3 mm", "ZMax": text}, more={"ZMax": more})
    ends = {"limitZMin": -0.003} | ({} if upper is None else {"limitZMax": upper})
    assert mate.limits == {name: pytest.approx(end) for name, end in ends.items()}
    if reason:
        (words,) = getattr(mate.limit_origin, reason)
        assert f"limitZMax is {text!r} beside 'No maximum'" in words
    else:
        assert mate.limit_origin == AS_TYPED


def test_a_doubtful_limit_is_reported_until_yaml_resolves_it():
    def contradict(body):
        parameter(body, "Push", "limitZMax")["nullValue"] = "No maximum"
        parameter(body, "Push", "limitZMin")["nullValue"] = "No minimum"

    def about(robot):
        return sorted(reports(robot, "W-LIMIT-DOUBT") + reports(robot, "I-LIMIT-OPEN"))

    robot = arm(contradict)
    assert limits(robot)["push"] == (None, pytest.approx(0.0127))
    assert about(robot) == [("I-LIMIT-OPEN", "curl"), ("I-LIMIT-OPEN", "push"), ("W-LIMIT-DOUBT", "push")]
    hint = next(d.hint for d in robot.diagnostics if d.code == "W-LIMIT-DOUBT")
    assert hint.endswith("joints: {push: {limits: [low, high]}}")
    settled = arm(contradict, keys={"joints": {"push": {"limits": [0, 0.01]}}})
    assert limits(settled)["push"] == (0, 0.01)
    assert about(settled) == [("I-LIMIT-OPEN", "curl")]


def test_limits_that_nobody_typed_lock_no_dof(kit):
    """A slider that is open above, and mates of several dofs of which one was typed, as any may be."""
    base, *arms = (kit.place(f"Bar {n}") for n in range(5))
    root, free = kit.root, (None, None)
    root.slider("Lift", (arms[0], ON), (base, ON), limits=(-0.0736, None))
    root.cylindrical("Axle", (arms[1], ON), (base, ON), limits=(free, (None, 1)))
    root.planar("Table", (arms[2], ON), (base, ON), limits=((0, 0.1), free, free))
    root.parallel("Glide", (arms[3], ON), (base, ON), limits=(free, free, (None, 2), (-1, 1)))
    old = robot_of(kit.document, newest=16)
    assert limits(old) == limits(robot_of(kit.document))
    assert limits(old)["lift"] == (-0.0736, None)
    assert reports(old, "W-LIMIT-LOCKED") == reports(old, "W-SAVED-POSE") == []


@needs_data
def test_the_kbot_has_its_limits_where_its_variables_are_known():
    """Twenty limits, each an expression with a variable and a stale 0 beside it."""
    definition = kbot_definition()
    data = json.loads(definition)
    bodies = [file.read_bytes() for file in KBOT.glob("features_*.json")]
    lists = {json.loads(body)["sourceMicroversion"]: body for body in bodies}
    replies = {}
    for record in (data["rootAssembly"], *data["subAssemblies"]):
        version = record["documentMicroversion"]
        where = f"/assemblies/d/{record['documentId']}/m/{version}/e/{record['elementId']}"
        replies[f"{where}/features?configuration=default"] = lists[version]
    bundle = recorded(definition, {**kbot_masses(), **replies})
    assert len(bundle.features) == 2
    unknown = limit_warnings(build_robot(bundle, plan_of()))
    assert len(unknown) == 20
    assert all("the variable #" in message for message in unknown.values())
    assert any("'-#LHipPitchNeg'" in message for message in unknown.values())

    typed = expressions_of(bodies)
    names = sorted({text.lstrip("-#") for pair in typed.values() for text in pair})
    values = {name: 10.0 + index for index, name in enumerate(names)}
    rows = [
        {"name": name, "type": "ANGLE", "expression": f"{value} deg", "value": ""}
        for name, value in values.items()
    ]
    supplied = dataclasses.replace(
        bundle,
        features=tuple(dataclasses.replace(feature, variables="tables") for feature in bundle.features),
        blobs={**bundle.blobs, "tables": json.dumps([{"variables": rows}]).encode()},
    )
    robot = build_robot(supplied, plan_of())
    by_name = {joint.mate.feature: limits(robot)[joint.name] for joint in robot.joints}
    assert len(by_name) == 20
    for feature, pair in typed.items():
        low, high = ((-1 if text[0] == "-" else 1) * math.radians(values[text.lstrip("-#")]) for text in pair)
        # One elbow is bounded by a variable that must be negative.
        assert by_name[feature] == (pytest.approx((low, high)) if low <= high else (None, None))


def expressions_of(bodies):
    """Feature id → (lower, upper) as typed, of every mate with limits, straight from the recordings."""
    typed = {}
    for feature in (entry["message"] for body in bodies for entry in json.loads(body)["features"]):
        entries = [entry["message"] for entry in feature.get("parameters", ())]
        by_id = {entry["parameterId"]: entry for entry in entries}
        if by_id.get("limitsEnabled", {}).get("value"):
            ends = ("limitAxialZMin", "limitAxialZMax")
            typed[feature["featureId"]] = [by_id[name]["expression"] for name in ends]
    return typed
