"""Places in the working set: what shares memory is never needed at the same time, going by the code that uses it."""

import ast
import inspect
import itertools
import textwrap
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels import stages, step_parts
from warpmuscle.kernels.body import (
    coordinate_joint,
    dynamics,
    followed,
    followed_reduction,
    follower,
    hybrid,
    inertia,
    integration,
    joint_motion,
    kinematics,
    motion,
)
from warpmuscle.kernels.constraint import constraints, solution
from warpmuscle.kernels.contact import collision, touching
from warpmuscle.kernels.contact.body_contact import body_contact_of
from warpmuscle.kernels.control import control, coordinate_control, simbicon
from warpmuscle.kernels.control.joint_pd import joint_pd
from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.kernels.force import devices, forces
from warpmuscle.kernels.memory import scratch
from warpmuscle.kernels.memory.scratch import LIVES, PHASES, Life
from warpmuscle.kernels.muscle.contraction import COMPLIANT, RIGID
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_laws import HILL, IDEAL, LEGACY
from warpmuscle.kernels.muscle.muscle_stage import muscle_stage_of
from warpmuscle.kernels.objective import accelerations, failure, term_functions, term_sums
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.kernels.recording import record
from warpmuscle.kernels.structs import Scratch
from warpmuscle.model.controllers.simbicon import SIMBICON

BODIES, SLOTS, FOLLOWED, PUSHES, ENTRIES = 15, 5, 5, 3, 40
FLOATS = {"floats": 1, "integers": 1, "vectors": 3, "quaternions": 4, "matrices": 9, "symmetric": 6}
TERMS = term_sums.ObjectiveKind(
    tuple(term_functions.MUSCLE_TERMS), tuple(term_functions.BODY_TERMS), tuple(term_functions.INSTANCE_TERMS)
)
FORCES = tuple(devices.FORCES.values())
KEPT = {"near"}  # from step to step
IN_PARTS = (kinematics.move_joint, kinematics.place_root, kinematics.place_body)


@cache
def functions() -> dict[str, tuple[Any, ...]]:
    """What runs in each phase, of every kind; made when first asked for, not while tests are collected."""
    muscles = [
        muscle_stage_of(
            MuscleKind(LEE, tendon, law, pulls_in_scratch=in_scratch, straight=in_scratch, implicit=not in_scratch),
            term_sums.muscle_functions(TERMS),
        )
        for tendon, law, in_scratch in itertools.product((RIGID, COMPLIANT), (HILL, LEGACY, IDEAL), (True, False))
    ]
    muscles += [
        muscle_stage_of(MuscleKind(LEE, RIGID, HILL, pulls_in_scratch=True, shared=joints)) for joints in (1, 3)
    ]
    muscles += [
        muscle_stage_of(
            MuscleKind(
                LEE, RIGID, HILL, implicit=implicit, coordinate_joints=True, followers=True, paths=PathKind(None, 8)
            )
        )
        for implicit in (True, False)
    ]
    return {
        "joints": (kinematics.move_joint, coordinate_joint.move_any_of(stages.KNOWN_JOINTS),
            joint_motion.displacements_stage_of(False),
        ),
        "poses": (kinematics.place_root, kinematics.place_body, coordinate_joint.place_any),
        "sums": (kinematics.kinematics_stage,),
        "failure": (failure.begin_step, touching.begin_looking, failure.posture_status),
        "collision": (collision.collision_stage_of(True),),
        "control": (
            control.control_stage_of(control.NO_CONTROLLER), control.control_stage_of(SIMBICON), simbicon.torques_stage,
            coordinate_control.coordinate_control_stage, 
            control.control_stage_of(control.NO_CONTROLLER._replace(custom=joint_pd)),
        ),
        "effort": (term_sums.effort_stage, record.record_desired),
        "muscles": (*muscles, forces.joint_forces_stage_of(FORCES)),
        "objective": (term_sums.objective_stage_of(TERMS),),
        "record": (record.record_stage,),
        "motion": (motion.prescribe_stage, coordinate_joint.prescribe_any, constraints.constraint_stage),
        "inertia": (
            inertia.inertia_stage_of(True, resistance=True), forces.body_forces_stage_of(FORCES),
            touching.touching_stage_of((body_contact_of(True),)),
        ),
        "backward": (
            dynamics.backward_pass_of(dynamics.reduce_body), dynamics.backward_pass_of(coordinate_joint.reduce_any),
            follower.backward_pass_of_clusters(follower.reduce_any_cluster),
            followed_reduction.followed_pass_of(followed_reduction.reduce_followed_of(False)),
            followed_reduction.followed_pass_of(followed_reduction.reduce_followed_of(False, True)),
            followed.equations_of(False, True),
            followed.equations_of(False),  # of joints, whose factors leave torques and stiffness of drivers alone
        ),
        "forward": (
            dynamics.accelerate_root, dynamics.forward_pass_of(dynamics.accelerate_body),
            dynamics.forward_pass_of(coordinate_joint.accelerate_any),
            follower.forward_pass_of_clusters(coordinate_joint.accelerate_any),
            followed.close_root_of(True), solution.solve_constrained,
            followed.close_root, followed.solve_followed, followed.move_root, followed.correct_joint_of(False),
            dynamics.forward_pass_of(followed.accelerate_followed_of(False)),
        ),
        "acted": (
            record.record_given_way_of(False), record.record_given_way_of(True), accelerations.centre_acceleration,
            accelerations.centre_of_mass,
        ),
        "integration": (integration.integrate_stage, hybrid.hybrid_integrate_stage),
        "feet": (failure.step_status, step_parts.foot_force_stage),
    }  # fmt: skip


