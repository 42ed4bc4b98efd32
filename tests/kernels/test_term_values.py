"""What each term of the objective adds in a step, against its formula in float64."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import filled
from scipy.spatial.transform import Rotation

import metabolic_powers
from warpmuscle.kernels.curve.curve_sets import LEE
from warpmuscle.kernels.objective import term_functions as terms
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import LEFT, RIGHT, ROOT_FREE, Model, Muscles, Scratch, SimbiconState, Skeleton, State

N, MUSCLES = 60, 3
POWERS = {
    name: getattr(metabolic_powers, name) for name in ("bhargava", "wang", "umberger", "margaria")
}  # fmt: skip


def written(term: Any) -> Any:
    """A kernel that writes a term of muscles."""

    @wp.kernel(enable_backward=False, module="unique")
    def write(model: Model, does: wp.array2d[MuscleWork], value: wp.array2d[float]):
        i, m = wp.tid()
        value[i, m] = term(i, m, does[i, m], model)

    return write


@pytest.fixture(scope="module")
def muscles() -> SimpleNamespace:
    """Muscles with numbers of their own in every instance, what they do, and Lee's force of the active fibre."""
    random = np.random.default_rng(12)

    def drawn(low: float, high: float) -> np.ndarray:
        return random.uniform(low, high, (N, MUSCLES)).astype(np.float32).astype(float)

    row = {"f_max": drawn(200.0, 3000.0), "l_opt": drawn(0.04, 0.3), "v_max": drawn(6.0, 14.0)}
    row["slow_fibres"] = drawn(0.2, 0.8)
    mass, over, speed = drawn(0.05, 1.5), drawn(0.4, 1.6), drawn(-0.9, 0.9)
    does = {"activation": drawn(0.0, 1.0), "excitation": drawn(0.0, 1.0), "length": over * row["l_opt"]}
    does["speed"] = speed * row["l_opt"] * row["v_max"]
    given = filled(Muscles, model=LEE, row=row, mass=mass)
    model = filled(Model, muscles=given, negative_share=0.4)
    iso = np.exp(-((over - 1.0) ** 2) / 0.5)
    x = speed * (2.0 + 2.0 / 0.3)
    f_v = np.where(speed <= 0.0, (1.0 + speed) / (1.0 - speed / 0.3), (1.8 * x + 0.8) / (x + 0.8))
    force = does["activation"] * iso * f_v * row["f_max"]
    return SimpleNamespace(**row, **does, mass=mass, over=over, iso=iso, force=force, model=model, columns=does)


def value_of(name: str, muscles: SimpleNamespace) -> np.ndarray:
    does = filled(Works, work=muscles.columns)
    value = wp.zeros((N, MUSCLES), device="cpu")
    wp.launch(written(getattr(terms, name)), value.shape, [muscles.model, does.work, value], device="cpu")
    return value.numpy()


@wp.struct
class Works:
    """What muscles do."""

    work: wp.array2d[MuscleWork]


@pytest.mark.parametrize("name", POWERS)
def test_metabolic_power_is_that_of_the_muscle_and_its_instance(name: str, muscles: SimpleNamespace):
    m = muscles
    further = {"v_max": m.v_max, "l_opt": m.l_opt} if name == "umberger" else {}
    given = (m.activation, m.excitation, m.over, m.speed, m.force, m.iso, m.slow_fibres, m.mass)
    net, gross = (POWERS[name](*given, net=net, **further) for net in (True, False))
    expected = 0.4 * net + 0.6 * gross
    np.testing.assert_allclose(value_of(f"metabolic_{name}", m), expected, rtol=2e-4, atol=2e-2)
    if name == "bhargava":
        work = np.maximum(-m.force * m.speed, 0.0) + 0.4 * np.minimum(-m.force * m.speed, 0.0)
        strict = np.maximum(np.maximum(expected - work, m.mass) + work, 0.0)
        np.testing.assert_allclose(value_of("metabolic_bhargava_strict", m), strict, rtol=2e-4, atol=2e-2)
        assert (strict > expected + 0.01).any()


