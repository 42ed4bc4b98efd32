"""Time constants of activation that change smoothly (`tausmooth`) do so as in MuJoCo's own muscles."""

import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
sys.path.append(str(Path(__file__).parent))

from probes import evaluate  # noqa: E402
from small_models import ARM  # noqa: E402

import warpmuscle as wm  # noqa: E402
from warpmuscle.core.errors import SceneError  # noqa: E402
from warpmuscle.formats import load, mjcf  # noqa: E402
from warpmuscle.kernels.muscle import activation  # noqa: E402
from warpmuscle.scene import Excitation  # noqa: E402

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

WIDTHS = {"front": 0.3, "hole": 1.5}
STEP = 1.0e-4  # s


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A file of the arm with two muscles whose time constants change smoothly, and others whose change at once."""
    text = ARM
    for name, width in WIDTHS.items():
        text = text.replace(f'<muscle name="{name}"', f'<muscle name="{name}" tausmooth="{width}"')
    path = tmp_path / "arm.xml"
    path.write_text(text)
    return path


def rates(path: Path, a: float, u: float) -> np.ndarray:
    """MuJoCo's rates of activation (M,), 1/s."""
    of = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(of)
    data.act[:], data.ctrl[:] = a, u
    mujoco.mj_forward(of, data)
    return np.array(data.act_dot)


@pytest.mark.parametrize("width", [0.05, 0.3, 1.5])
def test_rate_is_that_of_mujoco(width: float):
    a, u = np.random.default_rng(0).random((2, 300))
    got = evaluate(activation.smoothed_rate, a, u, 0.012, 0.05, width) * (u - a)
    parameters = np.array([0.012, 0.05, width])
    expected = [mujoco.mju_muscleDynamics(one, other, parameters) for one, other in zip(u, a, strict=True)]
    np.testing.assert_allclose(got, expected, rtol=2e-5, atol=1e-4)


@pytest.mark.parametrize(("a", "u"), [(0.3, 0.35), (0.3, 0.2), (0.6, 0.9), (0.8, 0.1)])
def test_a_step_of_each_muscle_goes_as_far_as_in_mujoco(model: Path, a: float, u: float):
    scene = load(model, ignored=[])
    scene.muscle_model.initial_activation, scene.time_step, scene.duration = a, STEP, STEP
    muscles = scene.character.muscles
    for muscle in muscles.values():
        if muscle.excitation is None and not wm.scene.muscles.is_cable(muscle):
            muscle.excitation = Excitation([0.0], [u])
    rollout = wm.Rollout(scene, 1, "cpu")
    rollout.advance(1)
    names = list(muscles)
    after = rollout.state.muscles.activation.numpy()[0].astype(float)
    expected = rates(model, a, u)
    for k, name in enumerate(name for name in names if name != "strap"):
        rate = -np.log((after[names.index(name)] - u) / (a - u)) / STEP
        assert rate * (u - a) == pytest.approx(expected[k], rel=3e-3), name


def test_it_is_read_kept_and_written(model: Path, tmp_path: Path):
    scene = load(model, ignored=[])
    found = {name: wm.scene.muscles.given(one, scene.muscle_model, "activation_smoothing") for name, one in
             scene.character.muscles.items()}  # fmt: skip
    assert {name: width for name, width in found.items() if width} == WIDTHS
    wm.save(scene, tmp_path / "kept.toml")
    again = load(tmp_path / "kept.toml", ignored=[])
    assert again.character.muscles["hole"].activation_smoothing == 1.5
    written = mjcf.dumps(load_hopper_with_smoothing(tmp_path))
    assert 'tausmooth="0.2"' in written


def load_hopper_with_smoothing(folder: Path) -> wm.Scene:
    from small_models import HOPPER

    path = folder / "hopper.xml"
    path.write_text(HOPPER.replace('<muscle name="long"', '<muscle name="long" tausmooth="0.2"'))
    return load(path, ignored=[])


def test_other_dynamics_are_not_smoothed(model: Path, tmp_path: Path):
    scene = load(model, ignored=[])
    scene.muscle_model.activation = "linear"
    with pytest.raises(SceneError, match="is smoothed; leave it out"):
        wm.Rollout(scene, 1, "cpu")
