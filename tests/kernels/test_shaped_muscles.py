"""Muscles with curves, tendons and bounds of their own are OpenSim's: equilibrium, speed, force with a rigid tendon."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp
from opensim_bench import MODELS, Bench, as_ours, bench_scene

from warpmuscle.formats.osim.muscles.old_curves import ACTIVE_CURVE, EXPONENTIAL, TENDON_CURVE
from warpmuscle.kernels.curve.curve_sets import DE_GROOTE, MILLARD, SPLINE, THELEN
from warpmuscle.kernels.curve.custom_curves import with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped, ShapedCurves
from warpmuscle.kernels.muscle import muscle
from warpmuscle.kernels.muscle.muscle import pennation_cosine, rigid_fibre_speed
from warpmuscle.kernels.structs import Muscles
from warpmuscle.model.muscles import muscles_struct
from warpmuscle.scene import DeGrooteCurves, MillardCurves, Muscle, Spline, SplineCurves, ThelenCurves

ALL = Shaped((THELEN, MILLARD, DE_GROOTE, SPLINE))
equilibrium, tendon_force, fibre_force, equilibrium_speed, bounded_fibre_length, rigid_fibre_length = (
    with_curves(function, ALL)
    for function in (
        muscle.fibre_equilibrium, muscle.compliant_force, muscle.fibre_force, muscle.equilibrium_speed,
        muscle.bounded_fibre_length, muscle.rigid_fibre_length,
    )
)  # fmt: skip


@wp.func
def curves_of(muscles: Muscles, m: int) -> ShapedCurves:
    curves = ShapedCurves()
    curves.row = muscles.shape[0, m]
    curves.table = muscles.curve_table
    return curves


@wp.kernel(module="unique", enable_backward=False)
def settle(muscles: Muscles, state: wp.array2d[wp.vec2], result: wp.array2d[wp.vec2]):
    """Of activation and path length: fibre length in equilibrium, m, and tendon force over f_max."""
    i, m = wp.tid()
    row = muscles.row[0, m]
    curves = curves_of(muscles, m)
    length = equilibrium(curves, state[i, m][0], state[i, m][1], row.l_opt, row.l_slack, row.width)
    length = wp.max(length, bounded_fibre_length(curves.row.shortest * row.l_opt, row.l_opt, row.width))
    result[i, m] = wp.vec2(length, tendon_force(curves, state[i, m][1], length, row.l_slack, row.width))


@wp.kernel(module="unique", enable_backward=False)
def move(muscles: Muscles, state: wp.array2d[wp.vec3], result: wp.array2d[wp.vec2]):
    """Of activation, path and fibre length: speed of the fibre over v_max, and its force along the tendon then."""
    i, m = wp.tid()
    row = muscles.row[0, m]
    curves = curves_of(muscles, m)
    s = state[i, m]
    v = equilibrium_speed(
        curves, s[0], s[1], s[2], 0.0, 0.0, row.l_opt, row.l_slack, row.width, row.damping
    )  # fmt: skip
    force = fibre_force(curves, s[0], s[2] / row.l_opt, v, row.damping) * pennation_cosine(s[2], row.width)
    result[i, m] = wp.vec2(v, force)


@wp.kernel(module="unique", enable_backward=False)
def pull(muscles: Muscles, state: wp.array2d[wp.vec3], result: wp.array2d[wp.vec2]):
    """Of activation, path length and its rate: force over f_max with a rigid tendon."""
    i, m = wp.tid()
    row = muscles.row[0, m]
    curves = curves_of(muscles, m)
    s = state[i, m]
    length = rigid_fibre_length(s[1], row.l_opt, row.l_slack, row.width)
    if length > bounded_fibre_length(curves.row.shortest * row.l_opt, row.l_opt, row.width):
        speed = rigid_fibre_speed(s[2], length, row.width) / (row.v_max * row.l_opt)
        force = fibre_force(curves, s[0], length / row.l_opt, speed, row.damping)
        result[i, m] = wp.vec2(force * pennation_cosine(length, row.width), 0.0)


def ours(kernel: Any, muscles: list[Muscle], state: np.ndarray) -> np.ndarray:
    """The kernel's results for states (n, muscles, k), in float64."""
    scene = bench_scene({str(k): one for k, one in enumerate(muscles)})
    made = muscles_struct(scene, tuple(scene.character.muscles), "cpu")
    given = wp.array(state.astype(np.float32), dtype=wp.vec2 if state.shape[2] == 2 else wp.vec3, device="cpu")
    result = wp.zeros(state.shape[:2], dtype=wp.vec2, device="cpu")
    wp.launch(kernel, dim=state.shape[:2], inputs=[made, given], outputs=[result], device="cpu")
    return result.numpy().astype(np.float64)


