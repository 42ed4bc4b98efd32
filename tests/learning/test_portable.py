"""Policies as ONNX and TorchScript say what they say here, noise and normalisation included."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from small_policy import small_policy
from warpmuscle.core.errors import Error
from warpmuscle.learning.policy import DevicePolicy, actions_of
from warpmuscle.learning.portable import write_policy
from warpmuscle.results.learned import ClippedNoise, PolicyTable

NOISE = ClippedNoise(np.array([0.5, 0.1, 2.0, 0.3], dtype=np.float32), -0.25, 2.25)
POLICIES = {
    "plain": small_policy(),
    "noisy": small_policy(noise=NOISE),
    "one layer": replace(small_policy(hidden=()), scene="reaching"),
}


def expected(policy: PolicyTable, observed: np.ndarray) -> np.ndarray:
    """By NumPy, and by Warp, which agree."""
    ours = actions_of(policy, observed)
    on_device = DevicePolicy(policy, len(observed), "cpu").act(wp.array(observed, dtype=float, device="cpu")).numpy()
    np.testing.assert_allclose(on_device, ours, rtol=1e-4, atol=1e-4)
    return ours


@pytest.mark.parametrize("name", POLICIES)
def test_onnx_says_the_same_for_any_number_of_observations(name: str, tmp_path: Path):
    onnx = pytest.importorskip("onnx", reason="the extra `onnx` is not installed")
    from onnx.reference import ReferenceEvaluator

    policy, path = POLICIES[name], tmp_path / "p.onnx"
    write_policy(policy, path)
    model = onnx.load(path)
    for count in (1, 50):  # some far beyond what is usual
        observed = np.random.default_rng(count).normal(0.0, 8.0, (count, 9)).astype(np.float32)
        (found,) = ReferenceEvaluator(model).run(None, {"observation": observed})
        assert found.dtype == np.float32
        np.testing.assert_allclose(found, expected(policy, observed), rtol=1e-4, atol=1e-4)
    said = {entry.key: entry.value for entry in model.metadata_props}
    assert json.loads(said["observation_names"]) == list(policy.observation)
    assert json.loads(said["action_names"]) == list(policy.action)
    assert said["scene"] == policy.scene


@pytest.mark.parametrize("name", POLICIES)
def test_a_runtime_of_onnx_runs_it(name: str, tmp_path: Path):
    pytest.importorskip("onnx", reason="the extra `onnx` is not installed")
    runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed")
    policy, path = POLICIES[name], tmp_path / "p.onnx"
    write_policy(policy, path)
    observed = np.random.default_rng(2).normal(0.0, 3.0, (20, 9)).astype(np.float32)
    session = runtime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    (found,) = session.run(["action"], {"observation": observed})
    np.testing.assert_allclose(found, expected(policy, observed), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("name", POLICIES)
def test_torchscript_says_the_same_for_any_number_of_observations(name: str, tmp_path: Path):
    torch = pytest.importorskip("torch", reason="the extra `learn` is not installed")
    policy, path = POLICIES[name], tmp_path / "p.pt"
    write_policy(policy, path)
    extra = {"observation_names": ""}
    module = torch.jit.load(path, _extra_files=extra)
    for count in (1, 50):
        observed = np.random.default_rng(count).normal(0.0, 8.0, (count, 9)).astype(np.float32)
        found = module(torch.from_numpy(observed)).detach().numpy()
        np.testing.assert_allclose(found, expected(policy, observed), rtol=1e-4, atol=1e-4)
    assert tuple(json.loads(extra["observation_names"])) == policy.observation


def test_what_is_missing_or_unknown_is_said_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(Error, match=r"'p.tflite': a policy is written as .onnx or .pt"):
        write_policy(small_policy(), tmp_path / "p.tflite")
    for module, suffix, extra in (("onnx", ".onnx", "onnx"), ("torch", ".pt", "learn")):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(Error, match=rf'pip install "warpmuscle\[{extra}\]"'):
            write_policy(small_policy(), tmp_path / f"p{suffix}")
    assert not list(tmp_path.iterdir())
