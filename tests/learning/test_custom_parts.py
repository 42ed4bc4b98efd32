"""Parts of a task of one's own: rewards, observations, goals, starts, ends and a curriculum do what they declare."""

from pathlib import Path

import numpy as np
import pytest
import warp as wp

from importing import importable_from
from muscle_arm import arm
from warpmuscle.core.errors import Error, SceneError, UserPartWarning
from warpmuscle.formats import toml
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.objective.objective_terms import REWARDS
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.learning import EpisodeBatch, Rewards, Sense, Task, Variation
from warpmuscle.learning.custom_parts import unsigned
from warpmuscle.learning.player import Player, task_of, text_of
from warpmuscle.model.part_checks import Found
from warpmuscle.results.learned import Layer, Learned, PolicyTable
from warpmuscle.scene import CustomPart, Scene
from warpmuscle.scene.learning import Goal
from warpmuscle.scene.trusted_code import named_code

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
NAME = "task_parts_of_one"
MODULE = '''"""A hand that reaches."""

import warp as wp

from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.learning.decision import Decision, goal_point
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Width:
    width: float


@wp.func
def hand(model: Model, work: Scratch) -> wp.vec3:
    return work.position[model.body_count - 1]


@wp.func
def to_goal(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> wp.vec3:
    return goal_point(instance, 0, decision) - hand(model, work)


@wp.func
def _closeness(instance: int, model: Model, state: State, work: Scratch, decision: Decision, own: Width) -> float:
    away = wp.length(goal_point(instance, 0, decision) - hand(model, work)) / own.width
    return wp.exp(-away * away)


@wp.func
def _decisions(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    return memory[0]


@wp.func
def _jolt(instance: int, model: Model, state: State, work: Scratch) -> float:
    a = centre_acceleration(instance, model.body_count - 1, model, work)
    return wp.dot(a, a)


@wp.func
def _somewhere(
    instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32
) -> wp.vec3:
    x = wp.randf(random)
    return wp.vec3(x, wp.randf(random), decision.difficulty[instance])


@wp.func
def _bent(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32):
    state.coordinates[instance, 7] = 0.2 + 0.3 * wp.randf(random)


@wp.func
def _turned(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
            own: Width, memory: wp.array[float]):
    memory[0] = memory[0] + 1.0
    state.coordinates[instance, 7] = own.width * memory[0] + 0.05 * wp.randf(random)


@wp.func
def _tilted(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
            own: Width):
    state.coordinates[instance, 7] = own.width + 0.05 * wp.randf(random)


@wp.func
def _nudged(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
            memory: wp.array[float]):
    memory[0] = memory[0] + 1.0
    state.coordinates[instance, 7] = 0.4 * memory[0] + 0.05 * wp.randf(random)


@wp.func
def _counted(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
             memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    return memory[0] + 0.1 * wp.randf(random)


@wp.func
def _wide(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
          own: Width) -> float:
    return own.width + 0.1 * wp.randf(random)


@wp.func
def _widening(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32,
              own: Width, memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    return own.width * memory[0] + 0.1 * wp.randf(random)


@wp.func
def _late(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> bool:
    return decision.length[instance] >= 3 + instance % 2


@wp.func
def _harder(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> float:
    if decision.reached[instance]:
        return decision.difficulty[instance] + 0.25
    return decision.difficulty[instance]


closeness = Declaration(function=_closeness, parameters=Width, stage="decision", sign="earned", unit="1/s")
decisions = Declaration(function=_decisions, memory=1, stage="decision")
jolt = Declaration(function=_jolt, stage="accelerations", unit="m^2/s^3")
somewhere = Declaration(function=_somewhere, stage="decision")
bent = Declaration(function=_bent, stage="decision")
turned = Declaration(function=_turned, stage="decision", parameters=Width, memory=1)
tilted = Declaration(function=_tilted, stage="decision", parameters=Width)
nudged = Declaration(function=_nudged, stage="decision", memory=1)
counted = Declaration(function=_counted, stage="decision", memory=1)
wide = Declaration(function=_wide, stage="decision", parameters=Width)
widening = Declaration(function=_widening, stage="decision", parameters=Width, memory=1)
reached = Declaration(function=_late, stage="decision", sign="earned")
lost = Declaration(function=_late, stage="decision")
harder = Declaration(function=_harder, stage="decision")
stageless = Declaration(function=_closeness, parameters=Width, sign="earned")
early = Declaration(function=_jolt, stage="accelerations")
'''
NOTHING = dict.fromkeys(REWARDS, 0.0)
STILL = Variation(velocity_noise=0.0)
N = 4


