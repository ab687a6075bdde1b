"""What patterns and mirrors do to mates: whatever holds a seed holds each of its copies as well.

A mate of the same assembly that touches a seed, at any depth below it, acts once more for the copy: its
side on a seed moves to that one's copy, with the same frame on it (on a mirror-image part, with the frame
that the same reflection makes of it); any other side stays on its
occurrence, and its frame goes where the pattern's transform takes it at the saved pose. So the copy's
saved pose is the seed's, moved, at the same values. Where nothing of that assembly holds the seeds, the
mates of the nearest assembly around it do that. A seed that is fastened to something else takes its other
joints to nothing else: they are what it carries.
"""

from dataclasses import replace

import numpy as np

from tests.fake_onshape.edges import weld_leaders
from tests.fake_onshape.frames import inverse, product


def level_of(tree, owner, pattern):
    """The assembly whose mates hold the seeds of a pattern."""
    seeds = [owner + seed.path for seed in pattern.seeds]
    for depth in range(len(owner), -1, -1):
        if any(_holds(edge, seeds) for edge, _ in _edges(tree, owner[:depth])):
            return owner[:depth]
    return owner


def copy_edges(tree, owner, pattern, level):
    """[(edge, whether it is redundant)]: what of the assembly `level` holds the copies of one pattern."""
    poses = {(): np.eye(4), **tree.poses()}
    seeds = [owner + seed.path for seed in pattern.seeds]
    held = _edges(tree, level)
    fastened = _fastened(tree, held, seeds)
    made = []
    for number in range(len(pattern.transforms)):
        moved, onto = world_transform(poses, owner, pattern, number), _onto(owner, pattern, number)
        for edge, redundant in held:
            if edge.moves and _holds(edge, seeds) and fastened.issuperset(_ends_within(edge, seeds)):
                continue
            ends = [_end(tree, path, frame, onto, poses, moved) for path, frame in _sides(edge)]
            copied = tuple("/".join(copy[len(level) :]) for _, _, copy in ends if copy)
            if copied:
                (first, first_frame, _), (second, second_frame, _) = ends
                tag = (pattern.name, number + 1)
                ends = {"first": first, "first_frame": first_frame}
                ends |= {"second": second, "second_frame": second_frame}
                name = f"{edge.name} [{tag[0]} {tag[1]}]"
                copy = replace(edge, name=name, copies=(*edge.copies, tag), onto=copied, **ends)
                made.append((copy, redundant))
    return made


def _edges(tree, level):
    return [
        *((edge, False) for edge in tree.edges if edge.owner == level and edge.feature),
        *((edge, True) for edge in tree.redundant if edge.owner == level),
    ]


def _fastened(tree, held, seeds):
    """All in the seeds that is one body with something outside them."""
    inside = [e for e in tree.edges if not (e.moves or e.closing) and len(_ends_within(e, seeds)) == 2]
    bodies = weld_leaders(tree.places, inside)
    outer = [edge for edge, _ in held if not edge.moves and _holds(edge, seeds)]
    leaders = {bodies(path) for edge in outer for path in _ends_within(edge, seeds)}
    return {path for path in tree.places if within(path, seeds) and bodies(path) in leaders}


def _ends_within(edge, seeds):
    return [path for path, _ in _sides(edge) if within(path, seeds)]


def _holds(edge, seeds):
    """Whether an edge is between a seed and something that is in none."""
    inside = [within(path, seeds) for path, _ in _sides(edge)]
    return any(inside) and not all(inside)


def within(path, seeds):
    """Whether a path is one of the `seeds` or lies in one."""
    return any(path[: len(seed)] == seed for seed in seeds)


def copied_poses(tree, owner, pattern):
    """{copy's path: (4, 4) in its assembly at the saved pose}, by the seeds' poses."""
    poses = {(): np.eye(4), **tree.poses()}
    return {
        copy: product(
            inverse(poses[owner]),
            world_transform(poses, owner, pattern, number),
            poses[seed],
            inverse(tree.places[copy].instance.image_from_seed),
        )
        for number in range(len(pattern.transforms))
        for seed, copy in _onto(owner, pattern, number).items()
    }


def world_transform(poses, owner, pattern, number):
    """The transform (4, 4) of the `number`-th copies, in the world."""
    return product(poses[owner], pattern.transforms[number], inverse(poses[owner]))


def _onto(owner, pattern, number):
    return {
        owner + seed.path: owner + copies[number].path
        for seed, copies in zip(pattern.seeds, pattern.copies, strict=True)
    }


def _sides(edge):
    return (edge.first, edge.first_frame), (edge.second, edge.second_frame)


def _end(tree, path, frame, onto, poses, moved):
    """(path, frame, the copied instance's path or nothing) of one side of a copied edge."""
    for seed, copy in onto.items():
        if path[: len(seed)] == seed:
            image = tree.places[copy].instance.image_from_seed
            return copy + path[len(seed) :], product(image, frame), copy
    return path, product(inverse(poses[path]), moved, poses[path], frame), ()