@cache
def layout() -> dict[str, set[int]]:
    """The floats that each part of the working set takes, read from the code of `work_at` and what adds to it."""
    known = {
        "n": BODIES,
        "slots": SLOTS,
        "followed": FOLLOWED,
        "pushes": PUSHES,
        "entries": ENTRIES,
        "first": scratch.FIRST,
        "other": scratch.SECOND,
        "two_blocks": scratch.FIRST + scratch.SECOND,
        "a_body": scratch.FIRST + scratch.SECOND + scratch.COORDINATE,
        "own": scratch.COORDINATE,
        **{k: v for k, v in vars(scratch).items() if isinstance(v, int)},
    }
    taken = {}
    views = (
        scratch.work_at, scratch.coordinate_work_at, scratch.followed_work_at_of(FOLLOWED, ENTRIES),
        scratch.pushed_work_at_of(FOLLOWED, ENTRIES, PUSHES),
    )  # fmt: skip
    code = [ast.parse(textwrap.dedent(inspect.getsource(one.func))).body[0] for one in views]
    for line in (line for function in code for line in function.body):  # type: ignore[attr-defined]
        if not isinstance(line, ast.Assign):
            continue
        value = line.value
        if isinstance(line.targets[0], ast.Attribute) and isinstance(value, ast.Call):
            numbers = [eval(ast.unparse(one), {}, known) for one in value.args[1:]]
            width = FLOATS[ast.unparse(value.func).removesuffix("_at")]
            taken[line.targets[0].attr] = {
                numbers[0] + numbers[1] * element + k for element in range(numbers[2]) for k in range(width)
            }
        elif isinstance(line.targets[0], ast.Name) and not isinstance(value, ast.Call):
            known[line.targets[0].id] = eval(ast.unparse(value), {}, known)
    taken["monomial"] = {
        scratch.work_floats(BODIES, True, followed=FOLLOWED, pushes=PUSHES, entries=ENTRIES) + k for k in range(8)
    }
    return taken


def called(function: Any, node: ast.AST) -> Any:
    """The Warp function that a name in another one's code stands for, if any."""
    cells = (cell.cell_contents for cell in function.__closure__ or ())
    known = {**function.__globals__, **dict(zip(function.__code__.co_freevars, cells, strict=True))}
    if isinstance(node, ast.Name):
        return known.get(node.id)
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return getattr(known.get(node.value.id), node.attr, None)
    return None


def used(function: Any, seen: set[Any]) -> Iterator[str]:
    """Parts of the working set that a Warp function and all that it calls use."""
    plain = function.func
    if plain is None or plain in seen:
        return
    seen.add(plain)
    for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(plain)))):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "work":
            yield node.attr
        if isinstance(other := called(plain, node), wp.Function):
            yield from used(other, seen)


@cache
def used_in(phase: str) -> set[str]:
    apart = {one.func for one in IN_PARTS} if phase == "sums" else set()
    return {name for function in functions()[phase] for name in used(function, set(apart))}


def span(life: Life) -> tuple[int, int]:
    return PHASES.index(life.first), PHASES.index(life.last)


def test_everything_in_the_working_set_has_a_place_and_a_life():
    assert set(LIVES) == set(layout()) == set(Scratch.vars)
    assert max(map(max, layout().values())) < scratch.work_floats(
        BODIES, True, 8, followed=FOLLOWED, pushes=PUSHES, entries=ENTRIES
    )
    assert set(functions()) == set(PHASES)


@pytest.mark.parametrize("phase", PHASES)
def test_code_uses_only_what_lives(phase: str):
    now = PHASES.index(phase)
    found = used_in(phase)
    assert found
    for name in found:
        life = LIVES[name]
        assert span(life)[0] <= now <= PHASES.index(life.root or life.last), name


def test_accelerations_with_prescribed_motion_use_what_lives_then():
    stage = hybrid.hybrid_acceleration_stage
    lives = {name for name, life in LIVES.items() if span(life)[0] <= PHASES.index("forward")}
    dead = {name for name in lives if span(LIVES[name])[1] < PHASES.index("backward")}
    assert set(used(stage, set())) <= lives - dead


@pytest.mark.parametrize("name", sorted(set(LIVES) - KEPT))
def test_a_life_is_no_longer_than_the_code_needs(name: str):
    at = [now for now, phase in enumerate(PHASES) if name in used_in(phase)]
    assert (PHASES[at[0]], PHASES[at[-1]]) == (LIVES[name].first, LIVES[name].root or LIVES[name].last)


@pytest.mark.parametrize("name", KEPT)
def test_what_is_kept_from_step_to_step_shares_memory_with_nothing(name: str):
    assert (LIVES[name].first, LIVES[name].last) == (PHASES[0], PHASES[-1])
    assert not any(layout()[name] & other for known, other in layout().items() if known != name)


def test_what_shares_memory_does_not_live_at_the_same_time():
    shared = 0
    for (a, one), (b, other) in itertools.combinations(layout().items(), 2):
        if one & other:
            shared += 1
            (first, last), (begin, end) = span(LIVES[a]), span(LIVES[b])
            assert last <= begin or end <= first, (a, b)
    assert shared > 30


def test_the_check_finds_what_would_lie_in_the_place_of_another(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(LIVES, "turned", Life("joints", "control"))
    with pytest.raises(AssertionError, match="turned"):
        test_what_shares_memory_does_not_live_at_the_same_time()


def test_the_root_has_nothing_in_what_takes_the_place_of_its_own():
    """The backward pass makes no joint factors of the root, whose orientation is needed until the end."""
    (longer,) = (name for name, life in LIVES.items() if life.root)
    after = [name for name in LIVES if name != longer and layout()[name] & layout()[longer]]
    assert (longer, after) == ("orientation", ["factor_c"])
    assert np.all([span(LIVES[name])[0] > span(LIVES[longer])[1] for name in after])