@pytest.fixture(scope="module", autouse=True)
def importable(tmp_path_factory):
    place: Path = tmp_path_factory.mktemp("task_parts")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield


def named(**weights: float) -> dict[str, float]:
    return {f"{NAME}:{name}": weight for name, weight in weights.items()}


def task_with(custom: dict[str, float] | None = None, **settings: object) -> Task:
    rewards = Rewards(**NOTHING, custom=custom or {})
    given = {"actions": "joint_targets", "episode_time": 0.5, "variation": STILL} | settings
    return Task(rewards=rewards, **given)


def batch_of(task: Task, n: int = N, seed: int = 0) -> EpisodeBatch:
    scene = arm()
    scene.custom = {
        entry: CustomPart({"width": 0.2}) for entry in [f"{NAME}:closeness"] if entry in task.rewards.custom
    }
    return EpisodeBatch(scene, n, "cpu", task, seed, threads=1, trust=True)


GOAL = {"place": Goal([-0.3, -0.2, 0.1], [0.3, 0.2, 0.5])}
WHOLE = task_with(
    named(closeness=2.0, decisions=0.5, jolt=1e-4) | {"applied_torque": 0.01},
    observations={"coordinates": Sense(), "goal": Sense(), f"{NAME}:to_goal": Sense()},
    goals=GOAL,
)


