"""What is recorded: by itself, from arrays that stand for those of a step."""

from operator import attrgetter

import numpy as np
import pytest
import warp as wp

from small_scene import muscle_scene
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels.recording.record import RecordKind
from warpmuscle.model.structure import structure_of
from warpmuscle.results.recorded_quantities import MUSCLE_QUANTITIES
from warpmuscle.scene.topology import coordinate_names, coordinate_units
from warpmuscle.simulation.recorder import SIZES, Recorder, check_room, frame_bytes, frame_steps, record_kind

STRUCTURE = structure_of(muscle_scene())


def recorder(kind: RecordKind = RecordKind()) -> Recorder:  # noqa: B008
    """Instances 4 and 1 of 5, every 10 of 95 steps."""
    frames = Recorder(STRUCTURE, 5, [4, 1], 10, 95, "cpu", kind)
    frames.record.orientation.fill_(wp.quat_identity())
    return frames


def test_frames_have_room_for_what_is_recorded_and_for_nothing_else():
    whole, some = recorder(), recorder(record_kind(["speeds"]))
    assert whole.record.slot.numpy().tolist() == [-1, 1, -1, -1, 0]
    sizes = {name: attrgetter(name)(whole.record).capacity for name in SIZES}
    assert sum(sizes.values()) == 2 * 10 * frame_bytes(STRUCTURE)
    assert {name for name in SIZES if attrgetter(name)(some.record).size} == {"coordinates", "speeds"}


def test_frames_hold_phases_of_a_machine_only_where_there_is_one():
    scene = muscle_scene()
    frames = recorder()
    assert frames.record.simbicon.phase.shape == (2, 10)
    scene.controller, scene.control_rate = None, 0.0
    without = Recorder(structure_of(scene), 5, [4, 1], 10, 95, "cpu")
    without.record.orientation.fill_(wp.quat_identity())
    motion = without.recording(scene, 4, 95)
    assert (without.record.simbicon.phase.size, motion.phase.shape, motion.frames) == (0, (0,), 10)
    assert motion.missing == ("phase", "stance", "state")


def test_values_are_those_of_the_chosen_in_their_order_until_their_end():
    frames = recorder()
    speeds = np.random.default_rng(1).normal(size=frames.record.speeds.shape).astype(np.float32)
    frames.record.speeds.assign(speeds)
    np.testing.assert_array_equal(frames.values("speeds", 41), speeds[:, :5])
    ended = np.array([0, 20, 0, 0, 41])  # steps, so that instance 1 has frames at steps 0 and 10
    until = frames.values_until("speeds", 41, ended)
    np.testing.assert_array_equal(until[0], speeds[0, :5])
    np.testing.assert_array_equal(until[1], np.where(np.arange(5)[:, None] < 2, speeds[1, :5], 0.0))
    muscle = np.random.default_rng(2).normal(size=frames.record.muscle.shape).astype(np.float32)
    frames.record.muscle.assign(muscle)
    k = list(MUSCLE_QUANTITIES).index("muscle_force")
    np.testing.assert_array_equal(
        frames.values("muscle_force", 95), muscle[:, :, k, : len(STRUCTURE.actuation.muscles)]
    )
    frames.clear()
    assert not frames.values("speeds", 95).any()


def test_a_recording_begins_where_it_is_asked_to_and_ends_with_the_instance():
    frames, scene = recorder(), muscle_scene()
    frames.record.simbicon.phase.assign(np.arange(20.0).reshape(2, 10).astype(np.float32))
    step = scene.time_step
    assert frames.recording(scene, 1, 35).phase.tolist() == [10.0, 11.0, 12.0, 13.0]
    late = frames.recording(scene, 4, 95, start=25.0 * step)
    assert late.phase.tolist() == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    np.testing.assert_allclose(late.time, np.arange(30, 100, 10) * step)


def test_what_was_not_recorded_is_refused():
    frames = recorder(record_kind(["coordinates"]))
    assert (frames.instance(None), frames.instance(1)) == (4, 1)
    for call, message in (
        (lambda: frames.instance(0), "instance 0 was not recorded"),
        (lambda: frames.values("speed", 5), "'speed' was not recorded"),
        (lambda: frames.recording(muscle_scene(), 1, 5), "only some quantities"),
        (lambda: Recorder(STRUCTURE, 2, [], 1, 5, "cpu").values("speeds", 5), "no instance was recorded"),
        (lambda: record_kind(["speed"]), "no quantity 'speed'"),
        (lambda: check_room(STRUCTURE, 1, 10**12, "cpu"), "frames"),
    ):
        with pytest.raises(RolloutError, match=message):
            call()


@pytest.mark.parametrize(("rate", "steps"), [(1e9, 1), (100.0, 20), (0.15, 13333), (1e-9, 20000)])
def test_frames_are_whole_steps_apart_and_never_farther_than_the_simulation_is_long(rate: float, steps: int):
    scene = muscle_scene()
    scene.duration, scene.time_step = 10.0, 1.0 / 2000.0
    assert frame_steps(scene, rate) == steps


def test_coordinates_and_speeds_are_recorded_under_their_names():
    frames, scene = recorder(), muscle_scene()
    room = frames.record.coordinates.numpy()
    frames.record.coordinates.assign(np.arange(room.size, dtype=np.float32).reshape(room.shape))
    motion = frames.recording(scene, 4, 35)
    assert (motion.coordinate_names, motion.speed_names) == coordinate_names(STRUCTURE.names, scene.character)
    units = coordinate_units(STRUCTURE.names, scene.character)
    assert (motion.coordinate_units, motion.speed_units) == units
    assert dict(zip(motion.coordinate_names, motion.coordinate_units, strict=True))["root.qw"] == "1"
    assert motion.coordinate.shape == (4, STRUCTURE.names.coordinates)
    last = motion.coordinate_names.index(scene_joint := STRUCTURE.names.joints[-1])
    assert scene_joint in motion.speed_names
    assert np.array_equal(motion.coordinate[:, last], frames.record.coordinates.numpy()[0, :4, last])
