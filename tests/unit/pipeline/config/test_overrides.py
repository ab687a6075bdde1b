"""Overrides as they are typed and as Hydra gets them, and what composing leaves open."""

import copy
from pathlib import Path

import pytest

from linkwright.pipeline.config.choices import Choices, resolve_choices
from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.overrides import read
from linkwright.pipeline.config.presets import GROUPS, MULTIPLE_GROUPS


@pytest.fixture(scope="module")
def values():
    with session() as composer:
        yield composer.reading.values


@pytest.mark.parametrize(("typed", "hydra"), [
    ("mesh=hull", "mesh=hull"),
    ("export=[urdf,mjcf]", "export=[urdf,mjcf]"),
    ("mesh.tolerance=0.002", "++mesh.tolerance=0.002"),
    ("name=arm", "++name=arm"),
    ("name=../x", "++name=../x"),
    ("nonsense=1", "++nonsense=1"),
    ("+mesh.x=1", "+mesh.x=1"),
    ("++mesh.x=1", "++mesh.x=1"),
    ("~ground", "~ground"),
    ("hydra.verbose=true", "hydra.verbose=true"),
    ("hydra/launcher=basic", "hydra/launcher=basic"),
    ("actuators={elbow: none}", "++actuators={elbow: none}"),
    ("joints.elbow.damping=1", "++joints.elbow.damping=1"),
    ("joints.*.damping=1", "++joints={*:{damping:1}}"),
    ("joints.*finger*.limits=[-1,1]", "++joints={*finger*:{limits:[-1,1]}}"),
    ("joints.Revolute 3.effort=2", r"++joints={Revolute\ 3:{effort:2}}"),
    ('joints."a.b=c".effort=2', r"++joints={a.b\=c:{effort:2}}"),
    ('joints["a.b=c"].effort=2', r"++joints={a.b\=c:{effort:2}}"),
    ("joints['a.b=c'].effort=2", r"++joints={a.b\=c:{effort:2}}"),
    ('mass.links["a/b.0"].mass=2', "++mass={links:{a/b.0:{mass:2}}}"),
    ('mass.parts."Hand/Pad*".mass=2', "++mass={parts:{Hand/Pad*:{mass:2}}}"),
    ("joints.f[0-9].effort=2", r"++joints={f\[0-9\]:{effort:2}}"),
    ("+joints.*.damping=1", "++joints={*:{damping:1}}"),
    ('joints={"elbow*": {"damping": 1}}', "++joints={elbow*:{damping:1}}"),
    ("joints={'a:b': {limits: [null, \"${vars.x}\"]}}", r"++joints={a\:b:{limits:[null,'${vars.x}']}}"),
    ('+names={links: {"Upper arm": "it\'s \\\\"}}', r"+names={links:{Upper\ arm:'it\'s \\'}}"),
    ("source.url='https://x/y?a=b&c=d,e#f'", "++source.url='https://x/y?a=b&c=d,e#f'"),
    ("source.url=https://x/y?z", "++source.url=https://x/y?z"),
])  # fmt: skip
def test_an_override_becomes_one_that_hydra_can_carry(values, typed, hydra):
    (override,), problems = read([typed], GROUPS, values, multirun=False)
    assert (override.hydra, problems) == (hydra, [])


@pytest.mark.parametrize(("typed", "hydra"), [
    ("ground=glob(*)", "ground=none,plane"),
    ("root=glob(f*)", "root=fixed,free"),
    ("root=glob([*],exclude=f*)", "root=auto,central"),
    ("joints.*.damping=1,2", "++joints={*:{damping:1}},{*:{damping:2}}"),
])  # fmt: skip
def test_a_swept_override_has_all_its_values(values, typed, hydra):
    (override,), problems = read([typed], GROUPS, values, multirun=True)
    assert (override.hydra, override.swept, problems) == (hydra, True, [])


PASTE = (
    "paste: linkwright{m} 'joints.*.damping=1' \"source.url='{url}'\"   "
    "(check its end: an unquoted & has cut the URL in the shell)"
)


@pytest.mark.parametrize(
    "url", ["https://cad.onshape.com/e/1?a=b", "https://x/y?a,b", "https://x/y#z", "http://x/(1)"]
)
@pytest.mark.parametrize("multirun", [False, True])
def test_url_without_quotes_comes_with_the_line_to_paste(values, url, multirun):
    overrides, problems = read(["joints.*.damping=1", f"source.url={url}"], GROUPS, values, multirun)
    if multirun and "," in url:
        assert problems == []  # a sweep over two values, as far as anyone can tell
        return
    (problem,) = problems
    assert len(overrides) == 1
    assert problem.message == "a URL needs quotes, and around them quotes for the shell"
    assert problem.hint == PASTE.format(url=url, m=" -m" if multirun else "")


