"""What people see of the kinematic graph: the layout, the picture, the outline and the tables."""

import json
import math
import random
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from linkwright.stages.formats import xml
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Mobility, Relation
from linkwright.stages.robot.text.printable import columns, printable
from linkwright.stages.show.graph_view.boxes import boxes_of
from linkwright.stages.show.graph_view.labels import decimal, limits, part_names, rules, shortened
from linkwright.stages.show.graph_view.layout import levels, tidy
from linkwright.stages.show.graph_view.outline import NARROW, WHOLE, outline
from linkwright.stages.show.graph_view.picture import _placed_boxes, draw
from linkwright.stages.show.graph_view.tables import tables
from tests.support.robots import CHAINS, EVERY, joint, loop, robot_with
from tests.unit.robot.test_home import four_bar

SVG = "{http://www.w3.org/2000/svg}"
NASTY = 'Größe <b> & "中文" \x07\x1b[31m]]>'
I4 = np.eye(4)


def random_robot(count=80, seed=1, chain=False):
    """A tree with joints of every type, loops, relations and frames."""
    rng = random.Random(seed)
    names, joints = ["base"], []
    for index in range(1, count):
        name = f"{rng.choice(['hip', 'upper_arm', 'left_finger_distal_phalanx_cover_plate'])}_{index}"
        parent, kind = names[-1] if chain else rng.choice(names[-14:]), rng.choice(EVERY)
        suffixes = [suffix for suffix, freedom, _ in CHAINS[kind] if freedom in ("turn", "slide")]
        ranges = {f"{name}_joint{suffix}": Limits(-rng.random(), rng.random()) for suffix in suffixes}
        joints.append(joint(kind, parent, name, limits=ranges))
        names.append(name)
    scalar = [dof.name for row in joints for dof in row.dofs if dof.kind in ("turn", "slide")]
    relations = [
        Relation(f"r{index}", *rng.sample(scalar, 2), multiplier=-1.5 + index, offset=0.1 * (index % 2))
        for index in range(6)
    ]
    loops = [loop("revolute", *rng.sample(names, 2), I4, I4, name=f"loop_{index}") for index in range(7)]
    frames = [Frame(f"frame_{index}", rng.choice(names), I4, "") for index in range(20)]
    return robot_with(joints, loops=loops, relations=relations, frames=frames, fixed=False)


def nasty_robot():
    """Names longer than any box and titles with everything that XML and terminals mind."""
    name = "extremely_" * 15 + "long"
    joints = [joint("cylindrical", "base", name, name=f"{name}_j")]
    joints += [joint("revolute", name, "b", name=f"b_{name}")]
    closing = loop("ball", "b", "base", I4, I4, name=f"l_{name}")
    closing = replace(closing, mate=replace(closing.mate, name=NASTY * 8))
    relation = Relation("r", f"b_{name}", f"{name}_j_turn", 2.0, 0.0)
    robot = robot_with(joints, loops=[closing], relations=[relation], name=NASTY)
    titles = NASTY, "Arm/Screw <1>", "Arm/Screw <2>", "Cover <a> <1>"
    parts = tuple(replace(robot.links[2].parts[0], name=title) for title in titles)
    return replace(robot, links=(*robot.links[:2], replace(robot.links[2], parts=parts)))


ROBOTS = {"tree": random_robot(), "chain": random_robot(60, chain=True), "nasty": nasty_robot()}


@pytest.mark.parametrize("seed", range(6))
def test_nodes_do_not_overlap_and_parents_are_in_the_middle(seed):
    rng = random.Random(seed)
    order = [str(index) for index in range(120)]
    parents = {name: order[rng.randrange(index)] for index, name in enumerate(order) if index}
    heights = {name: rng.uniform(5, 60) for name in order}
    centres, level = tidy(order, parents, heights, 7.0), levels(order, parents)
    for a, b in combinations(order, 2):
        apart = abs(centres[a] - centres[b])
        assert level[a] != level[b] or apart >= (heights[a] + heights[b]) / 2 + 7.0 - 1e-9
    for name in order:
        below = [centres[child] for child in order if parents.get(child) == name]
        assert not below or centres[name] == pytest.approx((below[0] + below[-1]) / 2)
    assert min(centres[name] - heights[name] / 2 for name in order) == pytest.approx(0)


