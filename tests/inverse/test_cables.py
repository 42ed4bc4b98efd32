"""Actuators and ligaments among the muscles of recorded motions: they have no fibres, and pull as OpenSim's do."""

import math

import numpy as np
import pytest
import warp as wp

import warpmuscle as wm
from warpmuscle.core.arrays import to_device
from warpmuscle.formats import toml
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.trial import Coordinates
from warpmuscle.kernels import structs
from warpmuscle.kernels.inverse import emg_driven
from warpmuscle.kernels.inverse.muscle_moments import tendon_lengths_of
from warpmuscle.model.build import with_fields
from warpmuscle.model.muscles import muscle_kind, muscles_struct

ANGLES, RATES = np.array([-0.6, -0.2, 0.3, 0.9]), np.array([1.0, -2.0, 0.5, 3.0])
HIGH, LOW = (0.0, 0.1, -0.05), (0.0, -0.1, -0.04)  # of every path, from the hinge
ARM = """
name = "arm"
[character]
root = "base"
root_joint = "fixed"
[character.bodies]
base = { mass = 5.0, inertia = [0.1, 0.1, 0.1] }
rod = { mass = 1.0, inertia = [0.05, 0.01, 0.05] }
[character.joints.hinge]
type = "hinge"
parent = "base"
child = "rod"
position_in_parent = [0, 0, 0]
position_in_child = [0, 0, 0]
axes = [[1, 0, 0]]
[muscle_model]
curves = "millard"
"""
PATH = f'path = [{{ body = "base", position = {list(HIGH)} }}, {{ body = "rod", position = {list(LOW)} }}]'
MUSCLE = f"""
[character.muscles.flexor]
{PATH}
f_max = 700
l_opt = 0.1
l_slack = 0.1
curve_shape = {{ type = "millard", active_from = 0.5 }}
"""
CABLES = {
    "strap": "f_max = 500\nl_slack = 0.15\n"
    'curve_shape = { type = "ligament", x = [1, 2], y = [0, 1], ends = "linear" }',
    "fold": "f_max = 4000\nl_slack = 0.18\n"
    'curve_shape = { type = "blankevoort", transition_strain = 0.06, damping = 0.1 }',
    "rope": 'f_max = 90\nl_slack = 0.1\ncurve_shape = { type = "path_actuator" }',
}


def arm(*muscles: str) -> BodyModel:
    own = [f"\n[character.muscles.{name}]\n{PATH}\nl_opt = 0.1\n{CABLES[name]}\n" for name in muscles if name in CABLES]
    return BodyModel(toml.loads(ARM + (MUSCLE if "flexor" in muscles else "") + "".join(own)), "cpu")


def frames(body: BodyModel):
    """Fibres and forces (frames, muscles), in N."""
    states = body.map.states(ANGLES[:, None], RATES[:, None], np.zeros((len(ANGLES), 1)))
    found = body.muscle_frames(states, slice(0, len(ANGLES)))
    return {name: getattr(found, name).numpy() for name in ("length", "speed", "fibre", "active", "passive")}


def length(angle: float) -> float:
    c, s = math.cos(angle), math.sin(angle)
    low = (0.0, c * LOW[1] - s * LOW[2], s * LOW[1] + c * LOW[2])
    return math.dist(HIGH, low)


def test_ligaments_have_their_tension_actuators_none_and_muscles_what_they_have_alone():
    found, alone = frames(arm("flexor", *CABLES)), frames(arm("flexor"))
    strap, fold, rope = (arm("flexor", *CABLES).muscles.index(name) for name in CABLES)
    paths = np.array([length(angle) for angle in ANGLES])
    step = 1e-6
    speeds = [(length(a + step * v) - length(a - step * v)) / (2 * step) for a, v in zip(ANGLES, RATES, strict=True)]
    assert found["length"][:, strap] == pytest.approx(paths, abs=1e-6)
    assert found["passive"][:, strap] == pytest.approx(500.0 * np.maximum(paths / 0.15 - 1.0, 0.0), abs=0.01)
    strain, rate = paths / 0.18 - 1.0, np.maximum(np.array(speeds) / 0.18, 0.0)
    toe = np.where(strain < 0.06, strain**2 / 0.12, strain - 0.03)
    wanted = np.where(strain > 0.0, 4000.0 * (toe + 0.1 * rate), 0.0)
    assert np.any(strain > 0.06)
    assert np.any(strain < 0.0)
    assert found["passive"][:, fold] == pytest.approx(wanted, rel=1e-4, abs=0.05)
    assert np.all(found["passive"][:, rope] == 0.0)
    assert np.all(found["active"][:, [strap, fold, rope]] == 0.0)
    flexor = arm("flexor", *CABLES).muscles.index("flexor")
    for name in ("active", "passive"):
        assert found[name][:, flexor] == pytest.approx(alone[name][:, 0], rel=1e-5, abs=1e-4)
    assert np.all(found["fibre"][0][:, [strap, fold, rope]] == 1.0)