def test_efforts_and_passive_forces_are_their_formulas(muscles: SimpleNamespace):
    m = muscles
    np.testing.assert_allclose(value_of("effort_squared", m), m.activation**2, rtol=1e-5)
    np.testing.assert_allclose(value_of("effort_cubed", m), m.activation**3, rtol=1e-5)
    np.testing.assert_allclose(value_of("mass_effort_squared", m), m.mass * m.activation**2, rtol=1e-5)
    np.testing.assert_allclose(value_of("mass_effort_cubed", m), m.mass * m.activation**3, rtol=1e-5)
    passive = np.where(m.over > 1.0, np.expm1(4.0 * (m.over - 1.0) / 0.6) / np.expm1(4.0), 0.0)
    np.testing.assert_allclose(value_of("passive_force", m), m.f_max * passive, rtol=1e-3, atol=1e-2)
    beyond = np.maximum(np.maximum(0.5 - m.over, m.over - 1.5), 0.0)
    np.testing.assert_allclose(value_of("fibre_range", m), beyond**2, rtol=1e-3, atol=1e-6)
    assert (beyond > 0.0).any()
    assert (beyond == 0.0).any()


# Terms of bodies and of the whole.

BODIES, BINS = 3, 5  # the root, and a chain of two
MASS, GRAVITY, BAND, TARGET_SPEED, BOUND, DESIRED = 62.0, 9.7, 0.15, 1.3, 0.9, 0.4
TRACKED, SCALE, SIDE = (0.0, 1.0, 0.5), (0.0, 7.0, -4.0), (LEFT, LEFT, RIGHT)
BODY_TERMS = ("applied_torque", "smoothness", "tracking", "norms", "norm_moments")
MOMENT_SCALE = (0.0, 6.0, -8.0)
INSTANCE_TERMS = ("speed", "heading", "head", "ground_force", "step_width", "norm_force", "stride_speed")


@wp.kernel(enable_backward=False)
def of_bodies(model: Model, state: State, work: wp.array[Scratch], value: wp.array3d[float]):
    i, body = wp.tid()
    mine = work[i]
    value[i, body, 0] = terms.applied_torque(i, body, model, state, mine)
    value[i, body, 1] = terms.smoothness(i, body, model, state, mine)
    value[i, body, 2] = terms.tracking(i, body, model, state, mine)
    value[i, body, 3] = terms.norms(i, body, model, state, mine)
    value[i, body, 4] = terms.norm_moments(i, body, model, state, mine)


@wp.kernel(enable_backward=False)
def of_whole(model: Model, state: State, work: wp.array[Scratch], value: wp.array2d[float]):
    i = wp.tid()
    mine = work[i]
    value[i, 0] = terms.speed(i, model, state, mine)
    value[i, 1] = terms.heading(i, model, state, mine)
    value[i, 2] = terms.head(i, model, state, mine)
    value[i, 3] = terms.ground_force(i, model, state, mine)
    value[i, 4] = terms.step_width(i, model, state, mine)
    value[i, 5] = terms.norm_force(i, model, state, mine)
    value[i, 6] = terms.stride_speed(i, model, state, mine)


@pytest.fixture(scope="module")
def walk() -> SimpleNamespace:
    """Random numbers of instances that walk."""
    random = np.random.default_rng(21)
    d = SimpleNamespace(
        phase=random.random(N), stance=random.integers(0, 2, N), accelerations=random.normal(size=(N, 9)) * 20.0,
        foot_force=np.abs(random.normal(0.0, 1.0, (N, 2, 3))) * MASS * GRAVITY,
        orientation=Rotation.random(N * BODIES, random_state=1).as_quat().reshape(N, BODIES, 4),
        torque=random.normal(size=(N, BODIES, 3)) * 30.0, spin=random.normal(size=(N, BODIES, 3)),
        center=random.normal(size=(N, 2, 3)), norm=random.normal(size=(BINS, BODIES)), force=random.random(BINS),
        moment=random.normal(size=(BINS, BODIES)),
        reference=Rotation.random(2 * BINS * BODIES, random_state=2).as_quat().reshape(2 * BINS, BODIES, 4),
    )  # fmt: skip
    length = random.uniform(0.8, 1.2, (N, 2)) * random.integers(0, 2, (N, 2))
    d.cycle = {
        "since": random.uniform(0.0, 1.1, (N, 2)), "length": length, "grounded": np.ones((N, 2), int),
        "landings": random.integers(0, 4, (N, 2)), "width": random.normal(0.1, 0.1, (N, 2)),
        "before": random.normal(0.0, 0.3, (N, 2, 3)), "place": random.normal(0.8, 0.3, (N, 2, 3)),
    }  # fmt: skip
    return d


