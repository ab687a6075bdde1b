"""The configuration of an assembly: what is sent, what it costs, and what is refused."""

import json

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from linkwright.stages.fetch.bundle.archive import pack
from linkwright.stages.fetch.onshape import configuration
from linkwright.stages.fetch.onshape.configuration import encode_settings
from linkwright.stages.formats.onshape_configuration import (
    decode_value,
    encode_value,
    join_configuration,
    split_configuration,
)
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.errors import ConfigError, Offline, ProtocolError, SourceError
from tests.fake_onshape import settings
from tests.fake_onshape.server import OnshapeServer
from tests.fake_onshape.settable import GRIPPER, LABEL, LEG, MIRRORED, configured_stand, stand
from tests.fake_onshape.settings import Choice, Size
from tests.support.building import plan_of
from tests.support.kept import ADDRESS, Kept, fetched, onshape
from tests.support.traffic import targets_of

COUNT = Size("count", "Count", "3", 1, 9, unit="", measure="INTEGER")
RATIO = Size("ratio", "Ratio", "0.5", 0, 1, unit="", measure="REAL")
TILT = Size("tilt", "Tilt", "10 deg", -90, 90, unit="degree", measure="ANGLE")
FORCE = Size("force", "Force", "10 newton", -1e308, 1.7e308, unit="newton", measure="FORCE")
TWINS = [Choice("t1", "Twin", {"a": "same", "b": "same"}), Choice("t2", "Twin", {"x": "x"})]
EVERY = [LEG, GRIPPER, MIRRORED, LABEL, COUNT, RATIO, TILT, FORCE, *TWINS]


def parameters(which=EVERY):
    return configuration.read_parameters(json.dumps(settings.reply(which, "0" * 24)).encode())


def weights(made):
    robot = build_robot(made.bundle, plan_of())
    return {link.name: round(link.inertial.mass, 9) for link in robot.links}


@pytest.mark.parametrize(
    ("wanted", "text"),
    [
        ({}, "default"),
        ({"Gripper": "wide grip"}, "List_g=Wide_1"),
        ({"List_g": "Wide_1"}, "List_g=Wide_1"),
        ({"Gripper": "Wide_1"}, "List_g=Wide_1"),
        ({"Mirrored": True}, "mirrored=true"),
        ({"mirrored": "false"}, "mirrored=false"),
        ({"Leg length": "0.25 m"}, "leg_length=0.25+m"),
        ({"Leg length": "250mm"}, "leg_length=250.0+mm"),
        ({"leg_length": 0.25}, "leg_length=0.25+m"),
        ({"leg_length": "0.25"}, "leg_length=0.25+m"),
        ({"leg_length": "900 mm"}, "leg_length=900.0+mm"),
        ({"leg_length": "0.9 m"}, "leg_length=0.9+m"),
        ({"tilt": 1.5}, "tilt=1.5+rad"),
        ({"tilt": "-90 deg"}, "tilt=-90.0+deg"),
        ({"count": 4}, "count=4"),
        ({"count": 4.0}, "count=4"),
        ({"ratio": "0.25"}, "ratio=0.25"),
        ({"force": "12 lbf"}, "force=12.0+lbf"),
        ({"force": 12}, "force=12.0+newton"),
        ({"label": "a=b;c 1+1 100%"}, "label=a%3Db%3Bc+1%2B1+100%25"),
        ({"Label": "x", "Leg length": "1 ft"}, "leg_length=1.0+ft;label=x"),
        ({"t2": "x"}, "t2=x"),
    ],
)
def test_values_become_onshapes_text_in_the_documents_order(wanted, text):
    assert encode_settings("default", wanted, parameters()) == text
    assert all(decode_value(encode_value(value)) == value for value in map(str, wanted.values()))


