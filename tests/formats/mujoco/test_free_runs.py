"""Free runs of an imported arm beside MuJoCo's own steps."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

import mujoco_free_runs as runs
from free_runs import drawn
from mujoco_poses import Oracle

import warpmuscle as wm

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

SECONDS = 0.2
ARM = """<mujoco model="arm">
  <option timestep="0.002"/>
  <worldbody>
    <site name="front" pos="0.03 0 0.45"/> <site name="behind" pos="-0.03 0 0.45"/>
    <body name="upper" pos="0 0 0.4">
      <inertial pos="0 0 -0.14" mass="1.8" diaginertia="0.012 0.012 0.002"/>
      <joint name="shoulder" axis="0 1 0" armature="0.01" damping="0.1"/>
      <geom name="roll" type="cylinder" size="0.02 0.05" euler="90 0 0" pos="0 0 -0.29" mass="0"/>
      <site name="arm" pos="0.02 0 -0.1"/> <site name="back" pos="-0.02 0 -0.1"/>
      <body name="fore" pos="0 0 -0.29">
        <inertial pos="0 0.01 -0.12" mass="1.1" diaginertia="0.007 0.007 0.001"/>
        <joint name="elbow" axis="0.1 -1 0" damping="0.05" ref="0"/>
        <site name="wrist" pos="0.01 0 -0.06"/> <site name="tip" pos="-0.015 0 0.02"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor"><site site="front"/><site site="arm"/><site site="wrist"/></spatial>
    <spatial name="extensor"><site site="behind"/><site site="back"/><geom geom="roll"/><site site="tip"/></spatial>
  </tendon>
  <actuator>
    <muscle name="flexor" tendon="flexor" force="300" range="0.7 1.3" lengthrange="0.3 0.5"/>
    <muscle name="extensor" tendon="extensor" force="400" range="0.7 1.3" lengthrange="0.3 0.5"/>
  </actuator>
</mujoco>"""


def test_an_arm_moves_as_by_mujocos_steps(tmp_path: Path):
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    scene, oracle = wm.load(file), Oracle(file)
    times, values = drawn(["flexor", "extensor"], SECONDS, seed=1)
    ready = runs.prepared(scene, times, values, SECONDS, 1e-4)
    moments, found = runs.ours(ready, SECONDS, ["shoulder", "elbow"])
    right = runs.theirs(oracle, found[0], times, values, 5e-5, moments)
    assert np.ptp(right, axis=0).max() > 0.3
    np.testing.assert_allclose(found, right, atol=1e-3)
