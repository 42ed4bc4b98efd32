"""Legacy muscles in the states of the original program's recordings give what that program recorded."""

from pathlib import Path

import numpy as np
import pytest

from biped import xyzw
from warpmuscle.formats import load
from warpmuscle.scene import MuscleModel
from warpmuscle.simulation.stages import Stages

pytestmark = pytest.mark.filterwarnings(
    "ignore::warpmuscle.scene.validation.muscles.SceneWarning"
)  # of slack lengths, rightly

RECORDINGS = {  # character, controller
    "V2M56_fWalk": ("allUniArticularMuscles", "fWalk"),
    "V2M44_fWalk001_groundB": ("allUniArticularMuscles_butHips", "fWalk001"),
}
QUANTITIES = ("path_length", "fibre_length", "fibre_velocity", "desired_force", "excitation", "activation", "force")


@pytest.fixture(scope="module", params=RECORDINGS)
def both(request: pytest.FixtureRequest, reference_data: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Ours and the original's, by quantity, (steps, muscles) or (steps, joints, 3); steps are one after the other."""
    character, controller = RECORDINGS[request.param]
    folder = reference_data / "simbicon"
    recording = folder / "reference" / f"fullrate_bip{request.param}.npz"
    if not recording.is_file():
        pytest.skip(f"no {recording}")
    scene = load(
        folder / f"characters/bipV2M/bipV2M_save_{character}.rbs", folder / f"controllers/bipV2/{controller}.sbc",
        ignored=[],
    )  # fmt: skip
    scene.muscle_model = MuscleModel(legacy=True)
    with np.load(recording) as file:
        original = {name: file[name] for name in file.files}
    assert list(original["muscle_names"]) == list(scene.character.muscles)
    for name in ("root_quat", "joint_quat"):
        original[name] = xyzw(original[name])
    keys = ("root_pos", "root_quat", "root_vel", "root_angvel", "joint_quat", "joint_angvel")
    stages, torques, muscles = Stages(scene, 1, "cpu"), [], []
    for step in range(len(original["t"])):
        stages.set_state(*(original[key][[step]] for key in keys))
        torque, quantities = stages.muscle_torques(original["joint_torque_desired"][[step]])
        torques.append(torque[0])
        muscles.append([quantities[f"muscle_{name}"][0] for name in QUANTITIES])
    ours = dict(zip(QUANTITIES, np.moveaxis(np.array(muscles), 1, 0), strict=True))
    pairs = {name: (ours[name], original[f"muscle_{name}"]) for name in QUANTITIES}
    return pairs | {"joint_torque": (np.array(torques), original["joint_torque"])}


@pytest.mark.parametrize("quantity", [*QUANTITIES, "joint_torque"])
def test_muscles_do_what_the_original_ones_did(both: dict[str, tuple[np.ndarray, np.ndarray]], quantity: str):
    """Float against double: half of all samples within 1e-5 of the range, all but where a switch is crossed in 1 %."""
    ours, original = both[quantity]
    error = np.abs(ours - original) / np.ptp(original, axis=0).max()
    assert np.median(error) <= 1e-5
    assert np.mean(error <= 0.01) >= 0.99
