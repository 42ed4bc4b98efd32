"""A training that begins with another policy: what it takes over, what does not fit, and that it survives kills."""

import os
from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="learning needs PyTorch")

import h5py  # noqa: E402

from killing import killed_at  # noqa: E402
from point_mass import PointMasses  # noqa: E402
from small_policy import learning_curve  # noqa: E402
from warpmuscle.core.errors import Error, ResultError, RolloutError  # noqa: E402
from warpmuscle.formats import load  # noqa: E402
from warpmuscle.learning import training_loop  # noqa: E402
from warpmuscle.learning.learner import Learner  # noqa: E402
from warpmuscle.learning.options import PPOOptions  # noqa: E402
from warpmuscle.learning.policy import actions_of  # noqa: E402
from warpmuscle.learning.senses import USUAL  # noqa: E402
from warpmuscle.learning.training import learn, resume  # noqa: E402
from warpmuscle.learning.warm_start import UNHEARD, check_fit, hearing, options_from  # noqa: E402
from warpmuscle.report.summary import learning  # noqa: E402
from warpmuscle.results.learned import Ancestor, Layer, Learned, PolicyTable  # noqa: E402
from warpmuscle.results.result import read, write  # noqa: E402
from warpmuscle.results.training_file import training_path  # noqa: E402
from warpmuscle.scene.learning import Sense, Task, Variation  # noqa: E402

NUMBERS = {"instances": 4, "steps": 6, "epochs": 2, "minibatches": 2}
TASK = Task(variation=Variation(velocity_noise=0.05))
SHORT = {"device": "cpu", "threads": 1, "interval": 0.0}


def scene():
    return msgspec.structs.replace(load("reflex_planar"), duration=0.4)


def begin(source, output=None, *, iterations=1, task=TASK, seed=5, **options):
    return learn(
        scene(), output, task=task, options=NUMBERS | options, source=source, seed=seed, iterations=iterations,
        command="warpmuscle learn second", **SHORT,
    ).result  # fmt: skip


