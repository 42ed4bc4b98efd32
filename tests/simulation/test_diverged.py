"""Whatever finite numbers a search tries, what is left is finite, and what has none of it says so by its status."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import leaves, rebuilt
from warpmuscle.simulation.rollout import Rollout

COUNT = 100
WALK = "controller.states.0.trajectories"
ANYWHERE = (
    "character.joints.lKnee.position_in_child.1", "initial_state.root_velocity.2",
    "initial_state.root_position.1", "initial_state.root_orientation.1", "controller.desired_heading",
    "controller.states.0.trajectories.SWING_Hip.components.1.feedback.cd", "character.muscles.lSOL.path.0.position.0",
    "objective.target_speed", "ground.height", "initial_state.root_angular_velocity.0",
)  # fmt: skip
ABOVE_ZERO = (
    "character.bodies.lFoot.friction", "character.bodies.lFoot.mass",
    "character.bodies.torso.inertia.0", "character.muscles.rVAS.f_max",
    "character.muscles.rVAS.l_opt", "character.muscles.rSOL.l_slack", "controller.pd.lHip.kp", "controller.pd.rHip.kd",
    "controller.pd.lKnee.torque_limit", "controller.pd.pelvis_torso.scale.1", "controller.states.0.time",
    "ground.stiffness", "ground.damping", "failure.max_speed", "muscle_model.v_max",
    "muscle_model.damping", "muscle_model.rise_time", "objective.effort_cubed",
)  # fmt: skip


def extreme(rollout: Rollout, seed: int, largest: float) -> np.ndarray:
    """Candidates with some parameters of any size up to the largest, those of one sign with their own."""
    rng, count = np.random.default_rng(seed), len(rollout.parameters)
    start = np.array([p.value for p in rollout.parameters])
    lowest = np.array([p.min for p in rollout.parameters])
    size = 10.0 ** rng.uniform(-3.0, np.log10(largest), (COUNT, count))
    size *= np.where(lowest < 0.0, rng.choice([-1.0, 1.0], (COUNT, count)), 1.0)
    chosen = rng.random((COUNT, count)) < rng.uniform(0.02, 1.0, (COUNT, 1))
    return np.where(chosen, size, start)


def freed(scene: Scene) -> Scene:
    """The scene with numbers of every part of it free, in place of its own free parameters."""

    def replaced(key: str, leaf: object) -> object:
        if isinstance(leaf, Free):
            leaf = leaf.value if leaf.value is not None else 1.0
        if key in ABOVE_ZERO:
            return Free(leaf, min(leaf, 1e-3), 1e12)
        return Free(leaf, -1e12, 1e12) if key in ANYWHERE else leaf

    return rebuilt(scene, replaced)


def tried(scene: Scene, seed: int, largest: float = 1e37) -> Rollout:
    scene.duration = 0.3
    rollout = Rollout(scene, COUNT, "cpu", record=range(COUNT))
    rollout.set_parameters(extreme(rollout, seed, largest))
    rollout.run()
    return rollout


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("largest", [1e4, 1e37, 1e300])
@pytest.mark.parametrize(
    "name", ["fwalk", "walk56", "reflex_walk", pytest.param("walk56 everywhere", marks=pytest.mark.long)]
)
def test_all_that_is_left_of_extreme_parameters_is_finite(name: str, largest: float):
    scene = load(name.split()[0])
    if "everywhere" in name:
        scene = freed(scene)
        assert {*ANYWHERE, *ABOVE_ZERO} <= {key for key, _ in leaves(scene)}
    rollout = tried(scene, 1, largest)
    status = rollout.status()
    assert np.isin(status, list(Status)).all()
    assert (status == Status.DIVERGED).any()
    assert largest > 1e38 or (status != Status.DIVERGED).any()
    assert np.isfinite(rollout.cost()).all()
    for values in rollout.terms().values():
        assert np.isfinite(values).all()
    for instance in range(COUNT):
        recording = rollout.recording(instance)
        for quantity in QUANTITIES:
            assert np.isfinite(recording[quantity]).all(), (instance, quantity, Status(status[instance]).name)
        length = np.linalg.norm(recording.joint_target, axis=-1)
        np.testing.assert_allclose(length, 1.0, atol=1e-3, err_msg=f"instance {instance}")
        for parts in rollout.parts(instance).values():
            assert np.isfinite(list(parts.values())).all()


def test_a_target_that_is_no_rotation_is_divergence_though_muscles_bound_what_it_asks_for():
    scene = load("walk56")
    scene.duration = 0.1
    angles = [[0.4], [400.0], [1.2e3], [1e20], [-3e37]]
    status = []
    for recorded in ((), range(5)):
        rollout = Rollout(scene, 5, "cpu", record=recorded)
        rollout.set_parameters(keep_others(rollout, angles))
        rollout.run()
        status.append(rollout.status().tolist())
    assert status[0] == status[1]  # whether it is recorded or not
    assert status[0] == [Status.COMPLETED, Status.COMPLETED, Status.DIVERGED, Status.DIVERGED, Status.DIVERGED]
    assert rollout.recording(4).frames == 0


def keep_others(rollout: Rollout, angles: list[list[float]]) -> np.ndarray:
    """Candidates that differ in the first knot of the stance knee only."""
    names = [p.name for p in rollout.parameters]
    values = np.tile([p.value for p in rollout.parameters], (len(angles), 1))
    values[:, names.index(f"{WALK}.STANCE_Knee.components.0.angle.0")] = np.ravel(angles)
    return values


def test_what_the_rollout_gives_of_quantities_ends_with_the_instance():
    scene = load("walk56")
    scene.duration = 0.2
    rollout = Rollout(scene, 2, "cpu", record=[1, 0])
    rollout.set_parameters(keep_others(rollout, [[0.4], [1e30]]))
    rollout.run()
    assert rollout.status().tolist() == [Status.COMPLETED, Status.DIVERGED]
    for quantity in ("speeds", "muscle_force"):
        assert not rollout.recorded(quantity)[0].any()
        assert rollout.recorded(quantity)[1, -1].any()


def test_a_body_that_the_ground_throws_out_has_diverged():
    scene = load("fwalk")
    x, y, z = scene.initial_state.root_position
    scene.initial_state.root_position, scene.duration = (x, y - 0.5, z), 0.5
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    assert rollout.status().tolist() == [Status.DIVERGED]
    assert rollout.end_time()[0] > 0.0
    assert np.linalg.norm(rollout.recording().com_velocity, axis=1).max() <= scene.failure.max_com_speed


def test_the_bound_on_the_speed_of_the_body_is_the_scenes_own():
    scene = load("fwalk")
    scene.duration, scene.failure.max_com_speed = 0.2, 0.5
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.status().tolist() == [Status.DIVERGED]


@pytest.mark.usefixtures("unoptimized_test")
def test_a_term_that_gives_no_number_is_not_counted_as_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "their_nan.py").write_text(
        "import warp as wp\n"
        "from warpmuscle.kernels.structs import Model, State, Scratch\n"
        "@wp.func\n"
        "def late(instance: int, model: Model, state: State, work: Scratch) -> float:\n"
        "    return wp.sqrt(99.5 - float(state.step[instance]))\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    scene = load("fwalk")
    scene.duration, scene.objective.custom = 0.2, {"their_nan:late": 1.0}
    rollout = Rollout(scene, 1, "cpu", trust=True)
    rollout.run()
    assert rollout.status().tolist() == [Status.DIVERGED]
    assert rollout.end_time()[0] == pytest.approx(100 * scene.time_step)
    assert np.isfinite(rollout.terms()["their_nan:late"]).all()
