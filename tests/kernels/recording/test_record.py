"""What frames hold: every number of the step in its own place, every so many steps."""

import numpy as np
import pytest
import warp as wp
from probes import filled, units

from warpmuscle.kernels.recording import record as kernels
from warpmuscle.kernels.structs import HINGE, Model, Record, Scratch, Skeleton, State

BODIES, FRAMES = 3, 4
SLOTS = (1, -1, 0)  # of the instances


@wp.kernel(enable_backward=False)
def frames(step: wp.array[int], record: Record, frame: wp.array2d[int]):
    i, k = wp.tid()
    frame[i, k] = kernels.frame_of(i, step[k], record)


def test_a_frame_is_due_every_so_many_steps_of_chosen_instances_while_there_is_room():
    steps, frame = np.arange(0, 40), wp.zeros((3, 40), dtype=int, device="cpu")
    for every in (0, 1, 5):
        record = filled(Record, slot=SLOTS, every=every, coordinates=np.zeros((2, FRAMES, 1)))
        wp.launch(frames, frame.shape, [wp.array(steps, dtype=int, device="cpu"), record, frame], device="cpu")
        due = (steps % max(every, 1) == 0) & (steps < FRAMES * every)
        expected = np.where(due, steps // max(every, 1), -1)
        np.testing.assert_array_equal(frame.numpy(), [expected, np.full(40, -1), expected])


given_way = kernels.record_given_way_of(False)


@wp.kernel(enable_backward=False)
def written(instance: int, frame: int, model: Model, state: State, record: Record, work: Scratch, wanted: Scratch):
    kernels.record_desired(instance, 0, 1, frame, model, state, record, wanted)
    kernels.record_stage(instance, 0, 1, frame, model, state, record, work)
    for lane in range(2):
        given_way(instance, lane, 2, frame, model, record, work)


@pytest.mark.parametrize(("instance", "frame"), [(0, 2), (2, 3), (2, -1)])
def test_every_number_stands_in_its_own_place(instance: int, frame: int):
    random = np.random.default_rng(6)
    state = {
        "coordinates": random.normal(size=(3, 5)), "speeds": random.normal(size=(3, 4)),
        "foot_force": random.normal(size=(3, 2, 3)),
    }  # fmt: skip
    vectors = ("position", "angular_velocity", "torque", "bias", "angular_acceleration")
    of_bodies = {name: random.normal(size=(BODIES, 3)) for name in vectors}
    inner = random.normal(size=(BODIES, 3, 3))
    stiffness = inner + inner.swapaxes(1, 2)
    packed = stiffness[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    center, orientation = random.normal(size=(2, 3)), units(BODIES, 1, 4)
    work = filled(Scratch, **of_bodies, stiffness=packed, center=center, orientation=orientation)
    desired, target = random.normal(size=(BODIES, 3)), units(BODIES, 2, 4)
    wanted = filled(Scratch, torque=desired, target=target)
    plan = {"parent": (-1, 0, 1), "joint_type": (0, HINGE, HINGE)}
    model = filled(Model, body_count=BODIES, skeleton=filled(Skeleton, plan=plan))
    shapes = {
        "coordinates": (5,), "speeds": (4,), "foot_force": (2, 3),
        "com": (2, 3), "orientation": (BODIES, 4), "target": (BODIES, 4), "position": (BODIES, 3),
        "angular_velocity": (BODIES, 3), "torque": (BODIES, 3), "desired_torque": (BODIES, 3),
    }  # fmt: skip
    empty = {name: np.full((2, FRAMES, *shape), 9.0) for name, shape in shapes.items()}
    record = filled(Record, slot=SLOTS, every=1, **empty, stiffness=np.zeros((2, BODIES, 6)))
    inputs = [instance, frame, model, filled(State, **state), record, work, wanted]
    wp.launch(written, 1, inputs, device="cpu")
    turning = of_bodies["angular_acceleration"]
    relative = turning[1:] - turning[:-1] - of_bodies["bias"][1:]
    more = np.concatenate([np.zeros((1, 3)), np.einsum("nij,nj->ni", stiffness[1:], relative)])
    expected = {name: values[instance] for name, values in state.items()} | {
        "com": center, "orientation": orientation, "target": target, "position": of_bodies["position"],
        "angular_velocity": of_bodies["angular_velocity"], "torque": of_bodies["torque"] + more,
        "desired_torque": desired,
    }  # fmt: skip
    for name in shapes:
        got = getattr(record, name).numpy()
        others = np.ones((2, FRAMES), bool)
        if frame >= 0:
            others[SLOTS[instance], frame] = False
            np.testing.assert_allclose(got[SLOTS[instance], frame], expected[name], rtol=1e-5, atol=1e-5, err_msg=name)
        np.testing.assert_array_equal(got[others], 9.0, err_msg=name)
