"""Limits out of lists of features, where the definition has none."""

import dataclasses
import json
import math

import pytest

from linkwright.stages.fetch.bundle.archive import read
from linkwright.stages.fetch.onshape.gather import gather
from linkwright.stages.fetch.onshape.replies.recorded import Recorded
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.onshape.assembly import Assembly, Mate
from linkwright.stages.graph.onshape.mates.limits import with_limits
from linkwright.stages.robot.bundle import Features, OnshapeBundle, StudioKey
from linkwright.stages.robot.model.dofs import AS_TYPED
from linkwright.stages.robot.model.robot import MateRef, Robot
from tests.fake_onshape.replies import Replies
from tests.fake_onshape.settable import typed_arm
from tests.support.building import plan_of, robot_of
from tests.support.kit import ON, Kit
from tests.support.recorded import KBOT, kbot_definition, kbot_masses, needs_data, pack

THIRTY = math.radians(30)


def features_request(record: dict) -> str:
    """The request that a definition's root or sub-assembly is asked for its features by."""
    where = f"/assemblies/d/{record['documentId']}/m/{record['documentMicroversion']}/e/{record['elementId']}"
    return f"{where}/features?configuration=default"


def recorded(definition: bytes, replies: dict[str, bytes]) -> OnshapeBundle:
    return gather(Recorded(read(pack(definition, replies), "recording"), "recording"))


def arm_replies(change=None, old: bool = False, variables: bool = True, **typed) -> tuple[bytes, dict]:
    """The arm's definition without limits, and its replies; `change` edits the root's features."""
    document = typed_arm(**typed)
    server = Replies(document, newest=16, old=old)
    answers = {}
    for assembly in document.assemblies:
        base = f"/d/{document.id}/m/{document.microversion}/e/{assembly.element}"
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
        path = f"/partstudios/d/{document.id}/m/{document.microversion}/e/{studio.element}/massproperties"
        query = "massAsGroup=false&useMassPropertyOverrides=true"
        answers[f"{path}?configuration=default&{query}"] = server.answer(path, query).body
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}"
    definition = server.answer(path, "includeMateFeatures=true&includeMateConnectors=true").body
    return definition, answers


def arm(change=None, keys=None, **how) -> Robot:
    return build_robot(recorded(*arm_replies(change, **how)), plan_of(**(keys or {})))


def limits(robot: Robot) -> dict[str, tuple]:
    return {dof.name: (dof.limits.lower, dof.limits.upper) for dof in robot.dofs}


def told(robot: Robot) -> dict[str, str]:
    return {d.where: d.message for d in robot.diagnostics if d.code == "W-LIMIT"}


def parameter(body: dict, mate: str, name: str) -> dict:
    """A parameter of a mate in a list of features, in either envelope."""
    records = [feature.get("message", feature) for feature in body["features"]]
    found = next(record for record in records if record["name"] == mate)
    inside = [one.get("message", one) for one in found["parameters"]]
    return next(one for one in inside if one["parameterId"] == name)


@pytest.mark.parametrize("old", [True, False])
def test_typed_limits_are_read_in_both_envelopes_at_any_depth(old: bool) -> None:
    robot = arm(old=old)
    assert told(robot) == {}
    found = limits(robot)
    assert found["turn"] == pytest.approx((-THIRTY, 2 * THIRTY + math.radians(15)))
    assert found["push"] == pytest.approx((0.0, 0.0127))
    assert found["curl"] == (pytest.approx(-THIRTY), None)


def test_the_number_beside_an_expression_is_not_believed() -> None:
    def stale(body: dict) -> None:
        assert parameter(body, "Turn", "limitAxialZMax")["value"] == 0.0
        parameter(body, "Turn", "limitAxialZMax")["value"] = 9.0

    assert limits(arm(stale))["turn"][1] == pytest.approx(2 * THIRTY + math.radians(15))


