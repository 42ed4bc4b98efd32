"""The arm with muscles over the bones: moment arms as published, and the forces that fits compute those of the step."""

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene import CylinderSurface, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import start_values
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.throw.arm import Arm, needed_torques, start_coordinates
from warpmuscle.throw.computed_synergies import computed_synergies
from warpmuscle.throw.motion import resample
from warpmuscle.throw.recordings.arm_motions import motion_of
from warpmuscle.throw.signals import computed_activation, to_activation

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

ANGLES = np.radians([[s, e, w] for s in (0, 30, 75, 120, 150) for e in (10, 45, 75, 110) for w in (-40, 0, 40)])


@pytest.fixture(scope="module")
def arm() -> Arm:
    return Arm(load("throw18"))


def moment_arms(arm: Arm, angles: np.ndarray) -> dict[str, np.ndarray]:
    """Moment arms (S, 3), m, of each muscle."""
    found = arm.geometry.at(np.asarray(angles, float))[1]
    return {name: found[:, k] for k, name in enumerate(arm.muscles)}


def test_at_least_sixteen_muscles_cross_the_joints_that_they_cross_in_a_body(arm: Arm):
    assert len(arm.muscles) >= 16
    two = {name for name, joints in arm.crossed.items() if len(joints) == 2}
    assert two == {"BIClong", "BICshort", "TRIlong", "FCR", "FCU", "ECRL", "ECRB", "ECU", "FDS"}
    assert arm.joints == ("shoulder", "elbow", "wrist")


def test_elbow_muscles_have_the_moment_arms_of_arm26(arm: Arm, reference_data: Path):
    """OpenSim 4.6 in 200 poses: within 2 mm in the mean, 4 mm at worst, over the elbow's range in a throw."""
    with np.load(reference_data / "opensim_reference" / "arm26_path_reference.npz") as file:
        q, published, names = file["q"], file["moment_arm"][:, :, 1], list(file["muscle_names"])
    inside = (q[:, 1] > np.radians(10.0)) & (q[:, 1] < np.radians(115.0))
    angles = np.column_stack([np.full(inside.sum(), 0.5), q[inside, 1], np.zeros(inside.sum())])
    ours = moment_arms(arm, angles)
    for k, name in enumerate(names):
        off = np.abs(ours[name][:, 1] - published[inside, k])
        assert off.mean() < 0.002, (name, off.mean())
        assert off.max() < 0.004, (name, off.max())


def test_shoulder_and_wrist_muscles_have_moment_arms_within_published_ranges(arm: Arm, reference_data: Path):
    """Means of the model of Saul 2015 over a joint's range: within 6 mm at the shoulder, 2 mm at the wrist."""
    data = json.loads((reference_data / "arm_parameters" / "arm_parameters.json").read_text())["muscles"]
    sweep = np.radians(np.linspace(0.0, 150.0, 31))
    shoulder = moment_arms(arm, np.column_stack([sweep, np.full(31, 1.5), np.zeros(31)]))
    bend = np.radians(np.linspace(-40.0, 40.0, 21))
    wrist = moment_arms(arm, np.column_stack([np.full(21, 1.0), np.full(21, 1.5), bend]))
    published = data["m1_deltoid_anterior"]["moment_arm_m"]
    assert published["min"] < shoulder["DELT1"][:, 0].min() < shoulder["DELT1"][:, 0].max() < published["max"]
    back, low, high = shoulder["DELT3"][:, 0], -0.0282, 0.0225
    assert back.min() == pytest.approx(low, abs=0.006)
    assert back[sweep < np.radians(100.0)].max() == pytest.approx(high, abs=0.006)  # it comes to flex, as there
    triceps = data["m4_triceps_long"]["moment_arm_m"]["MoBL_shoulder_mean"]
    assert shoulder["TRIlong"][:, 0].mean() == pytest.approx(triceps, abs=0.006)
    for name, muscle in (("FCR", "m5_wrist_flexor_FCR"), ("ECU", "m6_wrist_extensor_ECU")):
        mean = data[muscle]["moment_arm_m"]["MoBL_wrist_mean"]
        assert wrist[name][:, 2].mean() == pytest.approx(mean, abs=0.002)
    signs = {"FCR": 1, "FCU": 1, "FDS": 1, "ECRL": -1, "ECRB": -1}
    assert all(np.all(sign * wrist[name][:, 2] > 0.004) for name, sign in signs.items())


def test_moment_arms_are_the_slopes_of_lengths(arm: Arm):
    length, arms = arm.geometry.at(ANGLES)
    for joint in range(3):
        step = np.zeros(3)
        step[joint] = 0.01
        ahead, behind = (arm.geometry.at(ANGLES + sign * step)[0] for sign in (1.0, -1.0))
        slope = -(ahead - behind) / 0.02
        assert np.abs(slope - arms[:, :, joint]).max() < 5e-4
    assert length.min() > 0.02


def test_no_path_jumps_over_a_surface(arm: Arm):
    """A length never changes by more than the largest moment arm allows."""
    sweep = np.radians(np.linspace(-55.0, 185.0, 246))
    for elbow in (0.2, 1.2, 2.0):
        length = arm.geometry.at(np.column_stack([sweep, np.full(246, elbow), np.zeros(246)]))[0]
        assert np.abs(np.diff(length, axis=0)).max() < 0.09 * (sweep[1] - sweep[0])