@wp.func
def worth(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> float:
    return 1.0


def test_a_reward_without_a_sign_is_told_with_what_to_add():
    declared = Declaration(function=worth, stage="decision")
    for entry, remedy in {
        "m:gain": 'add sign="earned" to the Declaration \'gain\', or sign="cost"',
        "m:worth": "name a Declaration of it, "
        'Declaration(function=worth, stage="decision", sign="earned"), or sign="cost"',
    }.items():
        said = f"reward {entry!r} declares no sign and is taken off as a cost: {remedy}"
        assert unsigned(Found(entry, "decision", declared)) == said


class TestRewards:
    """An arm that reaches for a point that is drawn for every episode."""

    @pytest.fixture(scope="class")
    def batch(self) -> EpisodeBatch:
        with pytest.warns(UserPartWarning, match="decisions' declares no sign"):
            return batch_of(WHOLE)

    def test_rewards_of_ones_own_and_terms_of_the_objective_are_what_they_declare(self, batch: EpisodeBatch):
        batch.reset(1)
        assert batch.judge.names[-4:] == (f"{NAME}:jolt", "applied_torque", f"{NAME}:closeness", f"{NAME}:decisions")
        goal = batch.custom_parts.decision.goal.numpy().astype(float)
        assert ((goal >= GOAL["place"].low) & (goal <= GOAL["place"].high)).all()
        assert np.ptp(goal, axis=0).min() > 0.01
        torques = np.zeros(N)
        for k in range(1, 6):
            batch.actions.requested.fill_(0.3)
            batch.step()
            assert not batch.episodes.mask.numpy().any()
            column = [name.startswith(f"{NAME}:to_goal") for name in batch.senses.names]
            away = np.linalg.norm(batch.senses.observation.numpy()[:, column], axis=1)
            worth = batch.judge.gains.custom.numpy() * batch.judge.gains.custom_weight.numpy()
            np.testing.assert_allclose(worth[:, 2], 2.0 * batch.dt * np.exp(-((away / 0.2) ** 2)), rtol=1e-4, atol=1e-7)
            np.testing.assert_allclose(worth[:, 3], -0.5 * batch.dt * k, rtol=1e-5)
            sums = dict(
                zip(
                    batch.rollout.structure.objective.body, batch.rollout.state.body_terms.numpy().sum(2).T, strict=True
                )
            )
            added = sums["applied_torque"] * batch.scene.time_step - torques
            torques += added
            np.testing.assert_allclose(worth[:, 1], -0.01 * added, rtol=1e-3, atol=1e-8)
            assert (worth[:, 0] < 0.0).all()
            np.testing.assert_allclose(batch.judge.gains.reward.numpy(), worth.sum(axis=1), rtol=1e-4)

    def test_points_are_observed_from_the_root_and_memories_begin_anew_with_an_episode(self, batch: EpisodeBatch):
        batch.reset(1)
        goal, column = batch.custom_parts.decision.goal.numpy().copy(), batch.senses.names.index("goal.place.x")
        np.testing.assert_allclose(batch.senses.observation.numpy()[:, column : column + 3], goal, atol=1e-6)
        for _ in range(batch.longest + 1):
            batch.step()
        assert (batch.judge.gains.custom.numpy()[:, 3] == 1.0).all()
        assert (batch.custom_parts.decision.goal.numpy() != goal).any()

    def test_an_instance_is_rewarded_alike_whatever_the_batch(self, batch: EpisodeBatch):
        batch.reset(1)
        other = batch_of(WHOLE, n=2, seed=1)
        for _ in range(4):
            for one in (batch, other):
                one.actions.requested.fill_(0.2)
                one.step()
        for one, two in (
            (batch.senses.observation, other.senses.observation),
            (batch.judge.gains.reward, other.judge.gains.reward),
        ):
            np.testing.assert_array_equal(one.numpy()[:2], two.numpy())

    def test_a_policy_that_learnt_it_is_played_with_its_task(self, batch: EpisodeBatch):
        names, actions = tuple(batch.senses.names), batch.actions.names
        layer = Layer(np.full((len(actions), len(names)), 0.1, np.float32), np.zeros(len(actions), np.float32))
        count = len(names)
        policy = PolicyTable(names, actions, np.zeros(count, np.float32), np.ones(count, np.float32), 10.0, (layer,))
        task = task_of(Learned(policy, text_of(WHOLE), {}, {}))
        assert task == WHOLE
        player = Player(policy, batch.rollout.scene, 1, "cpu", task)
        before = player.batch.senses.observation.numpy().copy()
        player.decide()
        assert (player.batch.senses.observation.numpy() != before).any()


def test_goals_and_starts_are_drawn_ends_end_and_a_curriculum_makes_it_harder():
    task = task_with(
        goals={"far": Goal([0.1], [0.2]), "place": Goal(draw=f"{NAME}:somewhere")},
        ends=[f"{NAME}:reached"], curriculum=f"{NAME}:harder",
        variation=Variation(velocity_noise=0.0, start=f"{NAME}:bent"),
    )  # fmt: skip
    batch = batch_of(task)
    column = batch.rollout.coordinate_names.index("elbow")
    drawn, difficulty = [], []
    for _ in range(12):
        batch.actions.requested.zero_()
        batch.step()
        ended = batch.episodes.length.numpy() == 0
        np.testing.assert_array_equal(batch.judge.gains.terminated.numpy(), ended)
        np.testing.assert_array_equal(batch.judge.gains.sums.numpy()[:, -1], 0.0)
        drawn.append(batch.rollout.state.coordinates.numpy()[ended, column])
        difficulty.append(batch.custom_parts.decision.difficulty.numpy().copy())
        np.testing.assert_array_equal(batch.custom_parts.decision.goal.numpy()[ended, 3], difficulty[-1][ended])
    assert batch.custom_parts.goals == [("far", 0, 1), ("place", 1, 3)]
    assert (
        (batch.custom_parts.decision.goal.numpy()[:, 0] >= 0.1)
        & (batch.custom_parts.decision.goal.numpy()[:, 0] <= 0.2)
    ).all()
    assert next(name for name in batch.senses.names if "goal" in name) == "goal.far"
    starts = np.concatenate(drawn)
    assert len(starts) == 4 * 2 + 3 * 2  # every 3 decisions, every 4
    assert ((starts >= 0.2) & (starts <= 0.5)).all()
    assert np.ptp(starts) > 0.05
    np.testing.assert_allclose(difficulty[-1], [1.0, 0.75, 1.0, 0.75])


@pytest.mark.parametrize("name", ["turned", "tilted"])
def test_a_start_may_have_numbers_and_a_memory_of_its_own(name: str):
    task = task_with(ends=[f"{NAME}:reached"], variation=Variation(velocity_noise=0.0, start=f"{NAME}:{name}"))
    scene = arm()
    scene.custom = {f"{NAME}:{name}": CustomPart({"width": 0.3})}
    batch = EpisodeBatch(scene, N, "cpu", task, 0, threads=1, trust=True)
    column, drawn = batch.rollout.coordinate_names.index("elbow"), []
    for _ in range(6):
        batch.step()
        drawn.append(batch.rollout.state.coordinates.numpy()[batch.episodes.length.numpy() == 0, column])
    starts = np.concatenate(drawn)
    assert len(starts) >= N
    assert np.all((starts >= 0.3) & (starts <= 0.35))
    assert np.ptp(starts) > 0.01


def test_goals_and_starts_may_have_a_memory_numbers_or_both():
    drawn = {"counted": 1.0, "wide": 0.3, "widening": 0.5}  # what is the least of each, which may be 0.1 more
    task = task_with(
        goals={name: Goal(draw=f"{NAME}:{name}") for name in drawn}, ends=[f"{NAME}:reached"],
        variation=Variation(velocity_noise=0.0, start=f"{NAME}:nudged"),
    )  # fmt: skip
    scene = arm()
    scene.custom = {f"{NAME}:{name}": CustomPart({"width": drawn[name]}) for name in ("wide", "widening")}
    batch = EpisodeBatch(scene, N, "cpu", task, 0, threads=1, trust=True)
    column, goals, starts = batch.rollout.coordinate_names.index("elbow"), [], []
    for _ in range(6):
        batch.step()
        new = batch.episodes.length.numpy() == 0
        goals.append(batch.custom_parts.decision.goal.numpy()[new, : len(drawn)])
        starts.append(batch.rollout.state.coordinates.numpy()[new, column])
    away = np.concatenate(goals) - list(drawn.values())
    assert len(away) >= N
    assert np.all((away >= 0.0) & (away <= 0.1))
    assert np.all(np.ptp(away, axis=0) > 0.01)
    bent = np.concatenate(starts)
    assert np.all((bent >= 0.4) & (bent <= 0.45))


def test_an_end_that_is_a_cost_is_a_failure():
    task = task_with(ends=[f"{NAME}:lost"])
    task.rewards.failure = 2.0
    batch = batch_of(task, 2)
    rewards = []
    for _ in range(4):
        batch.step()
        rewards.append(batch.judge.gains.reward.numpy().copy())
    np.testing.assert_allclose(rewards, [[0.0, 0.0], [0.0, 0.0], [-2.0, 0.0], [0.0, -2.0]])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"custom": named(closeness=1.0)}, r"custom.*closeness.parameters: there is no value of 'width'"),
        ({"custom": named(nothing=1.0)}, r"learning.rewards.custom.*: module .* has no function 'nothing'"),
        ({"custom": {"appliedtorque": 1.0}}, "no term is called 'appliedtorque'; did you mean 'applied_torque'"),
        ({"custom": named(jolt=-1.0)}, "must not be negative, is -1: a part declares its sign"),
        ({"ends": [f"{NAME}:decisions"]}, r"learning.ends.0: .* must say that it returns bool, and says float"),
        (
            {"ends": [f"{NAME}:bent"]},
            r"an end of an episode takes \(int, Model, State, Scratch\) \[, Decision\], but .* takes",
        ),
        (
            {"goals": {"g": Goal(draw=f"{NAME}:to_goal")}},
            r"goals.g.draw: a goal takes \(int, .*, Decision, uint32\), but",
        ),
        ({"goals": {"g": Goal([0.0, 1.0], [1.0, 2.0])}}, "low and high have three numbers each, of a point, or one"),
        ({"goals": {"g": Goal()}}, "give either low and high, or draw"),
        ({"observations": {f"{NAME}:early": Sense()}}, "is 'decision' here, not 'accelerations'"),
        ({"custom": named(stageless=1.0)}, r"rewards.custom.*: .* takes a Decision: declare stage='decision'"),
        (
            {"variation": Variation(start=f"{NAME}:somewhere")},
            "variation.start: .* must say that it returns nothing, and says wp.vec3",
        ),
        ({"curriculum": "no colon"}, "is not the name of a function as in 'module:function'"),
    ],
    ids=str,
)
def test_what_is_forgotten_is_named_in_one_line(settings: dict, message: str):
    scene: Scene = arm()
    with pytest.raises(Error, match=message) as caught:
        EpisodeBatch(scene, 1, "cpu", task_with(**settings), trust=True)
    assert "\n" not in str(caught.value)


def test_a_task_is_not_run_unless_it_is_trusted_and_is_written_and_read_again():
    scene = arm()
    scene.learning, scene.custom = WHOLE, {f"{NAME}:closeness": CustomPart({"width": 0.2})}
    assert toml.loads(toml.dumps(scene)) == scene
    entries = {name.replace(NAME, "strange_task") for name in named_code(scene).values()}
    assert len(entries) == 4
    strange = toml.loads(toml.dumps(scene).replace(NAME, "strange_task"))
    with pytest.raises(SceneError, match="wants to run code of 'strange_task:"):
        EpisodeBatch(strange, 1, "cpu")
