"""Parts of a working set that lie in a GPU's main memory: here on a CPU, behind the rest, with the same motion."""

import ast
import inspect
import itertools
import textwrap

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.memory import main_memory
from warpmuscle.kernels.memory.main_memory import (
    FIRST_FLOATS,
    LEAN_FLOATS,
    LEANER_FLOATS,
    POSE_FLOATS,
    ROTATION,
    SIDE,
)
from warpmuscle.kernels.memory.scratch import (
    ALL,
    ENTRIES,
    LEAN,
    LEANER,
    LEANEST,
    LIVES,
    NEAR,
    OTHER_FLOATS,
    PHASES,
    POSE,
    SLOT_FLOATS,
    slots_of,
)
from warpmuscle.kernels.step import step_kernel
from warpmuscle.kernels.structs import Record
from warpmuscle.scene import Body, Character, Displacement, Failure, Ground, Joint, Scene
from warpmuscle.simulation.rollout import Rollout

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
WIDTHS = {"floats": 1, "integers": 1, "vectors": 3, "quaternions": 4, "symmetric": 6, "matrices": 9}
ABOVE, BELOW = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)
TURNING, INSTANCES, STEPS = 2.0, 3, 20  # rad/s, of the starts


def body() -> Scene:
    """A shoulder blade that follows the arm, over joints of several types."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("pelvis", "chest", "scapula", "arm", "fore", "head")}
    turns = [Displacement((0.2, 0.9, -0.3), 0.1, 0.4), Displacement(X, polynomial=[0.01, 0.2, -0.03])]
    joints = {
        "waist": Joint("ball", "pelvis", "chest", ABOVE, BELOW),
        "scapular": Joint("coupled", "chest", "scapula", ABOVE, BELOW, rotations=turns, follows="elbow"),
        "shoulder": Joint("universal", "scapula", "arm", ABOVE, BELOW, [X, Z]),
        "elbow": Joint("hinge", "arm", "fore", ABOVE, BELOW, [X]),
        "neck": Joint("slide", "chest", "head", BELOW, ABOVE, [Y]),
    }
    character = Character("pelvis", bodies, joints, "free")
    return Scene("body", character, ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))


def moved(rollout: Rollout, main: int) -> np.ndarray:
    """Where instances come to; their memory holds no numbers at first, so that what has no place of its own shows."""
    config = rollout._launcher.config
    config = config.compiling(skeleton=config.kind.skeleton._replace(main=main))
    rollout.reset()
    speeds = rollout.state.speeds
    speeds.assign(np.random.default_rng(1).uniform(-TURNING, TURNING, speeds.shape).astype(np.float32))
    far = config.buffer_floats(INSTANCES) if main > NEAR else 0
    memory = wp.full(config.work_floats + far, np.nan, dtype=float, device="cpu")
    running = wp.array(np.arange(INSTANCES), dtype=int, device="cpu")
    given = [
        STEPS, running, rollout.model, rollout.state, Record(), wp.uint64(memory.ptr), rollout._extensions.struct
    ]  # fmt: skip
    wp.launch(step_kernel(*config), (INSTANCES, 1), given, device="cpu", block_dim=1)
    return rollout.state.coordinates.numpy()


@pytest.mark.long
@pytest.mark.usefixtures("unoptimized_kernels")
def test_motion_is_the_same_wherever_numbers_lie():
    rollout = Rollout(body(), INSTANCES, "cpu", threads=1)
    near = moved(rollout, NEAR)
    assert np.ptp(near, axis=0).max() > 1e-3
    assert np.isfinite(near).all()
    for main in (ENTRIES, LEAN, LEANER, LEANEST, ALL):
        np.testing.assert_array_equal(moved(rollout, main), near)


@pytest.mark.parametrize("fields", [main_memory.PLACED, main_memory.REDUCED, main_memory.ACCELERATED])
def test_what_is_fetched_ahead_is_of_records_each_asked_for_once(fields: tuple[str, ...]):
    records = {
        line.targets[0].attr: (function.__name__, ast.unparse(line.value.args[1]))
        for function in (main_memory.lean_at.func, main_memory.leaner_at.func, main_memory.first_at.func)
        for line in ast.parse(textwrap.dedent(inspect.getsource(function))).body[0].body
        if isinstance(line, ast.Assign)
    }
    asked = [records[name] for name in fields]
    assert len(set(asked)) == len(asked)


def test_main_memory_has_room_for_whole_groups_of_instances():
    config = Rollout(body(), 1, "cpu")._launcher.config
    skeleton, bodies = config.kind.skeleton, config.capacity
    rest = SLOT_FLOATS * slots_of(bodies) + OTHER_FLOATS + skeleton.open * (skeleton.open + 1)
    sizes = (
        13 * skeleton.entries, LEAN_FLOATS * bodies, LEANER_FLOATS * bodies, FIRST_FLOATS * bodies + rest,
        POSE_FLOATS * bodies,
    )  # fmt: skip
    before = config
    for main, floats in zip((ENTRIES, LEAN, LEANER, LEANEST, ALL), np.cumsum(sizes), strict=True):
        other = config.compiling(skeleton=skeleton._replace(main=main))
        for instances, rows in ((1, SIDE), (SIDE, SIDE), (SIDE + 1, 2 * SIDE)):
            assert other.buffer_floats(instances) == floats * rows
        assert other.work_floats < before.work_floats
        before = other


@pytest.mark.parametrize(
    ("function", "floats"),
    [
        (main_memory.lean_at, LEAN_FLOATS),
        (main_memory.leaner_at, LEANER_FLOATS),
        (main_memory.first_at, FIRST_FLOATS),
        (main_memory.poses_at, POSE_FLOATS),
    ],
)
def test_only_what_is_alike_and_does_not_live_at_the_same_time_shares_a_place(function, floats: int):
    known = {"first": 0, "n": 1, "ROTATION": ROTATION, "POSE": POSE}
    places = {}
    for line in ast.parse(textwrap.dedent(inspect.getsource(function.func))).body[0].body:
        if isinstance(line, ast.Assign):
            first, record, offset = (eval(ast.unparse(part), known) for part in line.value.args[1:4])
            width = WIDTHS[ast.unparse(line.value.func).removesuffix("_apart")]
            assert offset + width <= record
            places[line.targets[0].attr] = first + offset, first + offset + width, first, first + record
    assert max(end for *_, end in places.values()) == floats
    for (a, one), (b, other) in itertools.combinations(places.items(), 2):
        if max(one[2], other[2]) < min(one[3], other[3]):  # of the same records
            assert one[2:] == other[2:], (a, b)
        if max(one[0], other[0]) < min(one[1], other[1]):
            assert one == other, (a, b)
            (first, last), (begin, end) = (map(PHASES.index, LIVES[name][:2]) for name in (a, b))
            assert last < begin or end < first, (a, b)
