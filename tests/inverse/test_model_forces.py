"""Springs, bushings and limits of a model in inverse steps, against their own formulas and their power."""

import re

import numpy as np
import pytest

from osim_models import written
from small_leg import loads, motion, small_leg, text
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.as_opensim.differences import choices
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics
from warpmuscle.inverse.reactions.joint_reactions import joint_reactions
from warpmuscle.inverse.static_optimization import static_optimization

SPRING = (
    '<SpringGeneralizedForce name="spring"><coordinate>knee_angle</coordinate><stiffness>15</stiffness>'
    "<rest_length>-0.3</rest_length><viscosity>0.7</viscosity></SpringGeneralizedForce>"
)
LIMIT = (
    '<CoordinateLimitForce name="limit"><coordinate>ankle_angle</coordinate><upper_limit>5</upper_limit>'
    "<upper_stiffness>2</upper_stiffness><lower_limit>-90</lower_limit><transition>1</transition>"
    "<damping>0</damping></CoordinateLimitForce>"
)
BUSHING = (
    '<BushingForce name="bushing"><socket_frame1>/bodyset/femur_r</socket_frame1>'
    "<socket_frame2>/bodyset/calcn_r</socket_frame2><rotational_stiffness>0 0 0</rotational_stiffness>"
    "<translational_stiffness>400 400 400</translational_stiffness></BushingForce>"
)


def leg(folder, forces: str) -> BodyModel:
    """The small leg with forces beside its muscles."""
    found = text().replace("<ForceSet><objects>", f"<ForceSet><objects>{forces}")
    assert forces in found
    return BodyModel(written(folder, found), "cpu", model_forces=True)


@pytest.fixture
def plain(tmp_path) -> BodyModel:
    (tmp_path / "plain").mkdir()
    return BodyModel(small_leg(tmp_path / "plain"), "cpu", model_forces=True)


def test_moments_are_what_is_needed_beside_a_spring(tmp_path, plain):
    at = motion()
    found, bare = (inverse_dynamics(body, at, loads(at.times)) for body in (leg(tmp_path, SPRING), plain))
    angle = at.of("knee_angle")
    speed = np.gradient(angle, at.times, edge_order=2)
    made = -15.0 * (angle + 0.3) - 0.7 * speed
    assert bare.of("knee_angle") - found.of("knee_angle") == pytest.approx(made, abs=0.01)
    for name in set(at.names) - {"knee_angle"}:
        assert found.of(name) == pytest.approx(bare.of(name), abs=1e-4)


def test_a_limit_acts_beyond_its_angle_alone(tmp_path, plain):
    at = motion(200)
    found, bare = (inverse_dynamics(body, at) for body in (leg(tmp_path, LIMIT), plain))
    made, degrees = bare.of("ankle_angle") - found.of("ankle_angle"), np.degrees(at.of("ankle_angle"))
    assert (np.abs(made[degrees < 4.9]) < 1e-4).all()
    beyond = degrees > 6.1  # the transition is over
    assert beyond.sum() > 3
    assert made[beyond] == pytest.approx(-2.0 * (degrees[beyond] - 5.0), rel=0.02, abs=0.02)


def test_a_bushing_gives_back_what_it_took(tmp_path, plain):
    at = motion(200, 200.0)
    body = leg(tmp_path, BUSHING)
    found, bare = (inverse_dynamics(one, at) for one in (body, plain))
    rates = np.gradient(at.values, at.times, axis=0, edge_order=2)
    power = np.sum((bare.values - found.values) * rates[:, [at.names.index(name) for name in bare.names]], axis=1)
    states = body.map.states(*(at.values[:, [at.names.index(n) for n in body.map.names]],) * 3)
    _, own = body.forces_of_model(states)
    energy = np.sum(own.force[:, body.topology.bodies.index("calcn_r")] ** 2, axis=1) / 800.0
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(at.times))])
    assert np.abs(work).max() > 1.0
    assert work + energy - energy[0] == pytest.approx(0.0, abs=2e-3 * np.abs(work).max())
    assert own.force.sum(axis=1) == pytest.approx(0.0, abs=1e-3)
    assert (np.abs(bare.values - found.values)[:, :6] < 0.02).all()  # it lies within the body


def test_muscles_feel_the_spring(tmp_path, plain):
    at, given = motion(8), loads(motion(8).times)
    body = leg(tmp_path, SPRING)
    found, bare = (static_optimization(one, at, given, reserve=1.0) for one in (body, plain))
    assert np.abs(found.activation - bare.activation).max() > 0.01


def test_joints_carry_what_a_bushing_pulls(tmp_path, plain):
    at = motion(8)
    body = leg(tmp_path, BUSHING)
    own, other = (joint_reactions(one, at, frame="ground").columns() for one in (body, plain))
    column = next(name for name in own if name.startswith("knee_r") and name.endswith("_fy"))
    states = body.map.states(*(at.values[:, [at.names.index(n) for n in body.map.names]],) * 3)
    pulled = body.forces_of_model(states)[1].force[:, body.topology.bodies.index("calcn_r")]
    assert np.abs(pulled).max() > 5.0
    assert other[column] - own[column] == pytest.approx(pulled[:, 1], abs=0.1)


@pytest.mark.parametrize("act", [True, False])
def test_what_of_a_model_acts_is_told(tmp_path, plain, act):
    at = motion(4)
    body = BodyModel(leg(tmp_path, SPRING + LIMIT).file, "cpu", model_forces=act)
    ((name, sentence),) = choices(body, ("id",), [at], [None], [at.times])
    assert name == "model_forces"
    assert sentence.startswith("2 forces of the model beside its muscles")
    assert ("play no part" in sentence) != act
    assert choices(plain, ("id",), [at], [None], [at.times]) == []


def test_by_default_nothing_of_a_model_acts_but_its_muscles(tmp_path, plain):
    at = motion(8)
    body = BodyModel(leg(tmp_path, SPRING).file, "cpu")
    assert np.array_equal(inverse_dynamics(body, at).values, inverse_dynamics(plain, at).values)
    with pytest.raises(ArgumentError, match="model_forces"):
        BodyModel(body.file, "cpu", model_forces="yes")


def test_a_model_without_mass_is_refused(tmp_path):
    words = re.sub(r"<mass>[^<]*", "<mass>0", text())
    with pytest.raises(ArgumentError, match="have no mass"):
        inverse_dynamics(BodyModel(written(tmp_path, words), "cpu"), motion(8))
