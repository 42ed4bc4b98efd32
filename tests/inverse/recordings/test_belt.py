"""A walk on a treadmill, recorded, measures as the same walk over the ground."""

import numpy as np
import pytest

from osim_models import LINE, axes, body, coordinate, joint, model, written
from warpmuscle.core.array_types import Floats
from warpmuscle.gait.measures import measure
from warpmuscle.gait.quality import gait_measures
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.gait.sides import measures_of_sides
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.output import Trial, write_result
from warpmuscle.inverse.recordings.belt import belt_of, belt_velocity
from warpmuscle.inverse.recordings.measured import Measured
from warpmuscle.inverse.recordings.motion import scene_with_feet
from warpmuscle.inverse.steps import run_steps
from warpmuscle.inverse.trial import Coordinates, Loads, Plate
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read
from warpmuscle.scene import Scene
from warpmuscle.scene.treadmill.belt_motion import MEASURED_BELT
from warpmuscle.view.track import track_of

SPEED, BELT = 1.2, 1.2  # m/s
STRIDE, STANCE = 1.0, 0.6  # s, and the part of it that a foot stands
TIMES = np.arange(0.0, 6.0001, 0.01)
APART = 0.1  # m, of the feet
WEIGHT = 12.0 * 9.81  # N
SIDES = {"l": (0.0, -1.0), "r": (0.5, 1.0)}  # when in the stride a foot lands, and where it is along OpenSim's z
ROOT = ("pelvis_tx", "pelvis_ty", "pelvis_tz")


def walker() -> str:
    """A pelvis that does not turn, above two feet that slide forwards below it."""
    slides = {f"translation{k + 1}": (ROOT[k], axis, LINE) for k, axis in enumerate(("1 0 0", "0 1 0", "0 0 1"))}
    small = "0.01 0.01 0.01 0 0 0"
    bodies = body("pelvis", 10.0, "0 0 0", small) + body("calcn_l", 1.0, "0 0 0", small)
    joints = joint("CustomJoint", "ground_pelvis", "ground", "pelvis", "".join(map(coordinate, ROOT)), axes(**slides))
    for side, (_, out) in SIDES.items():
        name = f"reach_{side}"
        way = axes(translation1=(name, "1 0 0", LINE))
        place = f"0 -0.9 {out * APART:g}"
        joints += joint("CustomJoint", name, "pelvis", f"calcn_{side}", coordinate(name), way, place=place)
    return model(bodies + body("calcn_r", 1.0, "0 0 0", small), joints, "")


def ahead(landing: float) -> Floats:
    """How far a foot is over the ground, m: it stands, then swings to where it stands next."""
    turns = TIMES / STRIDE - landing
    number, part = np.floor(turns), turns - np.floor(turns)
    swing = np.clip((part - STANCE) / (1.0 - STANCE), 0.0, 1.0)
    return np.asarray(SPEED * STRIDE * (number + landing + 0.3 + swing**2 * (3.0 - 2.0 * swing)))


def walked(belt: float) -> tuple[Coordinates, Loads]:
    """Coordinates and plates of the walk, all of which a belt carries backwards."""
    back = belt * TIMES
    values = {"pelvis_tx": SPEED * TIMES - back, "pelvis_ty": np.full(len(TIMES), 0.9), "pelvis_tz": 0.0 * TIMES}
    plates = []
    for side, (landing, out) in SIDES.items():
        place = ahead(landing)
        values[f"reach_{side}"] = place - SPEED * TIMES
        part = np.mod(TIMES / STRIDE - landing, 1.0)
        force = np.zeros((len(TIMES), 3))
        force[:, 1] = np.where(part < STANCE, WEIGHT, 0.0)
        point = np.stack([place - back, np.zeros(len(TIMES)), np.full(len(TIMES), out * APART)], axis=1)
        plates.append(Plate(side, f"calcn_{side}", force, point, np.zeros_like(force)))
    return Coordinates(tuple(values), TIMES, np.stack(list(values.values()), axis=1)), Loads(TIMES, tuple(plates))


@pytest.fixture(scope="module")
def trials(tmp_path_factory) -> tuple[BodyModel, list[Trial]]:
    """The walk over the ground, and on a belt."""
    body = BodyModel(written(tmp_path_factory.mktemp("walker"), walker()), "cpu")
    motions, loads = zip(*map(walked, (0.0, BELT)), strict=True)
    return body, run_steps(body, ("id",), ("ground", "belt"), motions, loads, recorded=True)


