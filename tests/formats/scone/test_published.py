"""SCONE's own scenarios and parameters, where they are at hand: they walk here as they do there."""

from collections.abc import Callable
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


@pytest.fixture
def tutorial(folder: Path, tmp_path: Path) -> Callable[[str], Scene]:
    """A tutorial on impaired walking, with the model H0914 in place of OpenSim's, which is not beside it."""
    (tmp_path / "data").mkdir()
    for name in ("ControllerGH2010.scone", "InitStateGait10.sto", "H0914.hfd"):
        (tmp_path / "data" / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "data" / "MeasureGait05.scone").write_bytes((folder / "MeasureGait10.scone").read_bytes())

    def read(start: str) -> Scene:
        text = next(folder.glob(f"Tutorial_{start}*.scone")).read_text()
        text = text.replace("ModelOpenSim3", "ModelHyfydy").replace("Human0914.osim", "H0914.hfd")
        (tmp_path / "tutorial.scone").write_text(text)
        return load(tmp_path / "tutorial.scone", ignored=[])

    return read


def test_tutorials_on_impaired_walking_change_muscles_and_reflexes(folder: Path, tutorial: Callable[[str], Scene]):
    healthy = load(folder / "H0914.hfd", ignored=[]).character.muscles
    weak, short, spastic = (tutorial(name) for name in ("5a", "5b", "5c"))
    for name, muscle in healthy.items():
        calf, ham = name[:-2] in ("soleus", "gastroc"), name.startswith("hamstrings")
        assert weak.character.muscles[name].f_max == pytest.approx(muscle.f_max * (0.2 if calf else 1.0))
        assert short.character.muscles[name].l_opt == pytest.approx(muscle.l_opt * (0.75 if ham else 1.0))
    assert spastic.gait_states is not None
    added = spastic.gait_states.reflexes["HyperReflexia_gastroc"]
    assert (added.muscle, added.constant, added.force_gain, added.delay) == ("gastroc", 0.1, 1.0, 0.02)
    assert len(added.during) == 5


@pytest.mark.parametrize("name", ["5a", "5c"])
def test_legs_with_numbers_of_their_own_that_are_equal_walk_as_legs_that_share_them(
    name: str, tutorial: Callable[[str], Scene], folder: Path, tmp_path: Path
):
    alike = tutorial(name)
    file = tmp_path / "data" / "ControllerGH2010.scone"
    file.write_text(file.read_text().replace("symmetric = 1", "symmetric = 0"))
    own = tutorial(name)
    assert len(free_parameters(own)) == 2 * len(free_parameters(alike))
    valued = load(*(folder / name for name in BENCHMARK), ignored=[]).objective  # as in the step of that walk above
    own.objective, alike.objective = valued, valued
    (status, motion), (other, expected) = run(own, 1.0), run(alike, 1.0)
    assert status == other
    np.testing.assert_array_equal(motion.com, expected.com)
    np.testing.assert_array_equal(motion.muscle_excitation, expected.muscle_excitation)


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