def test_the_line_to_paste_can_be_pasted(values):
    import shlex

    _, (problem,) = read(["source.url=https://x/y?a=b'c&$d"], GROUPS, values, multirun=False)
    line = problem.hint.removeprefix("paste: ").partition("   (")[0]
    (override,), problems = read(shlex.split(line)[1:], GROUPS, values, multirun=False)
    assert (problems, override.values) == ([], (r"'https://x/y?a=b\'c&$d'",))


NO_PAIR, NO_KEY = "expected key=value", "this key cannot be written on the command line"
HELP = "linkwright --help shows how keys and groups are typed"
IN_YAML = "write it in YAML: joints: {}"


@pytest.mark.parametrize(("typed", "message", "hint"), [
    ("new", "`new` is not supported yet", "linkwright --help lists the verbs"),
    ("my_arm", NO_PAIR, "linkwright robot=my_arm"),
    ("=1", NO_PAIR, HELP),
    ("https://x/y?a=b", NO_PAIR, "linkwright source=onshape \"source.url='https://x/y?a=b'\""),
    ("mesh.tolerance=1,2", "several values, but no sweep",
     "for a sweep add -m; for one text \"mesh.tolerance='1,2'\"; for a list 'mesh.tolerance=[1,2]'"),
    ('"=1', NO_PAIR, HELP),
    ("@x=1", NO_PAIR, HELP),
    ("arm.v2.urdf", NO_PAIR, "linkwright source=urdf source.path=arm.v2.urdf"),
    ("my scene.xml", NO_PAIR, "linkwright source=mjcf \"source.path='my scene.xml'\""),
    ("robot/arm.yaml", NO_PAIR, "linkwright robot=robot/arm.yaml"),
    ('mass.parts."Hand <1>/*".mass=1', NO_KEY, 'write it in YAML: mass: {parts: {"Hand <1>/*": {mass: 1}}}'),
    ("joints.Gelenk <1>.damping=1", NO_KEY, IN_YAML.format('{"Gelenk <1>": {damping: 1}}')),
    ('joints={"Gelenk <1>": {damping: 1}}', NO_KEY, IN_YAML.format('{"Gelenk <1>": {damping: 1}}')),
    ("joints.12.x y=1", NO_KEY, IN_YAML.format('{"12": {"x y": 1}}')),
    ("joints={a: {damping: 1}", "cannot be read: {a: {damping: 1} is not allowed there",
     "example of a mapping: 'joints={\"elbow*\": {damping: 1, limits: [-1, 1]}}'"),
    ("source.path=~/arm.zip", "cannot be read: ~ needs quotes",
     f"quote the value: \"source.path='{Path.home()}/arm.zip'\""),
])  # fmt: skip
def test_what_cannot_be_carried_is_answered_with_what_to_do(values, typed, message, hint):
    overrides, problems = read([typed], GROUPS, values, multirun=False)
    assert overrides == []
    assert [(problem.where, problem.message, problem.hint) for problem in problems] == [
        (typed, message, hint)
    ]


NONE = dict.fromkeys(MULTIPLE_GROUPS, ())
"""No option of a group that takes several."""

ROOT, URL = {"base": "fixed", "select": "x"}, {"kind": "onshape", "url": "mine"}
FREE = {"root": {"base": "free", "select": "auto"}}
FOREIGN = {"url": "u", "tessellation": {}, "path": "p", "mine": 1}


@pytest.mark.parametrize(("key", "tree", "choices", "expected"), [
    pytest.param("root", ROOT, [NONE, (), FREE, frozenset({"root.select"})],
        {"base": "free", "select": "x"}, id="a preset of the command line wins but for keys set there"),
    pytest.param("source", URL, [NONE, (), {"source": {"kind": "onshape", "url": "???"}}], URL,
        id="a preset without a value leaves the robot's own"),
    pytest.param("source", FOREIGN,
        [NONE, (), {"source": {"kind": "bundle"}}, frozenset({"source.tessellation.angle"})],
        {"tessellation": {}, "path": "p", "mine": 1, "kind": "bundle"},
        id="keys of another source go unless the command line set them"),
    pytest.param("export", {"urdf": {"meshes": "relative"}, "sdff": {}}, [{**NONE, "export": ("mjcf",)}],
        {"sdff": {}, "mjcf": {}}, id="formats that are not chosen go and unknown ones stay to be judged"),
])  # fmt: skip
def test_choices_win_over_the_tree(key, tree, choices, expected):
    whole = {"name": "a", key: tree}
    before = copy.deepcopy(whole)
    assert resolve_choices(whole, Choices("arm", *choices))[key] == expected
    assert whole == before