def test_limits_that_are_switched_off_are_none() -> None:
    def off(body: dict) -> None:
        parameter(body, "Turn", "limitsEnabled")["value"] = False

    robot = arm(off)
    assert limits(robot)["turn"] == (None, None)
    assert told(robot) == {"turn": "the joint has no limits: it turns freely"}


def test_a_variable_that_nobody_gives_is_named_with_its_expression() -> None:
    robot = arm(variables=False)
    assert limits(robot)["turn"] == (None, None)
    assert limits(robot)["push"] == pytest.approx((0.0, 0.0127))
    assert told(robot).keys() == {"turn", "curl"}
    message = told(robot)["turn"]
    assert "limitAxialZMin is '-#Reach'" in message
    assert "limitAxialZMax is '2 * #Reach + 15 deg'" in message
    assert "the variable #Reach is not known" in message


def test_what_the_user_says_resolves_limits_that_are_not_known() -> None:
    robot = arm(variables=False, keys={"joints": {"turn": {"limits": [-1, 1]}}})
    assert limits(robot)["turn"] == (-1, 1)
    assert told(robot).keys() == {"curl"}


def test_a_length_is_no_angle() -> None:
    robot = arm(low="-5 mm")
    assert limits(robot)["turn"] == (None, pytest.approx(2 * THIRTY + math.radians(15)))
    assert "limitAxialZMin is '-5 mm'" in told(robot)["turn"]
    assert "expected an angle, got a length" in told(robot)["turn"]


def test_limits_the_wrong_way_round_are_left_out_and_reported() -> None:
    robot = arm(low="90 deg", high="-90 deg")
    assert limits(robot)["turn"] == (None, None)
    assert "its lower limit 1.5708 lies above the upper one, -1.5708" in told(robot)["turn"]


def test_a_mate_that_the_list_lacks_is_reported() -> None:
    def drop(body: dict) -> None:
        body["features"] = [one for one in body["features"] if one["name"] != "Turn"]

    assert told(arm(drop)) == {"turn": "its limits in CAD are unknown: the list of features lacks this mate"}


def test_without_a_list_every_joint_of_it_is_reported() -> None:
    definition, replies = arm_replies()
    masses = {request: body for request, body in replies.items() if "massproperties" in request}
    robot = build_robot(recorded(definition, masses), plan_of())
    assert told(robot).keys() == {"turn", "push", "curl"}
    assert all("the list of features is missing" in message for message in told(robot).values())


@pytest.mark.parametrize(
    ("settings", "upper"), [("size=Small", 20), ("size=Large", 70), ("open=true;size=Small", 20)]
)
def test_a_configured_limit_is_the_one_of_this_configuration(settings: str, upper: float) -> None:
    def configured(body: dict) -> None:
        mate = next(one for one in body["features"] if one["name"] == "Turn")
        at = [one["parameterId"] for one in mate["parameters"]].index("limitAxialZMax")
        value = mate["parameters"][at]
        by_enum = [
            {
                "btType": "BTMConfiguredValueByEnum-1923",
                "enumValue": option,
                "value": {**value, "expression": expression},
            }
            for option, expression in (("Small", "20 deg"), ("Large", "#Reach + 40 deg"))
        ]
        mate["parameters"][at] = {
            "btType": "BTMParameterConfigured-2222",
            "parameterId": "limitAxialZMax",
            "configurationParameterId": "size",
            "values": by_enum,
        }

    definition, replies = arm_replies(configured)
    data = json.loads(definition)
    data["rootAssembly"]["fullConfiguration"] = settings
    robot = build_robot(recorded(json.dumps(data).encode(), replies), plan_of())
    assert limits(robot)["turn"][1] == pytest.approx(math.radians(upper))
    data["rootAssembly"]["fullConfiguration"] = "size=Medium"
    robot = build_robot(recorded(json.dumps(data).encode(), replies), plan_of())
    assert "nothing fits size = 'Medium'" in told(robot)["turn"]