def model_of(d: SimpleNamespace, **more: Any) -> Model:
    plan = {"parent": (-1, 0, 1), "joint_type": (ROOT_FREE, 1, 3), "speed_start": (0, 6, 8), "speed_end": (6, 8, 9)}
    return filled(
        Model, body_count=BODIES, gravity=[[GRAVITY]], head=2, reference_bins=BINS, reference=d.reference,
        tracked=TRACKED, norm_bins=BINS, norm=d.norm, norm_scale=SCALE, norm_side=SIDE,
        norm_moment=d.moment, moment_scale=MOMENT_SCALE, norm_force=d.force,
        norm_force_band=BAND, skeleton=filled(Skeleton, plan=plan, total_mass=[[MASS]]),
        heading=[[DESIRED]], objective={"target_speed": [[TARGET_SPEED]], "ground_force_bound": [[BOUND]]}, **more,
    )  # fmt: skip


def given_to(d: SimpleNamespace) -> tuple[State, wp.array, list[Scratch]]:
    state = filled(
        State, simbicon=filled(SimbiconState, phase=d.phase, stance=d.stance),
        accelerations=d.accelerations, foot_force=d.foot_force, foot_cycle=d.cycle,
    )  # fmt: skip
    work = [
        filled(
            Scratch, orientation=d.orientation[i], torque=d.torque[i], angular_velocity=d.spin[i], center=d.center[i]
        )
        for i in range(N)
    ]
    return state, wp.array(work, dtype=Scratch, device="cpu"), work


def cycle_part(d: SimpleNamespace, side: int) -> np.ndarray:
    """Of the cycle of a foot: by its last cycle, or by the phase before it has one."""
    half = 0.5 * np.minimum(d.phase, 1.0)
    by_phase = np.where(d.stance == side, half, 0.5 + half)
    since, length = d.cycle["since"][:, side], d.cycle["length"][:, side]
    return np.where(length > 0.0, np.minimum(since / np.maximum(length, 0.1), 1.0), by_phase)


def stride_speeds(d: SimpleNamespace) -> np.ndarray:
    """Speeds (N, 2) of the feet over their last strides; of the centre of mass where a foot has not landed twice."""
    gone = d.cycle["place"][:, :, 2] - d.cycle["before"][:, :, 2]
    of_strides = gone / np.maximum(d.cycle["length"], d.cycle["since"])
    return np.where(d.cycle["landings"] > 1, of_strides, d.center[:, 1, 2][:, None])


def bins(part: np.ndarray, count: int) -> np.ndarray:
    return np.minimum((part * count).astype(int), count - 1)


@pytest.mark.parametrize("by_contact", [0, 1])
def test_terms_of_bodies_are_their_formulas(walk: SimpleNamespace, by_contact: int):
    d = walk
    state, work, _kept = given_to(d)
    value = wp.zeros((N, BODIES, len(BODY_TERMS)), device="cpu")
    inputs = [model_of(d, reference_by_contact=by_contact), state, work, value]
    wp.launch(of_bodies, (N, BODIES), inputs, device="cpu")
    got = value.numpy()
    np.testing.assert_allclose(got[:, :, 0], np.linalg.norm(d.torque, axis=2), rtol=1e-5)
    speeds = [slice(0, 6), slice(6, 8), slice(8, 9)]
    squared = [np.sum(d.accelerations[:, own] ** 2, axis=1) for own in speeds]
    np.testing.assert_allclose(got[:, :, 1], np.stack(squared, axis=1), rtol=1e-5)
    half = 0.5 * d.phase
    part = cycle_part(d, LEFT) if by_contact else np.where(d.stance == LEFT, half, 0.5 + half)
    row = bins(part, 2 * BINS)
    for body in (1, 2):
        parent, child = (Rotation.from_quat(d.orientation[:, k]) for k in (body - 1, body))
        relative = parent.inv() * child
        away = (Rotation.from_quat(d.reference[row, body]).inv() * relative).magnitude()
        np.testing.assert_allclose(got[:, body, 2], TRACKED[body] * away**2, rtol=1e-3, atol=1e-4)
        q = relative.as_quat()
        turn = (2.0 * np.arctan2(q[:, 0], q[:, 3]) + np.pi) % (2.0 * np.pi) - np.pi
        human = d.norm[bins(cycle_part(d, SIDE[body]), BINS), body]
        np.testing.assert_allclose(got[:, body, 3], (SCALE[body] * turn - human) ** 2, rtol=1e-3, atol=1e-3)
        sagittal = parent.inv().apply(d.torque[:, body])[:, 0] / MASS
        people = d.moment[bins(cycle_part(d, SIDE[body]), BINS), body]
        miss = (MOMENT_SCALE[body] * sagittal - people) ** 2
        np.testing.assert_allclose(got[:, body, 4], np.minimum(miss, 16.0), rtol=1e-3, atol=1e-3)
        assert 0.1 < (miss > 16.0).mean() < 0.9
    np.testing.assert_array_equal(got[:, 0, 3:], 0.0)


