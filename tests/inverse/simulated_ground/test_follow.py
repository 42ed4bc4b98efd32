"""A squat that runs forward on the ground: near the recording, by itself, and as Newton asks for."""

import numpy as np
import pytest

import small_squat
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.simulated_ground.windows import Windows
from warpmuscle.inverse.tracking.track import track
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.without_plates.ground_forces import ground_forces
from warpmuscle.simulation.rollout import Rollout

WINDOW, MASS = 0.015, 45.0 + 2 * (8.0 + 3.7 + 1.2 + 0.2)


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_squat.small_squat(tmp_path_factory.mktemp("squat")), "cpu")


@pytest.fixture(scope="module")
def squat(body, unoptimized_kernels) -> Tracked:
    recorded = small_squat.motion()
    found = track(body, recorded, ground_forces(body, recorded), begin=0.05, end=0.26, ground=True, reserve=1.0)
    assert isinstance(found, Tracked)
    return found


def test_a_squat_stays_near_the_recording_and_nothing_acts_beside_muscles(squat):
    assert squat.lost is None
    assert np.degrees(squat.rms).max() < 1.0
    assert not squat.effort[:, : squat.residuals].any()
    assert squat.greatest_effort.max() < 0.1


@pytest.mark.usefixtures("unoptimized_test")
def test_excitations_run_the_squat_by_themselves(squat):
    scene = squat.ground.scene
    rollout = Rollout(scene, 1, "cpu")
    rollout.set_initial(squat.start[0][None], squat.start[1][None], squat.activation[:1])
    for row in squat.excitation:
        rollout.step(round(WINDOW / scene.time_step), excitations=row[None].astype(np.float32))
    end = BodyModel(scene, "cpu").map.values(rollout.state.coordinates.numpy().astype(np.float64))[0]
    assert end == pytest.approx(squat.values[-1], abs=2e-3)  # reserves of some mN m did not act here
    assert rollout.state.foot_force.numpy()[0, :, 1] == pytest.approx(squat.ground.force[-1, :, 1], rel=0.02)


def test_the_ground_carries_the_weight_and_what_accelerates_it(squat):
    up = squat.ground.force[..., 1].sum(axis=1)
    plates = squat.ground.plates[..., 1].sum(axis=1)
    assert plates.mean() == pytest.approx(9.80665 * MASS, rel=0.1)
    assert up[5:] == pytest.approx(plates[5:], rel=0.1)
    assert squat.ground.force_error[:, 1].max() < 0.1 * plates.max()
    assert np.abs(squat.ground.lift).max() < 0.02
    assert not squat.ground.belt.any()


def test_windows_of_a_body_in_the_air_change_as_it_flies(squat):
    windows = Windows(squat.ground.scene, "cpu", WINDOW)
    q, v = (np.asarray(one, float)[None].copy() for one in squat.start)
    q[:, 0] += 1.0  # the root's height comes first
    effort = np.zeros((1, windows.efforts))
    by_state, by_effort = windows.derivatives(q, v, effort, windows.run(q, v, effort))
    speeds = windows.speeds
    assert by_state[0, :2, :2] == pytest.approx(np.eye(2), abs=1e-3)
    assert by_state[0, :2, speeds : speeds + 2] == pytest.approx(WINDOW * np.eye(2), abs=2e-4)
    away = by_effort[0, speeds:, :]
    assert (np.diag(away[3:]) > 0.0).all()  # each joint goes where its effort pushes
