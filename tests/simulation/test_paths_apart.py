"""Paths that kernels of their own find before each step, as on a GPU: here on a CPU, against those within the step."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from muscle_arm import constant, leg
from warpmuscle.kernels.muscle.hill_law import HILL
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.path.route_bends import RouteKind
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.scene import CylinderSurface, Scene, SphereSurface, Wrap
from warpmuscle.simulation import rollout as rollouts
from warpmuscle.simulation.fused_kernel import FusedKernel
from warpmuscle.simulation.launcher import kernel_config
from warpmuscle.simulation.rollout import Rollout

TURNING, STEPS = 2.0, 40  # rad/s, of the starts; instances then take different ways
WRAPPED = PathKind(RouteKind(wraps=3))


def apart(in_scratch: bool, *given: object) -> object:
    """The usual configuration of a kernel, with paths that kernels of their own find."""
    config = kernel_config(*given)
    muscles = config.kind.muscles
    assert muscles.may_be_apart
    return config.compiling(muscles=muscles._replace(apart=True, pulls_in_scratch=in_scratch))


def wrapped_leg(excited: bool) -> Scene:
    """A leg with muscles round a cylinder and a sphere, which are excited, or which joints ask for torques."""
    scene = leg(duration=0.1)
    scene.character.surfaces = {
        "knee": CylinderSurface("thigh", (0.0, -0.2, 0.0), 0.03, 0.2, (0.1, 1.4, 0.2), "+x"),
        "ball": SphereSurface("pelvis", (0.02, -0.1, -0.05), 0.03),
        "shin": CylinderSurface("thigh", (0.0, -0.15, 0.02), 0.03, 0.2, (0.1, 1.4, 0.2)),
    }
    scene.character.muscles["both"].wraps = [Wrap("knee"), Wrap("ball", 1, 2), Wrap("shin")]
    if excited:
        for muscle in scene.character.muscles.values():
            muscle.excitation = constant(0.4)
    return scene


def moved(scene: Scene) -> tuple[np.ndarray, ...]:
    """Where the instances of a batch come to, and what their muscles do then; one of them has ended before."""
    rollout = Rollout(scene, 3, "cpu", threads=1)
    speeds = rollout.state.speeds
    speeds.assign(np.random.default_rng(1).uniform(-TURNING, TURNING, speeds.shape).astype(np.float32))
    rollout.step(STEPS)
    state = rollout.state
    return tuple(a.numpy() for a in (state.coordinates, state.speeds, state.muscles.force, state.step, state.status))


@pytest.mark.long
@pytest.mark.usefixtures("unoptimized_kernels")
@pytest.mark.parametrize(("excited", "in_scratch"), [(True, True), (False, False)])
def test_motion_is_the_same_to_the_bit(excited: bool, in_scratch: bool, monkeypatch: pytest.MonkeyPatch):
    scene = wrapped_leg(excited)
    scene.failure.com_height = 0.0
    within = moved(scene)
    monkeypatch.setattr(rollouts, "kernel_config", partial(apart, in_scratch))
    without = moved(scene)
    assert np.ptp(within[0], axis=0).max() > 1e-4
    for one, other in zip(within, without, strict=True):
        np.testing.assert_array_equal(one, other)


def test_paths_stay_within_a_step_that_needs_something_else_before_them():
    kind = MuscleKind(curves=0, tendon=0, law=HILL, paths=WRAPPED)
    assert kind.may_be_apart
    assert kind.wraps
    assert not kind._replace(apart=True).wraps
    for other in (
        {"shared": 1}, {"paths": WRAPPED._replace(monomials=3)}, {"law": HILL._replace(past_arms=True)},
        {"paths": PathKind(RouteKind(wraps=2))}, {"paths": PathKind(RouteKind(wraps=3, mujoco=True))},
    ):  # fmt: skip
        assert not kind._replace(**other).may_be_apart


@pytest.mark.parametrize("steps", [1, 5])
def test_slices_take_turns_on_streams_and_whoever_launched_waits_for_all(steps: int):
    log: list[tuple[str, str]] = []

    def stream(name: str) -> SimpleNamespace:
        return SimpleNamespace(name=name, wait_stream=lambda other: log.append((name, f"waits for {other.name}")))

    def command(what: str) -> SimpleNamespace:
        return SimpleNamespace(launch=lambda on: log.append((on.name, what)))

    kernel = FusedKernel.__new__(FusedKernel)
    kernel.device = SimpleNamespace(stream=stream("own"))
    kernel.__dict__["_streams"] = [stream("first"), stream("second"), stream("third")]
    parts = "places", "paths", "step"
    kernel._in_turn(steps, [[command(part) for part in parts] for _ in range(2)])
    one_step = [(name, part) for name in ("first", "second") for part in parts]
    assert log[:2] == [("first", "waits for own"), ("second", "waits for own")]
    assert log[2:-2] == one_step * steps
    assert log[-2:] == [("own", "waits for first"), ("own", "waits for second")]