@pytest.mark.parametrize("period", [0.0, 0.9])
def test_before_its_second_landing_a_foot_is_where_the_time_says(walk: SimpleNamespace, period: float):
    d = walk
    state, work, _kept = given_to(d)
    nobody = filled(SimbiconState, phase=np.zeros(0), stance=np.zeros(0, int))  # no controller has a phase
    state.simbicon = nobody
    value = wp.zeros((N, BODIES, len(BODY_TERMS)), device="cpu")
    model = model_of(d, reference_by_contact=1, reference_period=period, reference_begin=0.3)
    wp.launch(of_bodies, (N, BODIES), [model, state, work, value], device="cpu")
    since, length, landings = (d.cycle[name][:, LEFT] for name in ("since", "length", "landings"))
    by_time = ((np.where(landings > 0, 0.0, 0.3) + since / max(period, 0.1)) % 1.0).astype(np.float32)
    known = length > 0.0
    row = bins(np.where(known, np.minimum(since / np.maximum(length, 0.1), 1.0), by_time), 2 * BINS)
    assert 0.2 < known.mean() < 0.8
    for body in (1, 2):
        parent, child = (Rotation.from_quat(d.orientation[:, k]) for k in (body - 1, body))
        away = (Rotation.from_quat(d.reference[row, body]).inv() * parent.inv() * child).magnitude()
        expected = TRACKED[body] * np.where(known | (period > 0.0), away, 0.0) ** 2
        np.testing.assert_allclose(value.numpy()[:, body, 2], expected, rtol=1e-3, atol=1e-4)


def test_terms_of_the_whole_are_their_formulas(walk: SimpleNamespace):
    d = walk
    state, work, _kept = given_to(d)
    value = wp.zeros((N, len(INSTANCE_TERMS)), device="cpu")
    wp.launch(of_whole, N, [model_of(d), state, work, value], device="cpu")
    q, weight = d.orientation[:, 0], MASS * GRAVITY
    away = 2.0 * np.arctan2(q[:, 1], q[:, 3]) - DESIRED
    away = (away + np.pi) % (2.0 * np.pi) - np.pi
    load = d.foot_force[:, :, 1] / weight
    human = np.stack([d.force[bins(cycle_part(d, side), BINS)] for side in (LEFT, RIGHT)], axis=1)
    expected = {
        "speed": (d.center[:, 1, 2] - TARGET_SPEED) ** 2, "heading": away**2, "head": np.sum(d.spin[:, 2] ** 2, axis=1),
        "ground_force": np.maximum(load - BOUND, 0.0).sum(axis=1),
        "step_width": (np.where(d.cycle["landings"] > 1, d.cycle["width"] - 0.08, 0.0) ** 2).sum(axis=1),
        "norm_force": np.sum((load - human) ** 2, axis=1) / BAND**2,
        "stride_speed": ((stride_speeds(d) - TARGET_SPEED) ** 2).sum(axis=1),
    }  # fmt: skip
    for k, name in enumerate(INSTANCE_TERMS):
        np.testing.assert_allclose(value.numpy()[:, k], expected[name], rtol=1e-3, atol=1e-4, err_msg=name)
        assert np.ptp(expected[name]) > 0.01


def test_without_norms_and_references_nothing_is_added(walk: SimpleNamespace):
    model = model_of(walk)
    model.norm_bins, model.reference_bins = 0, 0
    state, work, _kept = given_to(walk)
    bodies, whole = wp.zeros((N, BODIES, 5), device="cpu"), wp.zeros((N, len(INSTANCE_TERMS)), device="cpu")
    wp.launch(of_bodies, (N, BODIES), [model, state, work, bodies], device="cpu")
    wp.launch(of_whole, N, [model, state, work, whole], device="cpu")
    np.testing.assert_array_equal(bodies.numpy()[:, :, 2:], 0.0)
    np.testing.assert_array_equal(whole.numpy()[:, 5], 0.0)