def weights(table):
    """All of them, but for those of what was always the same, which say nothing."""
    inputs = np.where(table.deviation < UNHEARD, table.layers[0].weight, 0.0)
    layers = [inputs, *(layer.weight for layer in table.layers[1:]), *(layer.bias for layer in table.layers)]
    return np.concatenate([layer.ravel() for layer in layers])


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The file of a policy to begin with."""
    path = tmp_path_factory.mktemp("first") / "first.h5"
    options = NUMBERS | {"hidden": (16, 8)}
    learn(scene(), path, task=TASK, options=options, iterations=3, command="warpmuscle learn first", **SHORT)
    return path


@pytest.fixture(scope="module")
def whole(first):
    """What a training that nothing disturbs comes to, in two iterations of the critic alone and two of both."""
    return begin(first, iterations=4, critic_iterations=2).learned


def test_a_training_begins_with_the_policy_its_noise_and_its_critic(first):
    known, found = read(first).learned, begin(first, critic_iterations=1).learned
    np.testing.assert_array_equal(weights(found.policy), weights(known.policy))
    np.testing.assert_allclose(found.policy.noise.deviation, known.policy.noise.deviation, rtol=1e-6)
    assert found.options["hidden"] == (16, 8)
    assert found.options["learning_rate"] == pytest.approx(known.curve["learning_rate"][-1])
    change = np.abs(weights(found.critic) - weights(known.critic)).max()
    assert 0.0 < change < 0.05  # of weights of about 0.3: a few steps on
    assert found.critic.observation != found.policy.observation
    other = begin(first, iterations=2, critic_iterations=1).learned
    assert not np.array_equal(weights(other.policy), weights(known.policy))


def test_a_critic_of_an_older_file_whose_names_lack_their_groups_is_begun_with_too(first, tmp_path):
    result, path = read(first), tmp_path / "older.h5"
    learned = result.learned
    bare = tuple(name.partition(".")[2] for name in learned.critic.observation)
    assert bare != learned.critic.observation
    older = replace(learned, critic=replace(learned.critic, observation=bare))
    write(path, replace(result, learned=older))
    new, old = (begin(file, critic_iterations=1).learned.critic for file in (first, path))
    np.testing.assert_array_equal(weights(old), weights(new))


def test_a_policy_acts_as_before_on_what_it_will_see(first):
    known, found = read(first).learned.policy, begin(first, critic_iterations=1).learned.policy
    heard = known.deviation < UNHEARD
    seen = np.tile(known.mean, (50, 1))
    noise = np.random.default_rng(1).normal(size=seen.shape).astype(np.float32)
    seen[:, heard] += (noise * known.deviation)[:, heard]
    shift = np.abs(actions_of(found, seen) - actions_of(known, seen)).max()
    assert shift < 0.1  # normalisation goes on: 24 samples more than 72 that it knows


def test_greatest_noise_and_rate_can_be_said(first):
    known = read(first).learned
    found = begin(first, critic_iterations=1, deviation=0.2, learning_rate=3e-4).learned
    assert found.policy.noise.deviation.max() == pytest.approx(0.2, rel=1e-5)
    shares = known.policy.noise.deviation / known.policy.noise.deviation.max()
    np.testing.assert_allclose(found.policy.noise.deviation / 0.2, shares, rtol=1e-5)
    assert found.curve["learning_rate"][0] == pytest.approx(3e-4)


def test_a_file_says_what_its_policy_was_learnt_from(first, tmp_path):
    second, third = tmp_path / "second.h5", tmp_path / "third.h5"
    begin(first, second, seed=5)
    begin(second, third, seed=6)
    told = [(one.file, one.seed, one.decisions, one.command) for one in read(third).learned.ancestors]
    assert told == [("second.h5", 5, 24, "warpmuscle learn second"), ("first.h5", 1, 72, "warpmuscle learn first")]
    text = "\n".join(learning(read(third).learned))
    assert "begun with second.h5: seed 5, 24 decisions, warpmuscle learn second" in text
    assert "begun with first.h5: seed 1" in text
    write(tmp_path / "again.h5", read(third))
    assert (tmp_path / "again.h5").read_bytes() == third.read_bytes()


@pytest.mark.parametrize("moment", [7, 15, 22])
def test_after_a_kill_it_comes_to_the_same_policy_though_the_first_one_is_gone(
    moment, first, whole, tmp_path, monkeypatch
):
    monkeypatch.setattr(training_loop, "SHARE", 1e9)  # so that a slow disk leaves out no checkpoint
    source, path = tmp_path / "source.h5", tmp_path / "p.h5"
    source.write_bytes(first.read_bytes())
    with killed_at(moment) as killed:
        begin(source, path, iterations=4, critic_iterations=2)
    assert killed
    source.unlink()
    found = resume(path, threads=1, interval=0.0).result.learned
    np.testing.assert_array_equal(weights(found.policy), weights(whole.policy))
    np.testing.assert_array_equal(weights(found.critic), weights(whole.critic))
    assert found.ancestors[0].file == "source.h5"


MISFITS = {
    "observations": (
        {"task": Task(observations={"coordinates": Sense()})},
        "other observations: '.*', '.*', '.*' and [0-9]+ more are lacking here",
    ),
    "scale": ({"task": Task(action_scale=0.5)}, "learning.action_scale None, not 0.5"),
    "layers": ({"hidden": (16, 16)}, "hidden layers of 16-8, not 16-16"),
    "option": ({"epoch": 3}, "no option 'epoch'"),
}


@pytest.mark.parametrize("name", MISFITS)
def test_what_does_not_fit_is_said_in_one_line(name, first):
    given, message = MISFITS[name]
    with pytest.raises((RolloutError, Error), match=message) as caught:
        begin(first, **given)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 250


def test_names_that_are_lacking_new_or_in_another_order_are_said(first):
    source = read(first).learned
    seen, moved = source.policy.observation, source.policy.action

    def refused(message, observation=seen, action=moved):
        env = SimpleNamespace(observation_names=observation, action_names=action)
        with pytest.raises(RolloutError, match=message):
            check_fit(source, env, TASK)

    refused(f"other observations: '{seen[0]}' is lacking here$", seen[1:])
    refused(f"other observations: '{seen[1]}' is lacking here$", ("x", seen[0], *seen[2:]))
    refused(f"other actions: '{moved[0]}' is lacking here and 'arm', 'leg' are new$", action=("arm", "leg", *moved[1:]))
    refused("other actions: the order is another$", action=moved[::-1])
    check_fit(source, SimpleNamespace(observation_names=seen, action_names=moved), TASK)
    check_fit(source, SimpleNamespace(observation_names=("x", *seen[::-1]), action_names=moved), TASK)


def test_what_is_new_says_nothing_at_first_and_then_more(first):
    """Also where known observations come in another order."""
    known = read(first).learned.policy
    more = msgspec.structs.replace(
        TASK, observations={name: Sense() for name in ("fibre_length", *reversed(USUAL))}
    )  # fmt: skip
    found = begin(first, task=more, critic_iterations=1).learned.policy
    new = [k for k, name in enumerate(found.observation) if name not in known.observation]
    assert len(new) == len(found.observation) - len(known.observation) > 0
    assert (found.layers[0].weight[:, new] == 0.0).all()
    seen = np.tile(found.mean, (50, 1))
    heard = [k for k, name in enumerate(found.observation) if found.deviation[k] < UNHEARD]
    noise = np.random.default_rng(1).normal(size=seen.shape).astype(np.float32)
    seen[:, heard] += (noise * found.deviation)[:, heard]
    as_known = seen[:, [found.observation.index(name) for name in known.observation]]
    assert np.abs(actions_of(found, seen) - actions_of(known, as_known)).max() < 0.1
    later = begin(first, task=more, iterations=3, critic_iterations=1).learned.policy
    assert (later.layers[0].weight[:, new] != 0.0).any()


def test_files_that_hold_no_policy_are_refused_in_one_line(first, tmp_path):
    broken = tmp_path / "broken.h5"
    whole = first.read_bytes()

    def refused(message, content=None, **changes):
        if content is not None:
            broken.write_bytes(content)
        if changes:
            with h5py.File(broken, "r+") as file:
                file.attrs.update(changes)
        with pytest.raises(ResultError, match=message) as caught:
            begin(broken, tmp_path / "new.h5")
        assert "\n" not in str(caught.value)
        assert not (tmp_path / "new.h5").exists()

    with pytest.raises(ResultError, match="no such file"):
        begin(tmp_path / "nothing.h5")
    refused("not an HDF5 file", b"")
    refused("not an HDF5 file", b"name = 'x'\n")
    refused("damaged", whole[: len(whole) // 2])
    refused("newer", whole, format_version=99)
    write(broken, replace(read(first), learned=None))
    refused("holds no policy")
    broken.write_bytes(whole)
    with h5py.File(broken, "r+") as file:
        del file["critic/layers/0/weight"]
        file["critic/layers/0/weight"] = np.zeros((3, 3), np.float32)
    refused("critic/layers/0")
    broken.write_bytes(whole)
    with h5py.File(broken, "r+") as file:
        file["training"].create_group("ancestors")["seed"] = np.array([1])
    refused("is missing")


def test_the_policy_to_begin_with_is_never_replaced(first, tmp_path):
    path, linked = tmp_path / "p.h5", tmp_path / "linked.h5"
    path.write_bytes(first.read_bytes())
    os.link(path, linked)
    for output in (path, linked):
        with pytest.raises(ResultError, match="would replace the policy to begin with"):
            begin(path, output)
    training_path(path).write_bytes(training_path(first).read_bytes())
    with pytest.raises(ResultError, match="would replace the policy to begin with"):
        begin(training_path(path), path)
    assert path.read_bytes() == first.read_bytes()


def test_a_speed_that_was_always_the_same_says_nothing_until_it_is_learnt(first):
    known = read(first).learned.policy
    number = known.observation.index("command.speed")
    assert known.deviation[number] == UNHEARD
    wider = msgspec.structs.replace(TASK, speed=(0.8, 1.6))
    found = begin(first, task=wider, critic_iterations=1).learned.policy
    assert 0.01 < found.deviation[number] < 1.0
    assert (found.layers[0].weight[:, number] == 0.0).all()
    found = begin(first, task=wider, iterations=2, critic_iterations=1).learned.policy
    assert (found.layers[0].weight[:, number] != 0.0).any()


def test_a_critic_that_saw_something_else_begins_anew(first, tmp_path):
    old = tmp_path / "old.h5"
    old.write_bytes(first.read_bytes())
    with h5py.File(old, "r+") as file:
        del file["critic"]
    known, found = read(first).learned, begin(old, critic_iterations=1).learned
    np.testing.assert_array_equal(weights(found.policy), weights(known.policy))
    assert np.abs(weights(found.critic) - weights(known.critic)).max() > 0.1


def test_a_critic_that_begins_anew_learns_at_the_rate_of_noise_until_the_policy_goes_on(first, tmp_path):
    old = tmp_path / "old.h5"
    old.write_bytes(first.read_bytes())
    with h5py.File(old, "r+") as file:
        del file["critic"]
    told = {"iterations": 3, "critic_iterations": 2, "learning_rate": 2e-4, "divergence": 0.0}
    rates = {file: begin(file, **told).learned.curve["learning_rate"] for file in (first, old)}
    np.testing.assert_allclose(rates[first], 2e-4, rtol=1e-5)
    np.testing.assert_allclose(rates[old], [PPOOptions().learning_rate] * 2 + [2e-4], rtol=1e-5)


def test_a_critic_that_is_to_see_more_goes_on_from_what_it_knows(first):
    more = msgspec.structs.replace(TASK, variation=Variation(velocity_noise=0.05, mass=0.1, variants=4))
    known, found = read(first).learned.critic, begin(first, task=more, critic_iterations=1).learned.critic
    assert len(found.observation) > len(known.observation)
    assert known.observation == found.observation[: len(known.observation)]
    apart = np.abs(found.layers[1].weight - known.layers[1].weight).max()
    assert 0.0 < apart < 0.05  # of weights of about 0.3: a few steps on


def test_names_that_come_twice_stay_apart():
    table = PolicyTable(("a.x", "b.x", "a.x"), ("y",), np.arange(3.0, dtype=np.float32), np.ones(3, np.float32), 8.0,
                        (Layer(np.array([[1.0, 2.0, 3.0]], np.float32), np.zeros(1, np.float32)),), None)  # fmt: skip
    found = hearing(table, ("a.x", "c.x", "a.x", "b.x"))
    np.testing.assert_array_equal(found.layers[0].weight, [[1.0, 0.0, 3.0, 2.0]])
    np.testing.assert_array_equal(found.mean, [0.0, 0.0, 2.0, 1.0])
    assert found.deviation[1] == UNHEARD


def test_what_was_learnt_is_kept_and_goes_on_from_there():
    options = PPOOptions(hidden=(32, 32))
    learner = Learner(PointMasses(64), options, seed=1)
    rewards = [learner.iterate()["reward"] for _ in range(20)]
    itself = Ancestor("p.h5", 1, 20 * 64 * 24, "")
    curve = learning_curve(1) | {"learning_rate": np.full(1, 1e-3)}
    source = Learned(learner.policy(), "{}", curve, {}, critic=learner.critic(), ancestors=(itself,))
    begun = Learner(PointMasses(64), options_from(source, {"critic_iterations": 3}), seed=2, source=source)
    after = [begun.iterate()["reward"] for _ in range(15)]
    assert rewards[0] < 0.35
    assert min(after) > 0.6  # where a policy just begun comes to 0.35
    assert np.mean(after[-4:]) > 0.75
