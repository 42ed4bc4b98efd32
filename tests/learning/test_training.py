"""A training keeps what it has learnt, and goes on after a kill at any moment to the same policy."""

import msgspec
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="learning needs PyTorch")

import h5py  # noqa: E402

from killing import killed_at  # noqa: E402
from warpmuscle.core.errors import Error, ResultError, RolloutError  # noqa: E402
from warpmuscle.core.status import Status  # noqa: E402
from warpmuscle.formats import load  # noqa: E402
from warpmuscle.learning.evaluation import evaluate  # noqa: E402
from warpmuscle.learning.options import PPOOptions  # noqa: E402
from warpmuscle.learning.player import Player, commanded, replay, task_of, undisturbed  # noqa: E402
from warpmuscle.learning.training import learn, resume, usual_task  # noqa: E402
from warpmuscle.results.result import read  # noqa: E402
from warpmuscle.results.training_file import training_path  # noqa: E402
from warpmuscle.scene.learning import Sense, Task, Tightening, Variation  # noqa: E402

OPTIONS = PPOOptions(instances=4, steps=6, epochs=2, minibatches=2, hidden=(16, 16))
TASK = Task(variation=Variation(velocity_noise=0.05))
SHORT = {"options": OPTIONS, "task": TASK, "device": "cpu", "threads": 1, "interval": 0.0}


def scene():
    return msgspec.structs.replace(load("reflex_planar"), duration=0.4)


def weights(result):
    return np.concatenate([layer.weight.ravel() for layer in result.learned.policy.layers])


@pytest.fixture(scope="module")
def whole():
    """A training of 4 iterations that nothing disturbs."""
    return learn(scene(), iterations=4, **SHORT).result


def test_a_training_leaves_policy_curve_and_motion(whole, tmp_path):
    path = tmp_path / "p.h5"
    trained = learn(scene(), path, iterations=4, command="warpmuscle learn x", **SHORT)
    found = read(path)
    np.testing.assert_array_equal(weights(found), weights(whole))
    assert found.command == "warpmuscle learn x"
    assert found.learned.ended == "all iterations are done"
    np.testing.assert_array_equal(found.learned.curve["iteration"], [1, 2, 3, 4])
    np.testing.assert_array_equal(found.learned.curve["decisions"], 24.0 * np.arange(1, 5))
    assert task_of(found.learned) == TASK
    assert len(found.replays) == 1
    assert trained.evaluation.instances == 4
    assert read(training_path(path)).learned.options["hidden"] == (16, 16)


def test_another_seed_learns_another_policy(whole):
    other = learn(scene(), iterations=1, seed=2, **SHORT).result
    assert not np.array_equal(weights(other), weights(whole))


MOMENTS = (*range(1, 21), 23, 26, 29, 32)


@pytest.mark.parametrize("moment", MOMENTS)
def test_after_a_kill_at_any_access_to_the_disk_it_comes_to_the_same_policy(moment, whole, tmp_path):
    path = tmp_path / "p.h5"
    with killed_at(moment) as killed:
        learn(scene(), path, iterations=4, **SHORT)
    if killed and not training_path(path).exists():
        learn(scene(), path, iterations=4, **SHORT)  # nothing was learnt yet
    elif killed:
        resume(path, threads=1, interval=0.0)
    found = read(path)
    np.testing.assert_array_equal(weights(found), weights(whole))
    np.testing.assert_array_equal(found.learned.curve["reward"], whole.learned.curve["reward"])
    assert sorted(file.name for file in tmp_path.iterdir()) == ["p.h5", "p.h5.training"]


def test_a_training_that_ended_goes_on_as_if_it_had_not(whole, tmp_path):
    path = tmp_path / "p.h5"
    learn(scene(), path, iterations=2, **SHORT)
    resume(path, iterations=4, threads=1)
    np.testing.assert_array_equal(weights(read(path)), weights(whole))


def test_rewards_that_change_go_on_where_they_were(tmp_path):
    tightening = Tightening(held=24, decisions=96, rewards={"speed_width": 2.0, "alive": 0.0})
    short = SHORT | {"task": msgspec.structs.replace(TASK, tightening=tightening)}
    straight = learn(scene(), iterations=6, **short).result.learned.curve["reward"]
    path = tmp_path / "p.h5"
    learn(scene(), path, iterations=2, **short)
    resume(path, iterations=6, threads=1)
    np.testing.assert_array_equal(read(path).learned.curve["reward"], straight)
    plain = learn(scene(), iterations=1, **SHORT).result.learned.curve["reward"]
    alive = TASK.rewards.alive * TASK.decision_time  # of a decision; the width makes the speed worth more
    assert plain[0] - straight[0] < alive
    assert straight[0] != plain[0]


