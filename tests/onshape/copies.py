"""What patterns and mirrors do to mates: whatever holds a seed holds each of its copies as well.

A mate of the same assembly that touches a seed, at any depth below it, acts once more for the copy: its
side on a seed moves to that one's copy, with the same frame on it; any other side stays on its
occurrence, and its frame goes where the pattern's transform takes it at the saved pose. So the copy's
saved pose is the seed's, moved, at the same values.
"""

from dataclasses import replace

import numpy as np

from tests.onshape.frames import inverse, product


def copy_edges(tree, owner, pattern):
    """[(edge, whether it is redundant)]: what holds the copies of one pattern in one assembly."""
    poses = {(): np.eye(4), **tree.poses()}
    held = [
        *((edge, False) for edge in tree.edges if edge.owner == owner and edge.feature),
        *((edge, True) for edge in tree.redundant if edge.owner == owner),
    ]
    made = []
    for number in range(len(pattern.transforms)):
        moved, onto = world_transform(poses, owner, pattern, number), _onto(owner, pattern, number)
        for edge, redundant in held:
            ends = [_end(path, frame, onto, poses, moved) for path, frame in _sides(edge)]
            copied = tuple(copy for _, _, copy in ends if copy)
            if copied:
                (first, first_frame, _), (second, second_frame, _) = ends
                tag = (pattern.name, number + 1)
                copy = replace(
                    edge,
                    name=f"{edge.name} [{tag[0]} {tag[1]}]",
                    first=first,
                    second=second,
                    first_frame=first_frame,
                    second_frame=second_frame,
                    copies=(*edge.copies, tag),
                    onto=copied,
                )
                made.append((copy, redundant))
    return made


def copied_poses(tree, owner, pattern):
    """{copy's path: (4, 4) in its assembly at the saved pose}, by the seeds' poses."""
    poses = {(): np.eye(4), **tree.poses()}
    return {
        copy: product(inverse(poses[owner]), world_transform(poses, owner, pattern, number), poses[seed])
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


def _end(path, frame, onto, poses, moved):
    """(path, frame, the copied instance's id or nothing) of one side of a copied edge."""
    for seed, copy in onto.items():
        if path[: len(seed)] == seed:
            return copy + path[len(seed) :], frame, copy[-1]
    return path, product(inverse(poses[path]), moved, poses[path], frame), ""
