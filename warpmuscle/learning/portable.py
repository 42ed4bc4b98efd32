"""Policies for other programs: as ONNX, or as TorchScript; raw observations in, actions out.

Both have one input, `observation` (n, O) float32, and one output, `action` (n, A) float32, normalisation and the mean
over clipped noise included; names of all numbers are in the file's metadata.
"""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.results.learned import ClippedNoise, PolicyTable, check_policy

SUFFIXES = (".onnx", ".pt")
OPSET = 17
IR_VERSION = 8  # that runtimes since 2022 read
INPUT, OUTPUT = "observation", "action"
SCALE = 1.0 / np.sqrt(2.0)  # the normal distribution is 0.5 (1 + erf(z SCALE))
PEAK = 1.0 / np.sqrt(2.0 * np.pi)  # of its density


def write_policy(policy: PolicyTable, path: str | Path) -> None:
    """Write a policy, whole or not at all; the file's suffix says as what.

    Raises:
        Error: another suffix, what is needed is not installed, or the file cannot be written.
        ValueError: the policy is not sound.
    """
    path = Path(path)
    check_policy(policy)
    writers = {".onnx": onnx_bytes, ".pt": torchscript_bytes}
    if path.suffix.lower() not in writers:
        raise Error(f"{path.name!r}: a policy is written as {' or '.join(SUFFIXES)}")
    replace_file(path, writers[path.suffix.lower()](policy))


def names_of(policy: PolicyTable) -> dict[str, str]:
    """What a file says of its numbers, as JSON lists, and of the scene that the policy was learnt in."""
    return {
        "observation_names": json.dumps(policy.observation),
        "action_names": json.dumps(policy.action),
        "scene": policy.scene,
    }


def onnx_bytes(policy: PolicyTable) -> bytes:
    """The policy as a checked ONNX model; raises Error without the extra `onnx`."""
    try:
        import onnx
        from onnx import TensorProto, helper
    except ModuleNotFoundError as error:
        raise Error('ONNX needs its package: pip install "warpmuscle[onnx]"') from error
    graph = _Graph(onnx)
    value = graph.node("Sub", INPUT, graph.constant("mean", policy.mean))
    value = graph.node("Div", value, graph.constant("deviation", policy.deviation))
    ends = graph.constant("lowest", np.float32(-policy.widest)), graph.constant("highest", np.float32(policy.widest))
    value = graph.node("Clip", value, *ends)
    for number, layer in enumerate(policy.layers):
        arrays = (graph.constant(f"{name}{number}", getattr(layer, name)) for name in ("weight", "bias"))
        value = graph.node("Gemm", value, *arrays, transB=1)
        if number < len(policy.layers) - 1:
            value = graph.node("Elu", value)
    if policy.noise is not None:
        value = graph.clipped_mean(value, policy.noise)
    graph.node("Identity", value, output=OUTPUT)
    ends_of = [
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", size])]
        for name, size in ((INPUT, len(policy.observation)), (OUTPUT, len(policy.action)))
    ]
    model = helper.make_model(
        helper.make_graph(graph.nodes, "policy", *ends_of, graph.constants),
        opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION, producer_name="warpmuscle",
    )  # fmt: skip
    helper.set_model_props(model, names_of(policy))
    onnx.checker.check_model(model, full_check=True)
    return bytes(model.SerializeToString())


class _Graph:
    """Nodes and constants of an ONNX graph, as they come."""

    def __init__(self, onnx: Any) -> None:
        self._onnx = onnx
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, name: str, values: Any) -> str:
        self.constants.append(self._onnx.numpy_helper.from_array(np.asarray(values, dtype=np.float32), name))
        return name

    def node(self, kind: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        output = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(kind, list(inputs), [output], **attributes))
        return output

    def clipped_mean(self, mean: str, noise: ClippedNoise) -> str:
        """See `policy.clipped_mean`."""
        width = self.constant("noise", noise.deviation)
        low, high = self.constant("action_min", noise.low), self.constant("action_max", noise.high)
        numbers = {"half": 0.5, "one": 1.0, "scale": SCALE, "peak": PEAK, "minus_half": -0.5}
        for name, value in numbers.items():
            self.constant(name, value)

        def mean_above(z: str) -> str:
            below = self.node("Mul", self.node("Add", self.node("Erf", self.node("Mul", z, "scale")), "one"), "half")
            density = self.node("Exp", self.node("Mul", self.node("Mul", z, z), "minus_half"))
            return self.node("Add", self.node("Mul", z, below), self.node("Mul", density, "peak"))

        over = mean_above(self.node("Div", self.node("Sub", mean, high), width))
        under = mean_above(self.node("Div", self.node("Sub", low, mean), width))
        return self.node("Add", mean, self.node("Mul", width, self.node("Sub", under, over)))


def torchscript_bytes(policy: PolicyTable) -> bytes:
    """The policy as a traced module of PyTorch; raises Error without the extra `learn`."""
    try:
        import torch
    except ModuleNotFoundError as error:
        raise Error('TorchScript needs PyTorch: pip install "warpmuscle[learn]"') from error

    class Module(torch.nn.Module):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.layers = torch.nn.ModuleList(torch.nn.Linear(*layer.weight.shape[::-1]) for layer in policy.layers)
            for module, layer in zip(self.layers, policy.layers, strict=True):
                module.weight.data = torch.as_tensor(layer.weight.copy())
                module.bias.data = torch.as_tensor(layer.bias.copy())
            self.register_buffer("mean", torch.as_tensor(policy.mean.copy()))
            self.register_buffer("deviation", torch.as_tensor(policy.deviation.copy()))
            noise = np.ones(1, np.float32) if policy.noise is None else policy.noise.deviation
            self.register_buffer("noise", torch.as_tensor(noise.copy()))

        def forward(self, observation: Any) -> Any:
            value = ((observation - self.mean) / self.deviation).clamp(-policy.widest, policy.widest)
            for number, layer in enumerate(self.layers):
                value = layer(value)
                if number < len(self.layers) - 1:
                    value = torch.nn.functional.elu(value)
            if policy.noise is None:
                return value
            under = self.mean_above((policy.noise.low - value) / self.noise)
            return value + self.noise * (under - self.mean_above((value - policy.noise.high) / self.noise))

        @staticmethod
        def mean_above(z: Any) -> Any:
            return z * 0.5 * (1.0 + torch.erf(z * float(SCALE))) + torch.exp(-0.5 * z * z) * float(PEAK)

    with tempfile.TemporaryDirectory() as folder, torch.no_grad(), warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # PyTorch would rather export its own format
        traced = torch.jit.trace(Module().eval(), torch.zeros(2, len(policy.observation)))
        path = os.path.join(folder, "policy.pt")
        torch.jit.save(traced, path, _extra_files=names_of(policy))
        return Path(path).read_bytes()
