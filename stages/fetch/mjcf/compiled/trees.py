"""Finds the bodies of a model that belong to the robot; all other bodies are in the scene around it."""

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco

from linkwright.stages.mujoco.names import OBJ

_TIE_TYPES = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def robot_bodies(model: Any) -> list[int]:
    """Returns the bodies of the robot, in order, after the world.

    Trees below the world that equalities or tendons tie together count as a group. The robot is either all
    groups fixed to the world that have actuators, or a floating group: the choice with the most actuators,
    and among equals the most joints. Without any actuator, all groups fixed to the world are the robot. Mocap
    bodies, and the bodies below them, are not part of it.
    """
    tops = _top_bodies(model)
    if not tops:
        return [0]
    groups = _groups(model, tops)
    actuated_groups = [groups[tops[body]] for body in _actuated_bodies(model) if body in tops]
    joints = [groups[tops[int(body)]] for body in model.jnt_bodyid if int(body) in tops]
    fixed_groups = {groups[top] for top in tops.values() if _is_fixed(model, top)} | (
        {0} & {*groups.values()}
    )
    fixed_choice = fixed_groups & {*actuated_groups} or fixed_groups
    choices = [fixed_choice, *({group} for group in sorted({*groups.values()} - fixed_groups))]

    def weight(choice: set[int]) -> tuple[int, int]:
        return sum(group in choice for group in actuated_groups), sum(group in choice for group in joints)

    robot_groups = max((choice for choice in choices if choice), key=weight)
    return [0, *(body for body, top in tops.items() if groups[top] in robot_groups)]


def _top_bodies(model: Any) -> dict[int, int]:
    """Returns the top-level body above each body; mocap bodies are left out."""
    tops: dict[int, int] = {}
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        if model.body_mocapid[body] < 0 and (not parent or parent in tops):
            tops[body] = tops[parent] if parent else body
    return tops


def _groups(model: Any, tops: dict[int, int]) -> dict[int, int]:
    """Returns the first body of the group of each top-level body; 0 if that is the world."""
    parent_of = {top: top for top in {0, *tops.values()}}

    def group_root(top: int) -> int:
        while parent_of[top] != top:
            parent_of[top] = parent_of[parent_of[top]]  # so that paths stay short
            top = parent_of[top]
        return top

    for bodies in (*_equalities(model), *_tendons(model)):
        if all(not body or body in tops for body in bodies):
            roots = {group_root(tops.get(body, 0)) for body in bodies}
            parent_of |= dict.fromkeys(roots, min(roots, default=0))
    return {top: group_root(top) for top in parent_of if top}


def _is_fixed(model: Any, top: int) -> bool:
    """Tells whether a body below the world does not float."""
    first = int(model.body_jntadr[top])
    return not (model.body_jntnum[top] and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE)


def _equalities(model: Any) -> Iterator[Sequence[int]]:
    """Yields the bodies that each equality holds together."""
    for eq in range(model.neq):
        kind, ends = int(model.eq_type[eq]), (int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq]))
        if not model.eq_active0[eq]:
            continue
        if kind in _TIE_TYPES:
            by_sites = model.eq_objtype[eq] == OBJ.mjOBJ_SITE
            yield [int(model.site_bodyid[end]) for end in ends] if by_sites else ends
        elif kind == mujoco.mjtEq.mjEQ_JOINT:
            yield [int(model.jnt_bodyid[end]) for end in ends if end >= 0]


def _tendons(model: Any) -> Iterator[Sequence[int]]:
    """Yields the bodies that each tendon acts on, except the world."""
    for tendon in range(model.ntendon):
        bodies = {*_on_path(model, tendon)} - {0}
        if bodies:
            yield sorted(bodies)


def _on_path(model: Any, tendon: int) -> Iterator[int]:
    first = int(model.tendon_adr[tendon])
    for wrap in range(first, first + int(model.tendon_num[tendon])):
        kind, object_index = int(model.wrap_type[wrap]), int(model.wrap_objid[wrap])
        if kind == mujoco.mjtWrap.mjWRAP_JOINT:
            yield int(model.jnt_bodyid[object_index])
        elif kind == mujoco.mjtWrap.mjWRAP_SITE:
            yield int(model.site_bodyid[object_index])


def _actuated_bodies(model: Any) -> Iterator[int]:
    """Yields the body that each actuator acts on: for a tendon, the first on its path; 0 for the world."""
    for index in range(len(model.actuator_trntype)):
        kind, object_index = int(model.actuator_trntype[index]), int(model.actuator_trnid[index][0])
        if kind == mujoco.mjtTrn.mjTRN_TENDON:
            # A tendon between sites of the world acts on no body.
            yield next((body for body in _on_path(model, object_index) if body), 0)
        elif kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
            yield int(model.jnt_bodyid[object_index])
        elif kind == mujoco.mjtTrn.mjTRN_BODY:
            yield object_index
        elif kind in (mujoco.mjtTrn.mjTRN_SITE, mujoco.mjtTrn.mjTRN_SLIDERCRANK):
            yield int(model.site_bodyid[object_index])