@pytest.mark.long
def test_fits_compute_the_forces_and_torques_of_the_step(arm: Arm):
    motion = resample([motion_of(arm.scene, arm)])
    scene = msgspec.structs.replace(arm.simulated, duration=0.02)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0, quantities=["muscle_force"])
    excitation = np.linspace(0.1, 0.9, len(arm.muscles))
    pose = start_coordinates(arm)
    pose[arm.coordinate_places] = motion.angles[0][0, 60]
    speeds = np.zeros(arm.names.speeds)
    speeds[arm.speed_places] = motion.angles[1][0, 60]
    rollout.set_excitations(np.zeros(1), excitation[None, :, None])
    rollout.set_initial(pose[None], speeds[None], excitation[None])
    rollout.run()
    table = arm.muscle_table(arm.unknowns(start_values(arm.scene))[None])
    angle, speed = (part[0, 60:61] for part in motion.angles[:2])
    ours = table.forces(excitation[None], angle, speed)[0, 0]
    np.testing.assert_allclose(rollout.recorded("muscle_force")[0, 0], ours, rtol=2e-3, atol=0.2)
    torque = table.torques(excitation[None], angle, speed)[0, 0]
    np.testing.assert_allclose(torque, ours[:, None] * arm.geometry.at(angle)[1][0], rtol=1e-9)


def test_computed_activations_make_the_torques_that_a_throw_needs(arm: Arm):
    motion = resample([motion_of(arm.scene, arm)])
    values = arm.unknowns(start_values(arm.scene))
    activation, found = computed_activation(arm, motion, values)
    assert found.feasible.all(), found.explanation(arm.muscles, arm.driven, motion.time)
    made = arm.muscle_table(values[None]).torques(activation[0], motion.angles[0][0], motion.angles[1][0])[0]
    needed = needed_torques(arm, motion)[0]
    np.testing.assert_allclose(made.sum(axis=1), needed, atol=0.02 * np.abs(needed).max())


def test_free_points_of_paths_are_refused_in_a_line():
    def with_free_radius(scene: Scene) -> Scene:
        surfaces = dict(scene.character.surfaces)
        surface = surfaces["armpit"]
        assert isinstance(surface, CylinderSurface)
        surfaces["armpit"] = msgspec.structs.replace(surface, radius=Free(0.02, 0.01, 0.03))
        return msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, surfaces=surfaces))

    with pytest.raises(SceneError, match=r"character\.surfaces\.armpit\.radius: .* are not free"):
        Arm(with_free_radius(load("throw18")))


def test_synergies_of_many_muscles_explain_the_torque_of_every_joint_and_none_is_one_muscle(arm: Arm):
    motions = resample([motion_of(arm.scene, arm)])
    synergies, lacks = computed_synergies(arm, motions, arm, 5)
    assert not lacks
    assert np.all(synergies.weights.max(axis=0) / synergies.weights.sum(axis=0) < 0.6)
    table = arm.muscle_table(arm.unknowns(start_values(arm.scene))[None])
    angle, speed = (part[0] for part in motions.angles[:2])
    activation = to_activation(arm, synergies.excitation(synergies.signals), synergies.excitation(synergies.start))[0]
    made = table.torques(activation, angle, speed)[0].sum(axis=1)
    needed = needed_torques(arm, motions)[0]
    missed = np.mean((made - needed) ** 2, axis=0) / needed.var(axis=0)
    assert missed.max() < 0.1, missed


@pytest.mark.long
def test_muscles_in_three_dimensions_turn_the_joints_the_way_that_they_do_in_a_body():
    """In the middle of a throw's range; and together they suffice for it."""
    arm = Arm(load("throw23"))
    motions = resample([motion_of(arm.scene, arm)])
    found = moment_arms(arm, motions.angles[0][0, 40:100:20])
    expected = {
        "shoulder": {"DELT1": 1, "LAT": -1, "TRIlong": -1},
        "shoulder_abduction": {"DELT2": 1, "PECM1": -1, "LAT": -1},
        "shoulder_rotation": {"SUBSC": 1, "PECM1": 1, "INFSP": -1},
        "elbow": {"BIClong": 1, "BRA": 1, "BRD": 1, "TRIlat": -1},
        "forearm_rotation": {"PT": 1, "SUP": -1, "BIClong": -1},
        "wrist_deviation": {"FCR": 1, "ECRL": 1, "FCU": -1, "ECU": -1},
        "wrist": {"FCR": 1, "FCU": 1, "FDS": 1, "ECRL": -1, "ECRB": -1, "ECU": -1},
    }
    assert arm.joints == tuple(expected)
    for column, signs in enumerate(expected.values()):
        for name, sign in signs.items():
            assert np.all(sign * found[name][:, column] > 0.001), (arm.joints[column], name, found[name][:, column])
    _, solved = computed_activation(arm, motions, arm.unknowns(start_values(arm.scene)))
    assert solved.feasible.all(), solved.explanation(arm.muscles, arm.driven, motions.time)