def test_subtrees_of_unlike_depth_move_together():
    parents = {"a": "root", "b": "root", "deep": "a"}
    heights = {"root": 10.0, "a": 10.0, "b": 10.0, "deep": 100.0}
    centres = tidy(["root", "a", "b", "deep"], parents, heights, 5.0)
    assert centres["b"] - centres["a"] == pytest.approx(15.0)


@pytest.mark.parametrize(
    ("kind", "bounds", "words"),
    [
        ("revolute", Limits(-math.pi / 2, math.pi), "-90..180 deg"),
        ("prismatic", Limits(0.0, 0.0255), "0..25.5 mm"),
        ("revolute", Limits(None, math.pi), "≤ 180 deg"),
        ("prismatic", Limits(-0.01, None), "≥ -10 mm"),
        ("revolute", Limits(), "free"),
        ("ball", Limits(None, math.pi / 6), "cone 30 deg"),
        ("ball", Limits(), "free"),
        ("free", Limits(), "free"),
    ],
)
def test_limits_are_reported_in_degrees_and_millimetres(kind, bounds, words):
    assert limits(joint(kind, "base", "arm", limits={"arm_joint": bounds}).dofs[0]) == words


def test_numbers_are_reported_without_noise():
    assert list(map(decimal, (-1e-15, 90.00000000001, -1.5))) == ["0", "90", "-1.5"]


@pytest.mark.parametrize(
    ("driver", "follower", "multiplier", "offset", "words"),
    [
        ("revolute", "revolute", -1.5, 0.0, "-1.5 × a_joint"),
        ("revolute", "revolute", 2.0, -math.pi / 180, "2 × a_joint - 1 deg"),
        ("revolute", "prismatic", 0.18 / math.pi, 0.002, "1 mm/deg × a_joint + 2 mm"),
        ("prismatic", "revolute", math.pi / 0.18, 0.0, "1 deg/mm × a_joint"),
    ],
)
def test_follower_is_reported_in_the_units_of_its_range(driver, follower, multiplier, offset, words):
    relation = Relation("r", "b_joint", "a_joint", multiplier, offset)
    robot = robot_with([joint(driver, "base", "a"), joint(follower, "a", "b")], relations=[relation])
    assert rules(robot)[relation.follower] == words


@pytest.mark.parametrize("name", ["upper_arm_of_the_left_leg", "中文名稱連桿機構"])
def test_long_name_loses_its_middle_and_wide_letters_count_twice(name):
    for room in (1, 2, 7, 12):
        short = shortened(name, room)
        assert columns(short) <= room
        assert room < 3 or (short[0] == name[0] and short.count("…") == 1)
    assert shortened("arm", 3) == "arm"


def test_equal_parts_of_a_link_are_counted_the_heaviest_first():
    names = part_names(ROBOTS["nasty"].links[2])
    assert (names[0], "Cover <a>" in names) == ("Screw ×2", True)


def test_outline_of_a_small_robot():
    joints = [
        joint("revolute", "base", "arm", limits={"arm_joint": Limits(-1.0, 1.0)}),
        joint("cylindrical", "arm", "rod"),
        joint("revolute", "base", "wheel"),
    ]
    more = {
        "relations": [Relation("r", "wheel_joint", "arm_joint", -1.5, 0.0)],
        "loops": [loop("ball", "rod", "wheel", I4, I4, name="tip")],
        "frames": [Frame("tool", "rod", I4, "")],
    }
    robot = replace(robot_with(joints, **more), mobility=Mobility(4, 0, 1, (("tip", 1),)))
    assert outline(robot).splitlines() == [
        "robot: 4 links, 3 joints, 4 parts, 1 relation, 1 loop, 1 frame, 4.6 kg",
        "fixed base: made so",
        "",
        "link        kg  parts  joint         type         range",
        "base         1      1  (fixed base)",
        "├─ arm     1.1      1  arm_joint     revolute     -57.3..57.3 deg",
        "│  └─ rod  1.2      1  rod_joint     cylindrical  slide free",
        "│                                                 turn free",
        "└─ wheel   1.3      1  wheel_joint   revolute     free  = -1.5 × arm_joint",
        "",
        "loop tip: ball, mate tip, rod to wheel, residual 0",
        "",
        "1 frame on rod: tool",
        "",
        "1 degree of freedom (by rank at the saved pose; 0 by Grübler), 4 coordinates",
        "1 condition of the loop tip is redundant",
    ]


