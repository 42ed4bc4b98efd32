"""Moments of a knee that turns about three axes: in NumPy as in mechanics and as in Simbody, and by OpenSim itself."""

import numpy as np
import pytest

import osim_models as small
import warpmuscle as wm
from opensim_table import table
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats.sto import storage_text
from warpmuscle.inverse.as_opensim.differences import choices
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.trial import Coordinates

CORNERS = 0.1 * np.array([[1.0, 0.2, 0.1], [-0.6, 1.0, 0.3], [0.1, -0.8, 0.9], [0.2, 0.4, -1.1], [-0.7, -0.3, 0.2]])
MASSES = np.array([0.5, 0.9, 0.4, 0.7, 0.6])  # kg, at these places of shank and foot, m
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, 1.0, 0.0]])
LEANING, TURNING = [0.2, 0.1, -0.3, 0.0], [0.3, -0.17, 0.37, 0.05]  # coefficients from the highest order on
KNEE, ANKLE = np.array([0.03, -0.4, 0.02]), np.array([0.02, -0.3, 0.01])
NAMES = ("swing", "bend", "point")
STEP = 1e-3  # rad


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis / np.linalg.norm(axis)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def text() -> str:
    """A thigh that swings, a shank whose knee turns about three axes, and a foot on it."""
    centre = MASSES @ CORNERS / MASSES.sum()
    apart = CORNERS - centre
    tensor = np.einsum("k,kij->ij", MASSES, np.einsum("ka,ka,ij->kij", apart, apart, np.eye(3))
                       - apart[:, :, None] * apart[:, None, :])  # fmt: skip
    inertia = " ".join(f"{tensor[i, j]:.17g}" for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    bodies = "".join(small.body(name, MASSES.sum(), " ".join(map(repr, centre.tolist())), inertia)
                     for name in ("thigh", "shank", "foot"))  # fmt: skip
    turns = {}
    for k, coefficients in enumerate(([1.0, 0.0], LEANING, TURNING)):
        words = " ".join(map(str, coefficients))
        function = f'<PolynomialFunction name="function"><coefficients>{words}</coefficients></PolynomialFunction>'
        turns[f"rotation{k + 1}"] = ("bend", " ".join(map(str, AXES[k])), function)
    joints = (
        small.joint("PinJoint", "hip", "ground", "thigh", small.coordinate("swing"))
        + small.joint("CustomJoint", "knee", "thigh", "shank", small.coordinate("bend"), small.axes(**turns),
                      place=" ".join(map(str, KNEE)))
        + small.joint("PinJoint", "ankle", "shank", "foot", small.coordinate("point"),
                      place=" ".join(map(str, ANKLE)))
    )  # fmt: skip
    path = small.point("a", "thigh", "0.05 -0.1 0.02") + small.point("b", "shank", "-0.03 0.1 0.01")
    return small.model(bodies, joints, small.muscle("flexor", path))


def places(q: np.ndarray) -> np.ndarray:
    """Masses of shank and foot (10, 3), and the knee last."""
    swing, bend, point = q
    first = turned(np.array([0.0, 0.0, 1.0]), swing)
    shank = first @ turned(AXES[0], bend) @ turned(AXES[1], np.polyval(LEANING, bend))
    shank = shank @ turned(AXES[2], np.polyval(TURNING, bend))
    foot = shank @ turned(np.array([0.0, 0.0, 1.0]), point)
    knee = first @ KNEE
    return np.concatenate([knee + CORNERS @ shank.T, knee + shank @ ANKLE + CORNERS @ foot.T, knee[None]])


def seeming(q: np.ndarray, rate: float) -> np.ndarray:
    """Generalised forces by which all masses speed up as Simbody has it: t2' t3' w3 x w2, about the knee."""
    swing, bend, _ = q
    first = turned(np.array([0.0, 0.0, 1.0]), swing) @ turned(AXES[0], bend)
    second = first @ AXES[1]
    third = first @ turned(AXES[1], np.polyval(LEANING, bend)) @ AXES[2]
    slopes = np.polyval(np.polyder(LEANING), bend) * np.polyval(np.polyder(TURNING), bend)
    turning = slopes * rate**2 * np.cross(third, second)
    at = places(q)
    taken = np.tile(MASSES, 2)[:, None] * np.cross(turning, at[:-1] - at[-1])
    moved = [(places(q + STEP * way) - places(q - STEP * way)) / (2.0 * STEP) for way in np.eye(3)]
    return np.array([np.sum(taken * one[:-1]) for one in moved])


def motion(frames: int = 60) -> Coordinates:
    times = np.arange(frames) / 100.0
    values = 0.4 + np.array([0.5, 0.8, 0.4]) * np.sin(np.array([5.0, 9.0, 7.0]) * times[:, None] + [0.0, 1.0, 2.0])
    return Coordinates(NAMES, times, values)


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    return small.written(tmp_path_factory.mktemp("knee"), text())


def test_moments_have_what_simbody_adds_unless_rates_are_exact(model):
    body, at = BodyModel(model, "cpu"), motion()
    theirs, exact = (wm.inverse_dynamics(body, at, exact_rates=one) for one in (False, True))
    rates = np.gradient(at.values[:, 1], at.times, edge_order=2)
    order = [theirs.names.index(name) for name in NAMES]
    expected = np.array([seeming(q, rate) for q, rate in zip(at.values, rates, strict=True)])
    inside = slice(5, -5)
    added = (theirs.values - exact.values)[inside][:, order]
    assert np.abs(added).max() > 0.05
    assert np.abs(added - expected[inside]).max() < 0.02 * np.abs(expected).max()  # rates are differences here
    with pytest.raises(ArgumentError, match="exact_rates must be True or False"):
        wm.inverse_dynamics(body, at, exact_rates="no")


def test_loads_are_those_of_simbodys_acceleration_to_rounding(model):
    body, at = BodyModel(model, "cpu"), motion(7)
    plain, seen = (prepare(body, at, None, None, None, exact) for exact in (True, False))
    assert plain.loads.body == []
    added = body.dynamics(seen.states, seen.loads).effort - body.dynamics(plain.states, plain.loads).effort
    rate = plain.states.speeds[:, body.map.speed[body.map.names.index("bend")]]
    expected = np.array([seeming(q, one) for q, one in zip(at.values, rate, strict=True)])
    order = [int(body.map.speed[body.map.names.index(name)]) for name in NAMES]
    assert np.abs(added[:, order] - expected).max() < 2e-5 * np.abs(expected).max() + 1e-5


def test_which_rates_were_taken_is_told_with_what_others_change(model):
    body, at = BodyModel(model, "cpu"), motion(20)
    theirs, exact = (wm.inverse_dynamics(body, at, exact_rates=one).values for one in (False, True))
    most = np.abs(theirs - exact)[np.unique(np.linspace(0, 19, 10).astype(int))].max()
    for one, words in ((False, "are OpenSim's; with exact ones"), (True, "are exact; with those of OpenSim")):
        (choice,) = choices(body, ("id",), [at], [None], [at.times], exact_rates=one)
        assert choice.name == "rates"
        assert words in choice.sentence
        assert f"differ by up to {most:.2g} N m" in choice.sentence
    assert choices(body, ("ik", "track"), [at], [None], [at.times]) == []


def test_bodies_of_other_programs_and_simple_knees_have_none(tmp_path):
    body = BodyModel(small.written(tmp_path, small.pendulum()), "cpu")
    at = Coordinates(("q",), np.arange(9) / 50.0, np.sin(np.arange(9.0))[:, None])
    assert prepare(body, at, None, None, None, exact_rates=False).loads.body == []


def test_moments_are_those_of_opensims_tool(model, tmp_path):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    opensim.Logger.setLevelString("off")
    at = motion()
    file = tmp_path / "motion.sto"
    file.write_text(storage_text("motion", ["time", *NAMES], np.column_stack([at.times, at.values])))
    tool, theirs = opensim.InverseDynamicsTool(), opensim.Model(str(model))
    theirs.initSystem()
    tool.setModel(theirs)
    tool.setCoordinatesFileName(str(file))
    tool.setLowpassCutoffFrequency(-1.0)
    excluded = opensim.ArrayStr()
    excluded.append("Muscles")
    tool.setExcludedForces(excluded)
    tool.setStartTime(float(at.times[0]))
    tool.setEndTime(float(at.times[-1]))
    tool.setResultsDir(str(tmp_path))
    tool.setOutputGenForceFileName("moments.sto")
    tool.run()
    _, names, rows = table(tmp_path / "moments.sto")
    wanted = rows[:, [[one.rpartition("_")[0] for one in names].index(name) for name in NAMES]]
    for exact, least, most in ((False, 0.0, 1e-5), (True, 1e-3, 1.0)):
        found = wm.inverse_dynamics(
            model, at, exact_rates=exact, times=rows[:, 0].clip(0.0, at.times[-1]), device="cpu"
        )
        off = np.abs(found.values[:, [found.names.index(name) for name in NAMES]] - wanted).max()
        assert least <= off / np.abs(wanted).max() < most