@pytest.fixture(scope="module", params=MODELS)
def bench(request: pytest.FixtureRequest, reference_data: Path) -> Bench:
    osim = pytest.importorskip("opensim")
    file = reference_data / MODELS[request.param]
    if not file.is_file():
        pytest.skip(f"no {file}")
    return Bench(file, osim)


def poses(bench: Bench, count: int, seed: int) -> np.ndarray:
    """Activations and path lengths, m, (count, muscles, 2): of fibres from half to 1.6 times their optimal length."""
    random = np.random.default_rng(seed)
    given = np.zeros((count, len(bench.muscles), 2))
    for m, one in enumerate(bench.muscles):
        fibre = random.uniform(0.5, 1.6, count) * one.get_optimal_fiber_length()
        width = one.get_optimal_fiber_length() * np.sin(one.get_pennation_angle_at_optimal())
        strain = random.uniform(0.0, 0.04, count)
        given[:, m, 1] = np.sqrt(np.maximum(fibre**2 - width**2, 0.0)) + one.get_tendon_slack_length() * (1.0 + strain)
        given[:, m, 0] = random.uniform(0.01, 1.0, count)
    return given


def scale(one: Any) -> tuple[float, float, float]:
    """Optimal fibre length, m, slack length, m, and width, m, of an OpenSim muscle."""
    l_opt = one.get_optimal_fiber_length()
    return l_opt, one.get_tendon_slack_length(), l_opt * np.sin(one.get_pennation_angle_at_optimal())


def fibre_states(muscles: list[Any], seed: int, longest: float) -> np.ndarray:
    """Activations, path and fibre lengths, m, (50, muscles, 3); strains of the tendon up to 0.045."""
    random = np.random.default_rng(seed)
    given = np.zeros((50, len(muscles), 3))
    for m, one in enumerate(muscles):
        l_opt, l_slack, width = scale(one)
        fibre = np.maximum(random.uniform(0.5, longest, 50) * l_opt, 1.05 * width)
        path = np.sqrt(fibre**2 - width**2) + l_slack * (1.0 + random.uniform(-0.005, 0.045, 50))
        given[:, m] = np.stack([random.uniform(0.01, 1.0, 50), path, fibre], axis=1)
    return given


def compliant(bench: Bench) -> list[Any]:
    return [one for one in bench.muscles if not one.get_ignore_tendon_compliance()]


def test_fibre_and_tendon_are_in_equilibrium_where_opensim_has_it(bench: Bench) -> None:
    """50 random activations and path lengths of each muscle: force and fibre length within 1e-4 f_max and l_opt."""
    muscles = compliant(bench)
    state = fibre_states(muscles, 1, 1.6)[..., :2]
    theirs = np.zeros(state.shape)
    for m, one in enumerate(muscles):
        for i, (activation, length) in enumerate(state[:, m]):
            bench.put(one, activation, length)
            theirs[i, m] = one.getFiberLength(bench.state), one.getTendonForce(bench.state)
        theirs[:, m, 1] /= one.get_max_isometric_force()
    result = ours(settle, [as_ours(one) for one in muscles], state)
    l_opt = np.array([scale(one)[0] for one in muscles])
    assert theirs[..., 1].max() > 0.9
    np.testing.assert_allclose(result[..., 0] / l_opt, theirs[..., 0] / l_opt, atol=1e-4)
    np.testing.assert_allclose(result[..., 1], theirs[..., 1], atol=1e-4)


