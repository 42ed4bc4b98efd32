"""MuJoCo Warp on the exported character, as a peer to compare with."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.formats import mjcf
from warpmuscle.scene import Scene

EXCITATION = 0.05  # of the muscles
MARGIN = 2  # room for contacts and constraints over what MuJoCo (C) needs in the same time


def prepared(scene: Scene) -> tuple[Any, Any]:
    """MuJoCo's model and data at the scene's start."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = EXCITATION
    mujoco.mj_forward(model, data)
    return model, data


def room(scene: Scene) -> tuple[int, int]:
    """Contacts and rows of constraints for which an instance needs memory over the scene's duration."""
    import mujoco

    model, data = prepared(scene)
    contacts, rows = data.ncon, data.nefc
    for _ in range(round(scene.duration / scene.time_step)):
        mujoco.mj_step(model, data)
        contacts, rows = max(contacts, data.ncon), max(rows, data.nefc)
    return MARGIN * contacts, MARGIN * rows


def peer_rate(scene: Scene, instances: int, device: str, steps: int) -> float:
    """Steps per second from the scene's start, by a CUDA graph of one step.

    Raises:
        ImportError: MuJoCo Warp is not installed. RuntimeError: its motion has diverged.
    """
    model, data = prepared(scene)
    return rate(model, data, instances, device, steps, *room(scene))


def rate(model: Any, data: Any, instances: int, device: str, steps: int, contacts: int, rows: int) -> float:
    """Steps per second of MuJoCo's model from its data, by a CUDA graph of one step.

    Args:
        contacts, rows: contacts and rows of constraints for which an instance gets memory.

    Raises:
        ImportError: MuJoCo Warp is not installed. RuntimeError: its motion has diverged.
    """
    import mujoco_warp

    with wp.ScopedDevice(device) as found:
        m = mujoco_warp.put_model(model)
        d = mujoco_warp.put_data(model, data, nworld=instances, nconmax=contacts, njmax=rows)
        mujoco_warp.step(m, d)  # loads the kernels, which a capture could not
        graph = None
        if found.is_cuda:
            with wp.ScopedCapture() as capture:
                mujoco_warp.step(m, d)
            graph = capture.graph
        wp.synchronize()
        begin = time.perf_counter()
        for _ in range(steps):
            if graph is not None:
                wp.capture_launch(graph)
            else:
                mujoco_warp.step(m, d)
        wp.synchronize()
        seconds = time.perf_counter() - begin
        if not np.isfinite(d.qpos.numpy()).all():
            raise RuntimeError("MuJoCo Warp's motion has diverged")
    return instances * steps / seconds