def table_of(lines):
    """The header of the outline's table, and its lines."""
    start = lines.index("") + 1
    return lines[start], lines[start + 1 : lines.index("", start)]


@pytest.mark.parametrize("robot", [*ROBOTS.values(), robot_with()], ids=[*ROBOTS, "single"])
def test_lines_fit_a_terminal_and_every_link_has_a_line(robot):
    lines = outline(robot, NARROW).splitlines()
    assert max(map(columns, lines)) <= 80
    assert all(line == printable(line) for line in lines)
    rows = len(robot.links) + sum(max(0, len(joint.dofs) - 1) for joint in robot.joints)
    assert len(table_of(lines)[1]) >= rows


@pytest.mark.parametrize("name", ROBOTS)
def test_without_a_width_each_name_is_whole_and_on_a_line(name):
    robot = ROBOTS[name]
    lines = outline(robot).splitlines()
    rows = iter(table_of(lines)[1])
    for link in in_order(robot):
        # In their order, with the joint above it on the same line.
        row = next(line.split() for line in rows if link.name in line.split())
        assert all(joint.name in row for joint in robot.joints if joint.child == link.name)
    rest = lines[len(lines) - lines[::-1].index("") :]
    assert len(rest) == 1 + len(robot.mobility.redundant)
    for drawn in robot.loops:
        assert any(line.startswith(f"loop {drawn.name}: ") and drawn.link_b in line for line in lines)


@pytest.mark.parametrize("room", [WHOLE, NARROW], ids=["whole", "narrow"])
@pytest.mark.parametrize("name", ROBOTS)
def test_no_name_that_people_type_is_shortened(name, room):
    robot = ROBOTS[name]
    lines = outline(robot, room).splitlines()
    header, table = table_of(lines)

    def below(start, end):
        """The text below a header's word, without the lines of the tree: pieces of names in their order."""
        left, right = header.index(start), header.index(end)
        return "".join(line[left:right].strip("│├└─… ") for line in table)

    # A parts column of five letters, right below its word, ends two columns before the joints.
    links = in_order(robot)
    assert below("link", " kg").replace(" ", "") == "".join(link.name for link in links)
    above = {joint.child: joint.name for joint in robot.joints}
    names = [f"({'fixed' if robot.base.fixed else 'free'} base)", *(above[link.name] for link in links[1:])]
    assert below("joint", "type") == "".join(names)
    rest = "".join(" ".join(lines[lines.index(table[-1]) + 1 :]).split())
    for drawn in robot.loops:
        for text in (drawn.name, drawn.mate.name, drawn.link_a, drawn.link_b):
            assert "".join(printable(text).split()) in rest
    assert all(frame.name in rest for frame in robot.frames)
    ranges = "".join("".join(line[header.index("range") :].split()) for line in table)
    assert all(f"×{relation.driver}" in ranges for relation in robot.relations)


def in_order(robot):
    """The links as a tree lists them, every subtree together."""
    waiting, links = [robot.root.name], []
    while waiting:
        links.append(robot.link(waiting.pop()))
        waiting += [joint.child for joint in robot.joints if joint.parent == links[-1].name][::-1]
    return links


def test_name_with_wide_letters_is_wrapped_by_columns():
    name = "中文連桿" * 30
    robot = robot_with([joint("revolute", "base", name, name=f"{name}_j")], name=name)
    lines = outline(robot, NARROW).splitlines()
    assert max(map(columns, lines)) <= 80
    assert "".join(lines).count("桿") == 90


def test_origin_as_root_has_no_mass():
    lines = outline(robot_with([joint("planar", "world", "cart")], root="world")).splitlines()
    assert lines[4].split() == ["world", "(fixed", "base)"]