def test_a_value_of_the_configuration_is_a_variable_before_any_other() -> None:
    definition, replies = arm_replies()
    data = json.loads(definition)
    data["rootAssembly"]["fullConfiguration"] = "Reach=10+deg"
    robot = build_robot(recorded(json.dumps(data).encode(), replies), plan_of())
    assert limits(robot)["turn"][0] == pytest.approx(math.radians(-10))
    assert limits(robot)["curl"][0] == pytest.approx(-THIRTY)


def test_limits_of_the_definition_are_used_where_it_has_them() -> None:
    document = typed_arm()
    server = Replies(document)
    definition, replies = arm_replies()
    path = f"/assemblies/d/{document.id}/m/{document.microversion}/e/{document.root.element}"
    resolved = server.answer(path, "includeMateFeatures=true").body
    bundle = recorded(resolved, replies)
    assert bundle.features == ()
    found = build_robot(bundle, plan_of())
    old = build_robot(recorded(definition, replies), plan_of())
    assert {name: pytest.approx(pair) for name, pair in limits(old).items()} == limits(found)


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
EVERY = {
    "XMin": "10 mm",
    "XMax": "15 mm",
    "YMin": "20 mm",
    "YMax": "25 mm",
    "ZMin": "30 mm",
    "ZMax": "35 mm",
    **{f"Axial{side}{end}": "90 deg" for side in "XYZ" for end in ("Min", "Max")},
    "EulerConeAngleMax": "45 deg",
}
"""What a list of features says of any mate: all limits, whatever its type."""


def resolved(kind: str, typed: dict[str, str], copies=("",), more=None) -> list[Mate]:
    """Mates of this type in the root, whose list of features gives these limits; `more`: by name, what
    else their parameters say."""
    root = {"documentId": "d", "documentMicroversion": "m", "elementId": "e"}
    parameters = [
        {"parameterId": f"limit{name}", "expression": text, **(more or {}).get(name, {})}
        for name, text in typed.items()
    ]
    parameters += [{"parameterId": "limitsEnabled", "value": True}, {"expression": "7 m"}]
    body = {"features": [{"featureId": "f", "parameters": parameters}]}
    bundle = OnshapeBundle(
        kind="onshape",
        api="v17",
        root={},
        definition="",
        studios=(),
        requests={},
        blobs={"list": json.dumps(body).encode()},
        features=(Features(StudioKey.of(root), "list"),),
    )
    mates = [Mate(MateRef((), "f", "Mate", kind, copy), "Mate", (), None) for copy in copies]
    return list(with_limits(Assembly(root=root, mates=mates), bundle).mates)


@pytest.mark.parametrize("kind", OF_TYPE)
def test_each_type_takes_the_limits_of_its_own_freedoms(kind: str) -> None:
    (mate,) = resolved(kind, EVERY)
    assert mate.limit_origin == AS_TYPED
    want = {"X": (0.010, 0.015), "Y": (0.020, 0.025), "Z": (0.030, 0.035)}
    quarter, cone = math.radians(90), math.radians(45)
    every = {f"{side}{end}": pair[end == "Max"] for side, pair in want.items() for end in ("Min", "Max")}
    every |= {"AxialZMin": quarter, "AxialZMax": quarter, "EulerConeAngleMax": cone}
    assert (mate.limits or {}) == {f"limit{name}": pytest.approx(every[name]) for name in OF_TYPE[kind]}


def test_a_length_is_no_cone() -> None:
    (mate,) = resolved("BALL", {"EulerConeAngleMax": "45 mm"})
    assert mate.limits == {}
    assert "limitEulerConeAngleMax is '45 mm'" in mate.limit_origin.unknown


def test_copies_of_a_mate_take_its_limits() -> None:
    mates = resolved("SLIDER", {"ZMin": "1 mm", "ZMax": "#lost"}, copies=("", "I1", "I2"))
    assert [mate.limits for mate in mates] == [{"limitZMin": pytest.approx(0.001)}] * 3
    assert all("#lost" in mate.limit_origin.unknown for mate in mates)