def test_the_address_is_the_base_and_is_kept_word_for_word():
    base = "unknown=a%2Bb;List_g=_narrow;leg_length=0.2+meter"
    text = encode_settings(base, {"Gripper": "wide grip"}, parameters())
    assert text == "leg_length=0.2+meter;List_g=Wide_1;unknown=a%2Bb"
    assert join_configuration(split_configuration(base)) == base


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"Leg lengh": "1 m"}, ("no such parameter", "did you mean Leg length? it has: Leg length, Gripper")),
        ({"Gripper": "Wide"}, ("'Wide' is not allowed", "allowed: narrow, wide grip")),
        ({"Gripper": True}, ("must be one of the options", "allowed: narrow, wide grip")),
        ({"t1": "same"}, ("2 options have this label, so name one by its id: a, b", "")),
        ({"Twin": "x"}, ("2 parameters have this name", "use the id: t1, t2")),
        ({"Mirrored": "yes"}, ("must be true or false (given 'yes')", "allowed: true, false")),
        ({"leg_length": "1 deg"}, ("must be a length, and deg is the unit of an angle", "")),
        ({"leg_length": "1 parsec"}, ("unknown unit 'parsec'", "")),
        ({"leg_length": "long"}, ("must be a number with its unit", "from 50 millimeter to 900 millimeter")),
        ({"leg_length": "1e999 m"}, ("must be a number with its unit", "")),
        ({"leg_length": True}, ("must be a number (given true)", "")),
        ({"leg_length": "49 mm"}, ("49 mm is too small", "from 50 millimeter")),
        ({"leg_length": 1}, ("1 m is too large", "to 900 millimeter")),
        ({"tilt": 3}, ("3 rad is too large", "to 90 degree")),
        ({"count": 2.5}, ("must be a whole number", "allowed: a whole number from 1 to 9")),
        ({"count": 12}, ("12 is too large", "")),
        ({"ratio": "1 m"}, ("must be a plain number", "")),
        ({"label": 7}, ("must be text (given 7): quote it", "allowed: text")),
        ({"label": "a", "Label": "b"}, ("the parameter is given twice, by name and by id", "")),
    ],
)
def test_values_that_a_parameter_cannot_have_are_reported(wanted, words):
    with pytest.raises(SourceError) as caught:
        encode_settings("default", wanted, parameters())
    (problem,) = caught.value.problems
    assert words[0] in problem.message
    assert words[1] in problem.hint
    assert problem.where.startswith("source.configuration.")


def test_all_mistakes_are_reported_before_the_definition():
    with OnshapeServer(configured_stand()) as server:
        keys = onshape(
            server.document_url(), configuration={"Gripper": "Wide", "Leg length": 12, "nothing": 1}
        )
        with pytest.raises(SourceError, match="allowed: narrow, wide grip") as caught:
            fetched(keys, environ=server.environ)
        wrong = [problem.where.rpartition(".")[2] for problem in caught.value.problems]
        assert (wrong, server.count) == (["Gripper", "Leg length", "nothing"], 1)


def test_old_envelopes_and_kinds_that_are_not_known_are_read():
    old = [
        {"typeName": record["btType"].rpartition("-")[0], "message": record | {"parameterType": None}}
        for record in settings.reply([LEG, GRIPPER], "0" * 24)["configurationParameters"]
    ]
    new = {"btType": "BTMConfigurationParameterHologram-1", "parameterId": "holo"}
    body = json.dumps({"configurationParameters": [*old, new]}).encode()
    kinds = {parameter.id: parameter.kind for parameter in configuration.read_parameters(body)}
    assert kinds == {"leg_length": "Quantity", "List_g": "Enum", "holo": "String"}


@pytest.mark.parametrize("body", [b"{", b"[]", b"{}", b'{"configurationParameters": [{}]}'])
def test_a_reply_that_is_no_list_of_parameters_is_refused(body):
    with pytest.raises(ProtocolError):
        configuration.read_parameters(body)


def test_a_configuration_costs_one_call_at_first(kept):
    with OnshapeServer(configured_stand()) as server:
        plain = fetched(onshape(server.document_url()), environ=server.environ)
        assert (plain.calls, targets_of(server, "/configuration")) == (7, [])
        server.reset()
        keys = onshape(server.document_url(), configuration={"Leg length": "0.4 m", "Gripper": "wide grip"})
        cold = fetched(keys, kept, server.environ)
        # Parameters, definition, three studios.
        assert cold.calls == server.count == 2 + 2 * 3
        assert cold.bundle.root["configuration"] == "leg_length=0.4+m;List_g=Wide_1"
        assert weights(cold) == {"base": 0.8, "leg": 0.36, "jaw": 0.025}
        again = fetched(keys, kept, server.environ)
        assert (again.calls, again.bundle) == (1, cold.bundle)
        # Another one of the same document: its definition, and the studio that differs.
        keys = onshape(server.document_url(), configuration={"Leg length": "0.4 m"})
        other = fetched(keys, kept, server.environ)
        assert other.calls == 1 + 2
        assert weights(other) == {"base": 0.8, "leg": 0.36, "jaw": 0.004}


def test_parameters_of_a_pinned_document_are_asked_for_once():
    with OnshapeServer(configured_stand()) as server:
        for kind in "vm":
            kept, keys = Kept(), onshape(server.document_url(kind), configuration={"Gripper": "wide grip"})
            assert fetched(keys, kept, server.environ).calls == 8
            assert fetched(keys, kept, {}).calls == 0