def test_limits_that_tighten_go_on_where_they_were_and_a_trial_has_those_of_the_scene(whole, tmp_path):
    tightening = Tightening(decisions=96, com_height=0.3)  # of 4 iterations
    given, task = scene(), msgspec.structs.replace(TASK, tightening=tightening)
    given.failure = msgspec.structs.replace(given.failure, com_height=0.995)
    short = SHORT | {"task": task}
    path = tmp_path / "p.h5"
    undisturbed_one = learn(given, iterations=6, **short)
    learn(given, path, iterations=2, **short)
    resume(path, iterations=6, threads=1)
    found = read(path)
    np.testing.assert_array_equal(weights(found), weights(undisturbed_one.result))
    assert task_of(found.learned) == task
    plain = learn(given, iterations=6, **SHORT)
    assert not np.array_equal(weights(plain.result), weights(undisturbed_one.result))
    tried = evaluate(found.learned.policy, given, 4, "cpu", TASK, threads=1)
    assert undisturbed_one.evaluation == tried


def test_an_unfinished_training_is_not_replaced(tmp_path):
    path = tmp_path / "p.h5"
    with killed_at(12) as killed:
        learn(scene(), path, iterations=4, **SHORT)
    assert killed
    with pytest.raises(ResultError, match="an unfinished training; continue it with --resume"):
        learn(scene(), path, iterations=4, **SHORT)


def test_what_cannot_be_resumed_is_said_in_one_line(tmp_path, whole):
    path = tmp_path / "p.h5"
    with pytest.raises(ResultError, match="no training to go on with"):
        resume(path)
    learn(scene(), path, iterations=1, **SHORT)
    file = training_path(path)
    content = file.read_bytes()
    for name, value in (("state/values", np.zeros(3)), ("state/environment.0", np.zeros(3, np.uint8))):
        with h5py.File(file, "r+") as opened:
            del opened[name]
            opened[name] = value
        with pytest.raises(ResultError, match="damaged training") as caught:
            resume(path)
        assert "\n" not in str(caught.value)
        file.write_bytes(content)
    with h5py.File(file, "r+") as opened:
        names = [name for name in opened["state"] if name.startswith("environment.")]
        for name in names:
            opened[f"state/{name}"][...] = 255  # -1 of whole numbers
    with pytest.raises(ResultError, match="does not hold what was written"):
        resume(path)
    file.write_bytes(content[:5000])
    with pytest.raises(ResultError, match="not an HDF5 file, or damaged"):
        resume(path)


def test_a_training_needs_an_end():
    with pytest.raises(Error, match="needs an end"):
        learn(scene(), **SHORT)


def test_a_policy_gives_the_same_motion_in_every_slot_and_batch(whole):
    policy = whole.learned.policy
    calm = Task(variation=Variation(velocity_noise=0.0))

    def coordinates(instances):
        player = Player(policy, scene(), instances, "cpu", calm, seed=3)
        for _ in range(20):
            player.decide()
        return player.batch.rollout.state.coordinates.numpy()

    alone = coordinates(1)
    for instances in (2, 7):
        np.testing.assert_array_equal(coordinates(instances), np.repeat(alone, instances, axis=0))


def test_a_replay_is_what_the_player_does_and_ends_where_it_fails(whole):
    recording, status = replay(whole.learned.policy, scene(), "cpu", TASK)
    player = Player(whole.learned.policy, scene(), 1, "cpu", undisturbed(TASK), record=[0])
    decisions = 0
    while decisions < 40 and player.batch.rollout.state.status.numpy()[0] == 0:
        player.decide(restart=False)
        decisions += 1
    wanted = player.batch.rollout.recording()
    np.testing.assert_array_equal(recording.root_position, wanted.root_position)
    assert recording.frames == wanted.frames
    assert (status == Status.COMPLETED) == (decisions == 40)


def test_a_policy_of_another_task_is_refused(whole):
    task = Task(observations={"coordinates": Sense()})
    with pytest.raises(RolloutError, match="learnt for another scene or task: it observes 'trunk"):
        Player(whole.learned.policy, scene(), 1, "cpu", task)


def test_evaluation_counts_who_lasts_the_whole_time(whole):
    found = evaluate(whole.learned.policy, scene(), 6, "cpu", TASK)
    assert found.instances == 6
    assert 0.0 <= found.arrived <= found.completed <= 1.0


def test_a_walking_scene_learns_from_states_of_its_gait_by_default_and_else_what_it_says():
    assert usual_task(load("walk56")).variation.start_states > 0
    assert usual_task(msgspec.structs.replace(scene(), learning=TASK)) == TASK


def test_commands_of_a_policy_are_checked():
    task = Task(pose={"knee": (0.0, 1.0)}, command_time=2.0)
    told = commanded(task, ["speed=1.4", "knee = 0.5"])
    assert (told.speed, told.pose, told.command_time) == ((1.4, 1.4), {"knee": (0.5, 0.5)}, 0.0)
    for text in ("sped=1", "speed", "speed=fast", "speed=inf"):
        with pytest.raises(Error, match="KEY is speed, turning_rate, knee"):
            commanded(task, [text])