def test_a_model_of_cables_alone_reads_no_curves_that_it_does_not_have():
    found = frames(arm("strap"))
    assert found["passive"][:, 0] == pytest.approx(
        [500.0 * max(length(angle) / 0.15 - 1.0, 0.0) for angle in ANGLES], abs=0.01
    )


def test_tendons_of_cables_do_not_stretch_and_emg_does_not_scale_them():
    body = arm("flexor", *CABLES)
    kind = muscle_kind(body.scene.muscle_model, [body.muscle(name) for name in body.muscles])
    muscles = muscles_struct(body.scene, body.muscles, body.device)
    force = to_device(np.full((1, len(body.muscles)), 100.0), float, body.device)
    tendon = wp.zeros(force.shape, dtype=float, device=body.device)
    wp.launch(
        tendon_lengths_of(kind.curves, kind.special_curves), force.shape, [muscles, force], [tendon], device=body.device
    )
    slack = np.array([body.muscle(name).l_slack for name in body.muscles], dtype=float)
    is_flexor = np.array([name == "flexor" for name in body.muscles])
    assert tendon.numpy()[0][~is_flexor] == pytest.approx(slack[~is_flexor])
    assert tendon.numpy()[0][is_flexor] > slack[is_flexor]
    known, one = emg_driven.Recordings(), emg_driven.Candidates()
    known.length = to_device(np.full((1, len(slack)), 0.2), float, body.device)
    known.speed = wp.zeros((1, len(slack)), dtype=float, device=body.device)
    for name in ("l_opt", "l_slack", "f_max"):
        setattr(one, name, to_device(np.full((1, len(slack)), 1.5), float, body.device))
    activation, pull = (wp.zeros((1, 1, len(slack)), dtype=float, device=body.device) for _ in range(2))
    model = with_fields(structs.Model(), {"muscles": muscles})
    kernel = emg_driven.emg_forces_of(kind.curves, kind.special_curves)
    wp.launch(kernel, pull.shape, [model, known, one, activation], [pull], device=body.device)
    tension = dict(zip(body.muscles, pull.numpy()[0, 0], strict=True))
    assert tension["strap"] == pytest.approx(500.0 * (0.2 / 0.15 - 1.0), rel=1e-5)
    assert tension["rope"] == 0.0


@pytest.mark.parametrize("passive", [False, True])
def test_ligaments_pull_in_static_optimisation_whether_muscles_passive_forces_count_or_not(passive):
    body, times = arm("flexor", "strap"), np.linspace(0.0, 1.0, 21)
    angles = 0.5 + 0.4 * np.sin(3.0 * times)
    motion = Coordinates(body.map.names, times, angles[:, None])
    found = wm.static_optimization(body, motion, passive=passive, reserve=50.0)
    paths = np.array([length(angle) for angle in angles])
    arms = np.array([(length(a - 1e-6) - length(a + 1e-6)) / 2e-6 for a in angles])
    strap = 500.0 * np.maximum(paths / 0.15 - 1.0, 0.0)
    assert strap.max() > 50.0
    assert found.force[:, found.muscles.index("strap")] == pytest.approx(strap, abs=0.05)
    pulled = found.force.sum(axis=1) * arms + found.reserve[:, 0]
    assert pulled == pytest.approx(found.moments.values[:, 0], abs=2e-3 * np.abs(found.moments.values).max())
