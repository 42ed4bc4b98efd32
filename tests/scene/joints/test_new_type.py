"""A new type of joint in one entry and one kernel function: a screw, whose child turns and moves along one axis."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.core.pose import about
from warpmuscle.formats import sto
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.body.joint_motion import JointMotion
from warpmuscle.kernels.structs import ModelRef, at
from warpmuscle.scene import Actuation, Body, Character, Failure, Ground, InitialState, Joint, JointState, Scene
from warpmuscle.scene.joints import TYPES, JointKinematics, joint_type, register
from warpmuscle.scene.joints.coordinate import Coordinate
from warpmuscle.scene.topology import coordinate_names, topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

LEAD = 0.05  # m/rad
ORIGIN = (0.0, 0.0, 0.0)


@wp.func
def screw_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """Turn by q about the axis, and advance along it."""
    axis = at(model.skeleton.row, instance, body).axis_a
    m = JointMotion()
    m.orientation = hinge_rotation(axis, q)
    m.place = axis * (wp.static(LEAD) * q)
    m.turning = axis
    m.moving = axis * wp.static(LEAD)
    return m


class Screw(Coordinate):
    """The same on the host."""

    def motion(self, joint, q, v) -> JointKinematics:
        a, zero = self.frame(joint)[0], np.zeros((len(q), 3))
        along = np.broadcast_to(a, zero.shape)
        return JointKinematics(about(a, q[:, 0]), a * LEAD * q, [along], [along * LEAD], zero, zero)

    def shown(self, joint, orientation, place, breaks=()):
        return np.sum(place * self.frame(joint)[0], axis=1, keepdims=True) / LEAD


@pytest.fixture(autouse=True)
def _screw(monkeypatch):
    monkeypatch.setattr("warpmuscle.scene.joints.TYPES", TYPES)
    entry = Screw(
        name="screw", kernel=f"{__name__}:screw_motion", coordinates=("",), speeds=("",), axes=1, limits=1,
        angles=("",), angle_names=("turn",),
    )  # fmt: skip
    register(entry)
    yield
    del TYPES["screw"]


def nut(**more) -> Scene:
    """A nut on a vertical screw, and a rod on a hinge that it carries."""
    bodies = {name: Body(mass, (0.02, 0.03, 0.01)) for name, mass in (("base", 1.0), ("nut", 2.0), ("rod", 0.5))}
    joints = {
        "thread": Joint("screw", "base", "nut", ORIGIN, ORIGIN, [(0.0, 1.0, 0.0)]),
        "swing": Joint("hinge", "nut", "rod", ORIGIN, (0.0, 0.2, 0.0), [(1.0, 0.0, 0.0)]),
    }
    start = InitialState(joints={"thread": JointState(coordinate=1.0, speed=more.pop("speed", 0.0))})
    return Scene(
        "nut", Character("base", bodies, joints, "fixed"), initial_state=start, ground=Ground(stiffness=0.0),
        failure=Failure(com_height=0.0, heading=0.0), duration=0.5,
        actuation={"thread": Actuation("torque"), "swing": Actuation("torque")},
    )  # fmt: skip


def test_a_nut_runs_down_its_screw():
    scene = nut()
    scene.character.joints["swing"].type, scene.character.joints["swing"].axes = "fixed", []
    del scene.actuation["swing"]
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    mass, inertia = 2.5, 0.06  # of nut and rod, about the axis
    rate = -mass * 9.8 * LEAD / (inertia + mass * LEAD**2)
    np.testing.assert_allclose(rollout.state.coordinates.numpy()[0, 7], 1.0 + 0.5 * rate * 0.5**2, rtol=2e-4)


def test_what_it_carries_moves_as_inverse_dynamics_says():
    rollout = Rollout(nut(speed=20.0), 1, "cpu", record=[0], record_rate=1000.0, quantities=["coordinates", "speeds"])
    rollout.run()
    q, v = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))
    at_ = np.arange(50, 450, 50)
    a = (v[at_ + 5] - v[at_ - 5]) / 0.01
    needed = inverse_dynamics(nut(), q[at_], v[at_], a)
    np.testing.assert_allclose(needed, 0.0, atol=2e-3)


def test_names_files_and_messages_know_it(tmp_path):
    scene = nut()
    assert coordinate_names(topology(scene.character), scene.character)[0][-2:] == ("thread", "swing")
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    names, values = sto.coordinates(rollout.recording(0), scene)
    column = values[:, names.index("thread")]
    assert column[0] == pytest.approx(np.degrees(1.0), rel=1e-5)
    assert joint_type(scene.character.joints["thread"]).angle_names == ("turn",)
    with pytest.raises(Error, match="there is a joint type 'screw' already"):
        register(TYPES["screw"])
    with pytest.raises(RolloutError, match="single stages know no screw joint"):
        Stages(scene, 1, "cpu")


class Motionless(Coordinate):
    """A type that says nothing of its motion."""


@pytest.mark.parametrize(
    ("kind", "kernel", "message"),
    [
        (Motionless, f"{__name__}:screw_motion", "joint type 'odd' has no method `motion`"),
        (Screw, "", "joint type 'odd' names no `kernel`"),
        (Screw, f"{__name__}:scew_motion", "joint type 'odd': its kernel .*scew_motion' is not a Warp function"),
        (Screw, "no_such_module:f", "joint type 'odd': its kernel 'no_such_module:f' is not a Warp function"),
    ],
)
def test_what_a_type_forgets_is_named(kind: type[Coordinate], kernel: str, message: str):
    scene = nut()
    scene.character.joints["thread"].type = "odd"
    entry = kind(
        name="odd", kernel=kernel, coordinates=("",), speeds=("",), axes=1, limits=1, angles=("",),
        angle_names=("turn",),
    )  # fmt: skip

    def used() -> None:
        register(entry)
        Rollout(scene, 1, "cpu")

    try:
        with pytest.raises(Error, match=message):
            used()
    finally:
        TYPES.pop("odd", None)


def test_a_class_in_place_of_an_entry_is_told():
    with pytest.raises(Error, match=r"register an instance of a `JointType`.* not <class '.*Screw'>"):
        register(Screw)
