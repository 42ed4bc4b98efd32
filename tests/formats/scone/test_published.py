"""SCONE's own scenarios and parameters, where they are at hand: they walk here as they do there."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.formats.scone.parameters import read_parameters
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.simulation.rollout import Rollout

BENCHMARK = "benchmark_H0914_config.scone", "benchmark_H0914_230119.H0914.GH2010.D30.par"


@pytest.fixture
def folder(reference_data: Path) -> Path:
    """Where the files are."""
    found = reference_data / "scone"
    if not found.is_dir():
        pytest.skip(f"SCONE's files are not in {found}")
    return found


def run(scene: Scene, seconds: float) -> tuple[Status, Recording]:
    scene.duration = seconds
    rollout = Rollout(scene, record=[0], device="cpu")
    rollout.run()
    return Status(int(rollout.status()[0])), rollout.recording(0)


def test_a_benchmark_walks_for_30_s_by_its_parameters_unchanged(folder: Path):
    scene = load(*(folder / name for name in BENCHMARK), ignored=[])
    status, motion = run(scene, 30.0)
    assert status == Status.COMPLETED
    assert (motion.com[-1, 2] - motion.com[0, 2]) / 30.0 == pytest.approx(0.98, abs=0.03)  # m/s; 1 m/s is asked for
    knee = np.degrees(motion.coordinate[1000:, list(motion.coordinate_names).index("knee_angle_r")])
    assert -85.0 < knee.min() < -55.0
    assert -10.0 < knee.max() < 5.0


@pytest.mark.parametrize("parameters", [["ResultH0914Gait10.par"], []])
def test_h0914_walks_for_10_s_by_its_parameters_and_by_its_own_starts(folder: Path, parameters: list[str]):
    scene = load(*(folder / name for name in ["Gait_-_H0914_-_Hyfydy.scone", *parameters]), ignored=[])
    status, motion = run(scene, 10.0)
    assert status == Status.COMPLETED
    assert motion.com[-1, 2] > 7.0


def test_every_parameter_of_a_benchmark_has_its_place(folder: Path):
    notes = []
    scene = load(*(folder / name for name in BENCHMARK), ignored=notes)
    assert not [note for note in notes if note.file.suffix == ".par"]
    values = read_parameters(folder / BENCHMARK[1])
    assert len(free_parameters(scene)) == len(values) - sum(name.endswith(".offset") for name in values)


def test_the_model_with_18_muscles_and_its_twin_of_opensim_are_the_same_body(folder: Path):
    ours, twin = (load(folder / name, ignored=[]) for name in ("H0918.hfd", "H0918M_osim4.osim"))
    for name, muscle in ours.character.muscles.items():
        other = twin.character.muscles[name]
        assert (muscle.f_max, muscle.l_opt, muscle.l_slack) == pytest.approx((other.f_max, other.l_opt, other.l_slack))
        places = ([point.position for point in one.path] for one in (muscle, other))
        np.testing.assert_allclose(*places, atol=2e-5)
    for name, body in ours.character.bodies.items():
        assert body.mass == pytest.approx(twin.character.bodies[name].mass, rel=1e-4)
    sphere, other_sphere = (one.character.bodies["calcn_r"].shapes[0] for one in (ours, twin))
    assert sphere.material.stiffness == pytest.approx(other_sphere.material.stiffness, rel=1e-5)