def sided(kind: str, side: str) -> tuple[dict[str, str], dict[str, dict]]:
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
def test_what_nobody_typed_is_open_on_every_type_of_mate(kind: str, side: str) -> None:
    typed, said = sided(kind, side)
    (mate,) = resolved(kind, typed, more=said)
    scale = {"deg": math.radians(1), "mm": 0.001}
    want = {
        f"limit{name}": pytest.approx(float(text.split()[0]) * scale[text.split()[1]])
        for name, text in typed.items()
        if name.endswith(side)
    }
    assert (mate.limits or {}) == want
    assert not mate.limit_origin.unknown
    assert len(mate.limit_origin.open) == (0 if kind == "BALL" else len(want))
    assert not mate.limit_origin.doubts


@pytest.mark.parametrize("zero", ["0 deg", "0 mm", "0 in", "0.0*mm", "0", "0.000 rad", "", '0"', "0°"])
def test_a_zero_in_any_unit_is_untouched_where_the_field_calls_itself_empty(zero: str) -> None:
    typed, more = {"ZMin": "-3 mm", "ZMax": zero}, {"ZMax": {"isNull": False, "nullValue": "No maximum"}}
    (mate,) = resolved("SLIDER", typed, more=more)
    assert mate.limits == {"limitZMin": pytest.approx(-0.003)}
    (text,) = mate.limit_origin.open
    assert f"limitZMax is {zero!r} beside 'No maximum'" in text


@pytest.mark.parametrize("empty", ["", None])
def test_a_zero_that_was_typed_is_a_limit(empty: str | None) -> None:
    more = {} if empty is None else {"ZMax": {"isNull": False, "nullValue": empty}}
    (mate,) = resolved("SLIDER", {"ZMin": "-3 mm", "ZMax": "0 mm"}, more=more)
    assert mate.limits == {"limitZMin": pytest.approx(-0.003), "limitZMax": 0.0}
    assert mate.limit_origin == AS_TYPED


def test_what_is_null_is_open_whatever_it_holds() -> None:
    (mate,) = resolved("SLIDER", {"ZMin": "1 mm", "ZMax": "5 mm"}, more={"ZMax": {"isNull": True}})
    assert mate.limits == {"limitZMin": pytest.approx(0.001)}
    assert mate.limit_origin == AS_TYPED


@pytest.mark.parametrize("text", ["5 mm", "0 mm + 0 mm", "2 * 3 mm"])
def test_an_expression_counts_beside_a_field_that_calls_itself_empty_with_a_word_about_it(text: str) -> None:
    (mate,) = resolved("SLIDER", {"ZMax": text}, more={"ZMax": {"nullValue": "No maximum"}})
    assert set(mate.limits or {}) == {"limitZMax"}
    (said,) = mate.limit_origin.doubts
    assert f"limitZMax is {text!r} beside 'No maximum'" in said


def test_a_doubtful_limit_is_reported_until_yaml_resolves_it() -> None:
    def contradict(body: dict) -> None:
        parameter(body, "Push", "limitZMax")["nullValue"] = "No maximum"
        parameter(body, "Push", "limitZMin")["nullValue"] = "No minimum"

    def about(robot: Robot) -> list[tuple[str, str]]:
        return [(d.code, d.where) for d in robot.diagnostics if d.code in ("W-LIMIT-DOUBT", "I-LIMIT-OPEN")]

    robot = arm(contradict)
    assert limits(robot)["push"] == (None, pytest.approx(0.0127))
    told = [("I-LIMIT-OPEN", "curl"), ("I-LIMIT-OPEN", "push"), ("W-LIMIT-DOUBT", "push")]
    assert sorted(about(robot)) == told
    hint = next(d.hint for d in robot.diagnostics if d.code == "W-LIMIT-DOUBT")
    assert hint.endswith("joints: {push: {limits: [low, high]}}")
    settled = arm(contradict, keys={"joints": {"push": {"limits": [0, 0.01]}}})
    assert limits(settled)["push"] == (0, 0.01)
    assert about(settled) == [("I-LIMIT-OPEN", "curl")]


