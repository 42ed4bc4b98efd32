"""Ground forces from motions: what the root needs comes out, within cones of friction, under the foot that stands."""

from types import SimpleNamespace

import numpy as np
import pytest

import small_leg
import warpmuscle as wm
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyModel, Dynamics
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.trial import Coordinates
from warpmuscle.inverse.without_plates.contact_points import Points, contact_points
from warpmuscle.inverse.without_plates.ground_forces import FRICTION, _shared, ground_forces
from warpmuscle.scene.topology import topology

ROOT = np.array([[0.0, 0.95, 0.0]])
FOOT = np.array([[x, 0.0, z] for x in (-0.03, 0.03) for z in (-0.05, 0.1, 0.16)])


def points(left: float, right: float) -> Points:
    """Two feet 20 cm beside each other, the left one 50 cm ahead; reluctances of their points."""
    place = np.concatenate([FOOT + np.array([0.1, 0.0, 0.3]), FOOT - np.array([0.1, 0.0, 0.2])])[None]
    return Points(np.repeat([0, 1], 6), place, np.repeat([[left, right]], 6, axis=1), (0, 0))


def wrench(force: np.ndarray, place: np.ndarray) -> np.ndarray:
    return np.concatenate([force.sum(axis=0), np.cross(place - ROOT[0], force).sum(axis=0)])[None]


def test_forces_sum_up_to_what_the_root_needs_within_cones_of_friction():
    both = points(1.0, 1.0)
    given = np.zeros((12, 3))
    given[[1, 9]] = [[10.0, 400.0, -80.0], [-10.0, 350.0, 70.0]]
    want = wrench(given, both.place[0])
    found = _shared(both, want, ROOT)
    again = wrench(found[0], both.place[0])
    assert again[0, :3] == pytest.approx(want[0, :3], abs=8.0)
    assert again[0, 3:] == pytest.approx(want[0, 3:], abs=4.0)
    assert (found[..., 1] >= 0.0).all()
    assert (np.abs(found[..., [0, 2]]).sum(axis=-1) <= FRICTION * found[..., 1] + 1e-9).all()
    feet = found[0].reshape(2, 6, 3).sum(axis=1)
    assert feet[0, 2] < -40.0  # the one ahead brakes
    assert feet[1, 2] > 40.0


@pytest.mark.parametrize("side", [0, 1])
def test_a_foot_in_the_air_bears_little(side):
    reluctance = [1.0, 1.0]
    reluctance[side] = 300.0
    one = points(*reluctance)
    given = np.zeros((12, 3))
    given[6 * (1 - side) + 1] = [0.0, 700.0, 0.0]
    found = _shared(one, wrench(given, one.place[0]), ROOT)[0].reshape(2, 6, 3).sum(axis=1)
    assert found[1 - side, 1] == pytest.approx(700.0, rel=0.02)
    assert found[side, 1] < 10.0


def test_points_of_feet_count_less_the_higher_they_are():
    scene = wm.load("gait2392_walk")
    names = topology(scene.character)
    count, frames = len(names.bodies), 50
    place = np.zeros((frames, count, 3))
    turn = np.tile([0.0, 0.0, 0.0, 1.0], (frames, count, 1))
    toes = names.bodies.index("toes_l")
    place[25:, toes, 1] = 0.1
    nothing = np.zeros((frames, count, 3))
    body = SimpleNamespace(scene=scene, topology=names)
    found = contact_points(body, np.arange(frames) / 100.0, Dynamics(nothing, nothing, nothing, nothing, place, turn))
    assert [names.bodies[k] for k in found.bodies] == ["calcn_l", "calcn_r"]
    assert found.foot.tolist() == [0] * 6 + [1] * 6
    assert found.reluctance[40] == pytest.approx([1.0, *[1.0 + 3.0 * (0.1 / 0.015) ** 2] * 2] * 2 + [1.0] * 6)
    assert not found.place[..., 1].any()


def test_a_model_without_two_feet_is_refused(tmp_path):
    body = BodyModel(small_leg.small_leg(tmp_path), "cpu")
    with pytest.raises(ArgumentError, match="need two feet"):
        ground_forces(body, small_leg.motion(8))


def test_a_measured_walk_stands_on_its_plates(reference_data):
    folder = reference_data / "opensim_walk"
    body = BodyModel(folder / "subject01.osim", "cpu")
    motion = read_coordinates(folder / "ik/subject01_walk_IK.mot", body.scene)
    motion = Coordinates(motion.names, motion.times[30:110], motion.values[30:110])
    loads = read_loads(folder / "subject01_walk_grf.xml")
    measured = {plate.body: plate for plate in loads.plates}
    for plate in ground_forces(body, motion, 6.0).plates:
        wanted = np.stack([np.interp(motion.times, loads.times, x) for x in measured[plate.body].force.T], axis=1)
        rms = np.sqrt(np.mean((plate.force - wanted)[5:-5] ** 2, axis=0)) / np.abs(wanted).max(axis=0)
        assert rms[1] < 0.08
        assert rms[0] < 0.12