def recordings(trials: tuple[BodyModel, list[Trial]]) -> tuple[Scene, Recording, Recording]:
    body, (ground, belt) = trials
    assert ground.recording is not None
    assert belt.recording is not None
    return scene_with_feet(body.scene), ground.recording, belt.recording


@pytest.mark.usefixtures("unoptimized_kernels")
def test_a_recorded_walk_on_a_belt_measures_as_over_the_ground(trials):
    scene, ground, belt = recordings(trials)
    assert ground.recorded_names == ()
    assert belt.recorded_names == MEASURED_BELT
    assert belt_of(belt) == pytest.approx([0.0, 0.0, -BELT], abs=1e-3)
    assert np.ptp(belt.com[:, 2]) < 0.2 < np.ptp(over_belts(belt, scene).com[:, 2])
    here, there = measure(ground, scene), measure(belt, scene)
    assert (here.speed_forward, here.step_length) == pytest.approx((SPEED, 0.5 * SPEED * STRIDE), abs=5e-3)
    for name in ("speed_forward", "speed_horizontal", "step_length", "step_width", "cadence"):
        assert getattr(there, name) == pytest.approx(getattr(here, name), abs=2e-3), name
    sides = measures_of_sides(belt, scene)["step length"]
    assert (sides.left, sides.right) == pytest.approx((0.6, 0.6), abs=5e-3)
    rows, again = gait_measures(ground, scene), gait_measures(belt, scene)
    assert rows.keys() == again.keys()
    for name, value in rows.items():
        assert (again[name] is None) == (value is None), name
        if value is not None:
            assert again[name] == pytest.approx(value, abs=max(0.01 * abs(value), 0.02)), name


@pytest.mark.usefixtures("unoptimized_kernels")
def test_a_file_keeps_the_belt_and_the_viewer_moves_what_was_measured_with_it(trials, tmp_path):
    body, found = trials
    write_result(tmp_path / "walk.h5", found, {}, body)
    scene, ground, belt = recordings(trials)
    kept = read(tmp_path / "walk.h5").replays
    assert belt_of(kept[0]).tolist() == [0.0, 0.0, 0.0]
    assert belt_of(kept[1]) == pytest.approx(belt_of(belt))
    plain, moved = (
        track_of(one, scene, measured=trial.measured) for one, trial in zip((ground, belt), found, strict=True)
    )
    assert isinstance(moved.measured, Measured)
    assert isinstance(plain.measured, Measured)
    loaded = plain.measured.force[..., 1] > 0.0
    away = (moved.measured.point - plain.measured.point)[loaded]
    assert np.abs(away).max() < 0.01
    assert moved.recording.com == pytest.approx(plain.recording.com, abs=0.01)


@pytest.mark.parametrize("velocity", [(0.0, -1.3), (0.9, -0.6), (0.0, 0.1)])
def test_a_rolling_foot_tells_the_belt_by_the_point_that_is_loaded(velocity):
    """A wheel of 0.2 m rolls on the belt; its centre does not move as the belt does, its lowest point does."""
    times, radius = np.linspace(0.0, 0.5, 51), 0.2
    belt = np.array([velocity[0], 0.0, velocity[1]])
    spin, ahead = np.broadcast_to([2.0, 0.0, 0.0], (51, 1, 3)), np.array([0.0, 0.0, 2.0 * radius])  # rad/s, m/s
    centre = (times[:, None] * (belt + ahead) + [0.0, radius, 0.0])[:, None]
    force = np.broadcast_to([0.0, 700.0, 0.0], (51, 1, 3))
    found = belt_velocity(times, centre, spin, force, centre - [0.0, radius, 0.0])
    assert found == pytest.approx(np.where(np.abs(belt) > 0.2, belt, 0.0), abs=1e-9)


def test_without_a_load_there_is_no_belt():
    times, still = np.linspace(0.0, 0.5, 51), np.zeros((51, 1, 3))
    gone = still + times[:, None, None]
    assert not belt_velocity(times, gone, still, still, gone).any()
    assert not belt_velocity(times, gone[:, :0], still[:, :0], still[:, :0], gone[:, :0]).any()