def rectangles(svg):
    """The boxes of links, as (left, top, right, bottom)."""
    for rect in svg.iter(f"{SVG}rect"):
        if rect.get("rx"):
            x, y, w, h = (float(rect.get(key)) for key in ("x", "y", "width", "height"))
            yield x, y, x + w, y + h


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


@pytest.mark.parametrize("seed", range(3))
def test_no_boxes_or_labels_overlap_and_all_are_on_the_sheet(seed):
    robot = random_robot(seed=seed)
    svg = xml.parse(draw(robot))
    boxes = list(rectangles(svg))
    assert len(boxes) == len(robot.links)
    placed = _placed_boxes(robot, boxes_of(robot)).values()
    labels = [
        (box.label_x, box.y - 18, box.label_x + box.label_width, box.y + 4 + 13 * len(box.lines))
        for box in placed
        if box.joint
    ]
    assert not [pair for pair in combinations(boxes + labels, 2) if overlap(*pair)]
    width, height = float(svg.get("width")), float(svg.get("height"))
    assert all(left >= 0 and top >= 0 and right <= width and low <= height for left, top, right, low in boxes)
    assert min(float(element.get("font-size")) for element in svg.iter(f"{SVG}text")) >= 9


def test_picture_tells_links_joints_loops_relations_and_frames():
    robot = random_robot(12)
    text = "\n".join(node.text or "" for node in xml.parse(draw(robot)).iter())
    names = [link.name for link in robot.links]
    assert all(words in text for words in (*names, "loop_0", "frame_0", "= ", "free base", "12 links"))
    drawn = draw(robot).decode()
    assert drawn.count('stroke-dasharray="1 4"') == len(robot.relations) + 1
    assert drawn.count('stroke-dasharray="6 4"') == len(robot.loops) + 1


@pytest.mark.parametrize("make", [nasty_robot, robot_with])
def test_odd_names_and_a_single_link_give_whole_xml(make):
    svg = xml.parse(draw(make()))
    assert svg.tag == f"{SVG}svg"
    assert not re.search(r"href|url\(|@import", draw(make()).decode())


def test_same_robot_gives_the_same_bytes():
    assert draw(random_robot(seed=3)) == draw(random_robot(seed=3))


def rows_of(robot):
    """The rows of each table, by title and header."""
    loaded = json.loads(tables(robot))
    return {
        table["title"]: [dict(zip(table["header"], row, strict=True)) for row in table["rows"]]
        for table in loaded
    }


def test_tables_have_a_row_for_each_dof_with_units():
    dynamics = Dynamics(effort=12.0, velocity=math.pi)
    joints = [joint("planar", "base", "cart"), joint("fixed", "cart", "mast")]
    joints += [joint("revolute", "cart", "arm", [0.5], dynamics=dynamics)]
    rows = rows_of(robot_with(joints))
    assert [(row["coordinate"], row["axis"]) for row in rows["Joints"]] == [
        ("cart_joint_x", "1 0 0"),
        ("cart_joint_y", "0 1 0"),
        ("cart_joint_turn", "0 0 1"),
        ("", ""),
        ("", "0 0 1"),
    ]
    assert (rows["Joints"][-1]["saved"], rows["Joints"][-1]["CAD"]) == ("28.65 deg", joints[-1].mate.name)
    texts = {"effort": "12 N m", "velocity": "180 deg/s", "damping": "", "friction": "", "armature": ""}
    assert rows["Dynamics"] == [{"coordinate": joints[-1].dofs[0].name, **texts}]
    assert "Loops" not in rows
    assert [row["link"] for row in rows["Masses"]] == ["base", "cart", "mast", "arm", "total"]
    shares = [float(row["share"].removesuffix(" %")) for row in rows["Masses"]]
    assert (sum(shares[:-1]), shares[-1]) == (pytest.approx(100, abs=0.3), 100)
    assert [row["open by"] for row in rows_of(four_bar())["Loops"]] == ["0 m or rad"]


@pytest.mark.parametrize("name", ROBOTS)
def test_every_table_is_of_texts_and_rectangular(name):
    for table in json.loads(tables(ROBOTS[name])):
        assert all(len(row) == len(table["header"]) for row in table["rows"])
        assert all(isinstance(cell, str) for row in table["rows"] for cell in row)