def test_no_dof_is_locked_by_limits_that_nobody_typed() -> None:
    """A slider that is open above, and mates of several dofs of which one was typed, as any may be."""
    kit = Kit()
    base, *arms = (kit.place(f"Bar {n}") for n in range(5))
    root = kit.root
    root.slider("Lift", (arms[0], ON), (base, ON), limits=(-0.0736, None))
    root.cylindrical("Axle", (arms[1], ON), (base, ON), limits=((None, None), (None, 1)))
    root.planar("Table", (arms[2], ON), (base, ON), limits=((0, 0.1), (None, None), (None, None)))
    root.parallel("Glide", (arms[3], ON), (base, ON), limits=((None, None), (None, None), (None, 2), (-1, 1)))
    old = robot_of(kit.document, newest=16)
    assert limits(old) == limits(robot_of(kit.document))
    assert limits(old)["lift"] == (-0.0736, None)
    assert [d.code for d in old.diagnostics if d.code in ("W-LIMIT-LOCKED", "W-SAVED-POSE")] == []


@needs_data
def test_the_kbot_has_its_limits_where_its_variables_are_known() -> None:
    """Twenty limits, each an expression with a variable and a stale 0 beside it."""
    definition = kbot_definition()
    data = json.loads(definition)
    lists = {
        json.loads(file.read_bytes())["sourceMicroversion"]: file.read_bytes()
        for file in KBOT.glob("features_*.json")
    }
    records = [data["rootAssembly"], *data["subAssemblies"]]
    replies = {features_request(one): lists[one["documentMicroversion"]] for one in records}
    bundle = recorded(definition, {**kbot_masses(), **replies})
    assert len(bundle.features) == 2
    nothing = build_robot(bundle, plan_of())
    unknown = told(nothing)
    assert len(unknown) == 20
    assert all("the variable #" in message for message in unknown.values())
    assert any("'-#LHipPitchNeg'" in message for message in unknown.values())

    typed = expressions_of(lists.values())
    names = sorted({text.lstrip("-#") for pair in typed.values() for text in pair})
    values = {name: 10.0 + index for index, name in enumerate(names)}
    tables = json.dumps(
        [
            {
                "variables": [
                    {"name": name, "type": "ANGLE", "expression": f"{value} deg", "value": ""}
                    for name, value in values.items()
                ]
            }
        ]
    ).encode()
    supplied = dataclasses.replace(
        bundle,
        features=tuple(dataclasses.replace(one, variables="tables") for one in bundle.features),
        blobs={**bundle.blobs, "tables": tables},
    )
    robot = build_robot(supplied, plan_of())
    found = {joint.mate.feature: limits(robot)[joint.name] for joint in robot.joints}
    assert len(found) == 20
    for feature, pair in typed.items():
        want = [
            (-1 if text.startswith("-") else 1) * math.radians(values[text.lstrip("-#")]) for text in pair
        ]
        if want[0] <= want[1]:
            assert found[feature] == pytest.approx(tuple(want))
        else:  # one elbow is bounded by a variable that must be negative
            assert found[feature] == (None, None)


def expressions_of(bodies) -> dict[str, list[str]]:
    """Feature id → (lower, upper) as typed, of every mate with limits, straight from the recordings."""
    typed = {}
    for body in bodies:
        for feature in (one["message"] for one in json.loads(body)["features"]):
            named = {one["message"]["parameterId"]: one["message"] for one in feature.get("parameters", ())}
            if named.get("limitsEnabled", {}).get("value"):
                typed[feature["featureId"]] = [
                    named[name]["expression"] for name in ("limitAxialZMin", "limitAxialZMax")
                ]
    return typed