def test_fibre_moves_as_fast_as_in_opensim(bench: Bench) -> None:
    """Speed over v_max at 50 random activations, path and fibre lengths of each muscle, up to v_max."""
    muscles = compliant(bench)
    state = fibre_states(muscles, 2, 1.5)
    theirs = np.zeros(state.shape[:2])
    for m, one in enumerate(muscles):
        for i, (activation, length, fibre) in enumerate(state[:, m]):
            bench.put(one, activation, length, fibre)
            theirs[i, m] = one.getFiberVelocity(bench.state) / scale(one)[0] / one.get_max_contraction_velocity()
    error = np.abs(ours(move, [as_ours(one) for one in muscles], state)[..., 0] - theirs)[np.abs(theirs) < 1.0]
    assert error.size > 0.3 * theirs.size
    assert error.max() < 0.01
    assert np.sqrt(np.mean(error**2)) < 1e-3


def test_rigid_tendon_gives_the_force_of_opensim(bench: Bench) -> None:
    """50 random activations, lengths and speeds of each muscle with a rigid tendon, within 1e-4 f_max."""
    rigid = [one for one in bench.muscles if one.get_ignore_tendon_compliance()]
    if not rigid:
        pytest.skip("all tendons of this model are compliant")
    random = np.random.default_rng(4)
    state = np.zeros((50, len(rigid), 3))
    theirs = np.zeros(state.shape[:2])
    for m, one in enumerate(rigid):
        l_opt, l_slack, _ = scale(one)
        for i in range(50):
            speed = random.uniform(-1.2, 1.2) * l_opt * one.get_max_contraction_velocity()
            state[i, m] = random.uniform(0.01, 1.0), l_slack + random.uniform(0.2, 1.6) * l_opt, speed
            bench.put(one, *state[i, m, :2], speed=speed)
            theirs[i, m] = one.getTendonForce(bench.state) / one.get_max_isometric_force()
    assert 0.05 < np.mean(theirs == 0.0) < 0.5
    np.testing.assert_allclose(ours(pull, [as_ours(one) for one in rigid], state)[..., 0], theirs, atol=1e-4)


# Numbers of OpenSim 4.6's own muscles (pip install opensim), typed in.