def test_the_address_alone_configures_without_a_call_for_it():
    with OnshapeServer(configured_stand()) as server:
        url = server.document_url() + "?configuration=leg_length%3D0.4%2Bm%3BList_g%3DWide_1"
        made = fetched(onshape(url), environ=server.environ)
        assert made.calls == 7
        assert made.bundle.root["configuration"] == "leg_length=0.4+m;List_g=Wide_1"
        assert weights(made) == {"base": 0.8, "leg": 0.36, "jaw": 0.025}
        over = fetched(onshape(url, configuration={"Gripper": "narrow"}), environ=server.environ)
        assert over.bundle.root["configuration"] == "leg_length=0.4+m;List_g=_narrow"


def test_parameters_are_asked_for_again_after_an_edit():
    kept, document = Kept(), configured_stand()
    with OnshapeServer(document) as server:
        keys = onshape(server.document_url(), configuration={"Leg length": "0.4 m"})
        fetched(keys, kept, server.environ)
        server.edit(document.edited("Stand"))
        server.reset()
        fetched(keys, kept, server.environ)
        (target,) = targets_of(server, "/configuration")
        assert f"/m/{server.document.microversion}/" in target
        server.reset()
        assert fetched(keys, kept, server.environ).calls == 1


def test_a_configuration_is_built_offline_from_kept_replies(kept):
    with OnshapeServer(configured_stand()) as server:
        keys = {"configuration": {"Leg length": "0.4 m"}}
        cold = fetched(onshape(server.document_url(), **keys), kept, server.environ)
        url = server.document_url()
    offline = fetched(onshape(url, offline=True, **keys), kept)
    assert (offline.calls, offline.bundle) == (0, cold.bundle)
    with pytest.raises(Offline):
        fetched(onshape(url, offline=True, **keys))
    with pytest.raises(SourceError, match="invalid configuration of the assembly"):
        fetched(onshape(url, offline=True, configuration={"Leg length": "9 m"}), kept)


def test_an_instances_configuration_is_passed_on_word_for_word():
    text = settings.text_of({"jaw": "L"})
    document, plain = stand(gripper="Wide_1"), stand()
    with OnshapeServer(document) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
        assert len(targets_of(server, "configuration=jaw%3DL")) == 2
    key = next(studio.key for studio in made.bundle.studios if studio.key.configuration == text)
    assert key.element == document.studios[2].element
    jaws = [either.root.instances[2].source.id for either in (document, plain)]
    assert jaws[0] != jaws[1]
    (part,) = next(link for link in build_robot(made.bundle, plan_of()).links if link.name == "jaw").parts
    assert part.part_id == jaws[0]
    assert weights(made)["jaw"] == 0.025
    # A studio in two configurations is two studios.
    plain.root.add(plain.studios[2].at("jaw=L").parts[0], fixed=True, name="Big jaw")
    with OnshapeServer(plain) as server:
        made = fetched(onshape(server.document_url()), environ=server.environ)
    assert (made.calls, len({studio.key for studio in made.bundle.studios})) == (1 + 2 * 4, 4)


def test_a_bundle_records_its_configuration_and_takes_no_other(tmp_path):
    with OnshapeServer(configured_stand()) as server:
        keys = onshape(server.document_url(), configuration={"Leg length": "0.4 m"})
        made = fetched(keys, environ=server.environ)
    source = {"kind": "bundle", "path": str(tmp_path / "stand.zip")}
    (tmp_path / "stand.zip").write_bytes(pack(made.bundle))
    again = fetched(Plan.parse({"name": "stand", "source": source}))
    assert again.bundle.root["configuration"] == "leg_length=0.4+m"
    assert again.bundle.definition == made.bundle.definition
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"name": "x", "source": {**source, "configuration": {"a": 1}}})
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-KEY", "source.configuration")


@pytest.mark.e2e
def test_a_build_says_in_its_report_which_configuration_it_is_of(tmp_path):
    more = {"output": str(tmp_path / "out"), "cache": {"dir": str(tmp_path / "cache")}, "until": "graph"}
    with OnshapeServer(configured_stand()) as server:
        for grip, text in (("wide grip", "List_g=Wide_1"), ("narrow", "List_g=_narrow")):
            server.reset()
            source = {"url": server.document_url("v"), "configuration": {"Gripper": grip}}
            plan = Plan.parse({"name": "stand", "source": {"kind": "onshape", **source}, **more})
            assert build(plan, environ=server.environ).source["configuration"] == text
        assert server.count == 3


@pytest.mark.parametrize("value", [None, [1], {"a": 1}, float("nan")])
def test_values_of_no_parameter_are_refused_by_the_plan(value):
    source = {"kind": "onshape", "url": ADDRESS, "configuration": {"a": value}}
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"name": "x", "source": source})
    (problem,) = caught.value.problems
    assert problem.where == "source.configuration.a"
    assert "must be text, a number, or true or false" in problem.message