THELEN_OLD = ThelenCurves(active_width=0.5, passive_shape=4.0, velocity_shape=0.3, lengthening_force=1.8)
RAJAGOPAL = MillardCurves(active_from=0.25, active_bend=0.77, active_until=1.9, active_slope=0.75)
GROOTE = DeGrooteCurves(active_width=1.5)
AT_REST = {  # muscle, its numbers, and activation, path length m -> fibre length m, tendon force N
    "soleus_r of Rajagopal2016": (
        Muscle(f_max=6194.84262295, l_opt=0.044, l_slack=0.27675587, pennation=0.38142888, curve_shape=RAJAGOPAL),
        [(0.5, 0.3212, 0.0400746057, 2743.31576), (0.05, 0.3326, 0.0552167587, 727.578177)],
    ),
    "gastroc_r of gait10dof18musc": (
        Muscle(f_max=2500.0, l_opt=0.06, l_slack=0.39, pennation=0.29670597, curve_shape=MillardCurves()),
        [(0.5, 0.4524, 0.0540651087, 1132.33684), (0.05, 0.4685, 0.0759388970, 315.367023)],
    ),
    "soleus_r of gait2392_thelen2003muscle": (
        Muscle(
            f_max=3549.0, l_opt=0.05, l_slack=0.25, pennation=0.43633231, tendon_strain=0.033, curve_shape=THELEN_OLD
        ),
        [(0.5, 0.2987, 0.0480124352, 1588.37077), (0.05, 0.3114, 0.0617967522, 386.916877)],
    ),
    "TRIlong of arm26": (
        Muscle(
            f_max=798.52, l_opt=0.134, l_slack=0.143, pennation=0.20943951, tendon_strain=0.033, curve_shape=THELEN_OLD
        ),
        [(0.5, 0.2781, 0.134700075, 391.121968), (0.05, 0.3148, 0.171927881, 115.882337)],
    ),
    "glut_med2_r of gait2392_thelen2003muscle, whose path is hardly longer than its tendon": (
        Muscle(f_max=573.0, l_opt=0.0845, l_slack=0.053, tendon_strain=0.033, curve_shape=THELEN_OLD),
        [(0.5, 0.0565413215, 0.00293730964, 44.4500531), (0.1, 0.0565326589, 0.00330261194, 9.03930672)],
    ),
    "glut_min3_r of gait2392_thelen2003muscle, likewise": (
        Muscle(
            f_max=323.0, l_opt=0.038, l_slack=0.051, pennation=0.01745329, tendon_strain=0.033, curve_shape=THELEN_OLD
        ),
        [(0.9, 0.0513211875, 0.000668897036, 5.49828191), (0.1, 0.051495537, 0.000762487806, 2.33542544)],
    ),
    "DeGrooteFregly2016Muscle": (
        Muscle(
            f_max=1200.0, l_opt=0.11, l_slack=0.22, pennation=0.3, tendon_strain=0.06, passive_strain=0.7,
            curve_shape=GROOTE,
        ),
        [(0.5, 0.33, 0.106020665, 583.817324), (0.1, 0.37, 0.148452633, 242.858516), (0.9, 0.35, 0.121976325, 1057.99)],
    ),
}  # fmt: skip
RIGID = {  # and activation, path length m, its rate m/s -> tendon force N
    "psoas_r of Rajagopal2016": (
        Muscle(f_max=1426.79016393, l_opt=0.1169, l_slack=0.09954317, pennation=0.21552513, curve_shape=RAJAGOPAL),
        [(0.5, 0.2033, -0.3507, 188.308275), (0.8, 0.249, 0.2338, 1232.61634)],
    ),
    "DeGrooteFregly2016Muscle": (
        Muscle(
            f_max=1200.0, l_opt=0.11, l_slack=0.22, pennation=0.3, damping=0.01, passive_strain=0.7, curve_shape=GROOTE
        ),
        [(0.5, 0.33, -0.3, 285.727946), (0.1, 0.37, 0.2, 309.690477), (0.9, 0.35, 0.5, 1529.91955)],
    ),
}


@pytest.mark.parametrize("name", AT_REST)
def test_typed_equilibria_of_opensim(name: str) -> None:
    own, states = AT_REST[name]
    table = np.array(states)
    result = ours(settle, [own], table[:, None, :2])[:, 0]
    np.testing.assert_allclose(result[:, 0] / own.l_opt, table[:, 2] / own.l_opt, atol=1e-4)
    np.testing.assert_allclose(result[:, 1], table[:, 3] / own.f_max, atol=1e-4)


JUMPED = [  # path and fibre length, m, and activation: where a path has jumped
    (0.31, 0.1, 0.5), (0.33, 0.1, 0.5), (0.4, 0.15, 0.2), (0.45, 0.12, 1.0), (0.28, 0.14, 0.3),
]  # fmt: skip


@pytest.mark.parametrize(
    ("own", "speed"),  # over v_max, OpenSim 4.6: getFiberVelocity of muscles of 500 N, 0.1 m and 0.2 m
    [
        (Muscle(f_max=500.0, l_opt=0.1, l_slack=0.2, damping=0.1, curve_shape=MillardCurves()),
            [3.2806122, 31.341837, 60.671081, 166.619505, -2.6288978]),
        (Muscle(f_max=500.0, l_opt=0.1, l_slack=0.2, damping=0.0, curve_shape=ThelenCurves()),
            [3.2320120, 20.700091, 107.113608, 92.479053, -2.5465436]),
    ],
)  # fmt: skip
def test_a_fibre_gives_way_to_a_jump_of_its_path_as_in_opensim(own: Muscle, speed: list[float]) -> None:
    own.tendon = "compliant"
    states = np.array(JUMPED)[:, None, [2, 0, 1]]
    np.testing.assert_allclose(ours(move, [own], states)[:, 0, 0], speed, rtol=2e-3)


@pytest.mark.parametrize("name", RIGID)
def test_typed_forces_of_opensim_with_rigid_tendons(name: str) -> None:
    own, states = RIGID[name]
    table = np.array(states)
    np.testing.assert_allclose(ours(pull, [own], table[:, None, :3])[:, 0, 0], table[:, 3] / own.f_max, atol=1e-4)


bounded, active_and_passive = with_curves(muscle.bounded_passive, ALL), with_curves(muscle.fibre_force, ALL)


@wp.kernel(enable_backward=False)
def stretched(curves: ShapedCurves, length: wp.array[float], speed: wp.array[float], force: wp.array2d[float]):
    i = wp.tid()
    force[i, 0] = bounded(curves, length[i])
    force[i, 1] = active_and_passive(curves, 1.0, 1.0, speed[i], 0.0)


def test_passive_forces_end_at_a_thousand_and_speeds_likewise() -> None:
    """Thelen's exponential of 5 (l - 1)/0.6 passes 1000 at l = 1 + 0.12 ln(1 + 1000 (e^5 - 1)) = 2.43."""
    curves = ShapedCurves()
    curves.row.curves, curves.row.passive_rate, curves.row.passive_floor = THELEN, 5.0 / 0.6, 1.0
    curves.row.passive_scale, curves.row.active_width = 1.0 / np.expm1(5.0), 0.45
    curves.row.velocity_shape, curves.row.lengthening_force, curves.row.straight_speed = 0.25, 1.4, 0.1
    curves.table = wp.zeros(1, dtype=wp.vec2, device="cpu")
    length, speed = np.array([2.0, 2.35, 2.5, 9.0]), np.array([0.5, 900.0, 1000.0, 1400.0])
    force = wp.zeros((4, 2), device="cpu")
    given = [wp.array(values.astype(np.float32), device="cpu") for values in (length, speed)]
    wp.launch(stretched, 4, [curves, *given, force], device="cpu")
    expected = np.minimum(np.expm1(5.0 * (length - 1.0) / 0.6) / np.expm1(5.0), 1000.0)
    np.testing.assert_allclose(force.numpy()[:, 0], expected, rtol=1e-4)
    assert (expected[2:] == 1000.0).all()
    at_speed = force.numpy()[:, 1]
    assert at_speed[0] < at_speed[1] < at_speed[2] == at_speed[3]


SCHUTTE = SplineCurves(*(Spline([*one.x], [*one.y], one.ends) for one in (ACTIVE_CURVE, EXPONENTIAL, TENDON_CURVE)))
OTHERS = SplineCurves(
    Spline([0.0, 0.4, 0.401, 0.7, 1.0, 1.3, 1.6, 1.601, 2.0], [0.0, 0.0, 0.0, 0.8, 1.0, 0.7, 0.0, 0.0, 0.0]),
    Spline([-5.0, 0.999, 1.0, 1.2, 1.5, 1.6, 5.0], [0.0, 0.0, 0.0, 0.1, 0.9, 1.5, 1.5]),
    Spline([-10.0, 0.0, 0.02, 0.04, 0.06, 20.0], [0.0, 0.0, 0.3, 1.1, 2.0, 900.0]),
)
LEVELS = [(0.26, 0.5), (0.28, 1.0), (0.295, 0.05), (0.31, 0.3), (0.33, 0.8), (0.35, 0.02)]  # path, m, and activation


@pytest.mark.parametrize(
    ("curves", "force"),  # N, OpenSim 4.6: Schutte1993Muscle_Deprecated of 500 N, 0.1 m and 0.2 m, computeEquilibrium
    [
        (SCHUTTE, [102.344551, 443.074180, 30.205303, 163.243619, 343.277647, 342.349575]),
        (OTHERS, [301.530061, 515.006407, 30.732184, 151.439371, 401.967491, 320.950847]),
    ],
)
def test_muscles_with_curves_through_knots_pull_as_opensims(curves: SplineCurves, force: list[float]) -> None:
    one = Muscle(f_max=500.0, l_opt=0.1, l_slack=0.2, v_max=10.0, damping=0.1, curve_shape=curves, tendon="compliant")
    state = np.array([[[activation, length]] for length, activation in LEVELS])
    np.testing.assert_allclose(500.0 * ours(settle, [one], state)[:, 0, 1], force, atol=0.1)
