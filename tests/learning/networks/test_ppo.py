"""Proximal policy optimisation: its sums against their definitions, and that it learns."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="learning needs PyTorch")

from point_mass import PointMasses  # noqa: E402
from warpmuscle.core.errors import Error, RolloutError  # noqa: E402
from warpmuscle.learning.learner import Learner  # noqa: E402
from warpmuscle.learning.networks.actor_critic import ActorCritic, Normalizer  # noqa: E402
from warpmuscle.learning.networks.optimizer import FlatAdam  # noqa: E402
from warpmuscle.learning.networks.ppo import Effort, _divergence, advantages  # noqa: E402
from warpmuscle.learning.options import PPOOptions, options_of, parsed  # noqa: E402
from warpmuscle.learning.policy import actions_of  # noqa: E402
from warpmuscle.learning.symmetry import Image, Images  # noqa: E402


def test_advantages_are_the_discounted_sum_of_surprises_within_an_episode():
    random = np.random.default_rng(1)
    steps, n, gamma, lam = 7, 3, 0.9, 0.8
    reward, value = random.normal(size=(2, steps, n))
    done = (random.uniform(size=(steps, n)) < 0.3).astype(float)
    last = random.normal(size=n)
    wanted = np.zeros((steps, n))
    for i in range(n):
        for t in range(steps):
            weight = 1.0
            for k in range(t, steps):
                following = last[i] if k == steps - 1 else value[k + 1, i]
                wanted[t, i] += weight * (reward[k, i] + gamma * (1.0 - done[k, i]) * following - value[k, i])
                if done[k, i]:
                    break
                weight *= gamma * lam
    given = [torch.tensor(array) for array in (reward, value, done, last)]
    np.testing.assert_allclose(advantages(*given, gamma, lam).numpy(), wanted, rtol=1e-12)


def test_adam_on_one_vector_steps_as_that_of_pytorch_with_clipped_gradients():
    torch.manual_seed(0)
    ours, theirs = (torch.nn.Sequential(torch.nn.Linear(5, 4), torch.nn.Tanh(), torch.nn.Linear(4, 3)) for _ in "ab")
    theirs.load_state_dict(ours.state_dict())
    adam, reference = FlatAdam([list(ours.parameters())], 0.01, 0.5), torch.optim.Adam(theirs.parameters(), lr=0.01)
    data = torch.randn(20, 5)
    for _ in range(30):
        adam.forget()
        (ours(data) ** 2).sum().backward()
        with torch.no_grad():
            adam.step()
        reference.zero_grad()
        (theirs(data) ** 2).sum().backward()
        torch.nn.utils.clip_grad_norm_(theirs.parameters(), 0.5)
        reference.step()
    for one, other in zip(ours.parameters(), theirs.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=1e-4, atol=1e-6)


def test_a_gradient_that_is_not_finite_changes_nothing_of_its_group():
    bad, good = torch.nn.Linear(3, 2), torch.nn.Linear(3, 2)
    before = [layer.weight.detach().clone() for layer in (bad, good)]
    adam = FlatAdam([list(bad.parameters()), list(good.parameters())], 0.01, 1.0)
    adam.forget()
    bad.weight.grad[1, 2] = float("nan")
    good.weight.grad.fill_(0.1)
    adam.step()
    torch.testing.assert_close(bad.weight.detach(), before[0])
    torch.testing.assert_close(good.weight.detach(), before[1] - 0.01)


def test_a_group_with_a_rate_of_its_own_steps_by_it_and_others_by_the_rate_that_adapts():
    layers = [torch.nn.Linear(3, 2), torch.nn.Linear(3, 2)]
    before = [layer.weight.detach().clone() for layer in layers]
    adam = FlatAdam([list(layer.parameters()) for layer in layers], 0.01, 1.0, [0.0, 0.03])
    adam.rate.fill_(0.002)
    adam.forget()
    for layer in layers:
        layer.weight.grad.fill_(0.1)
    adam.step()
    for layer, old, rate in zip(layers, before, (0.002, 0.03), strict=True):
        torch.testing.assert_close(layer.weight.detach(), old - rate)


def test_values_that_are_not_clipped_come_nearer_to_returns_in_one_update():
    lost = {}
    for clip in (0.0, 0.01):
        learner = a_learner(value_clip=clip, critic_rate=3e-3, epochs=8)
        for _ in range(3):
            lost[clip] = learner.iterate()["value_loss"]
    assert lost[0.0] < 0.8 * lost[0.01]


def test_a_normalizer_knows_mean_and_variance_of_all_that_it_saw():
    data = torch.randn(1000, 4, dtype=torch.float64) * torch.tensor([1.0, 5.0, 0.1, 2.0]) + 3.0
    normalizer = Normalizer(4).double()
    for part in data.split([100, 650, 250]):
        normalizer.see(part)
    torch.testing.assert_close(normalizer.mean, data.mean(0))
    torch.testing.assert_close(normalizer.variance, data.var(0, correction=0))


def test_the_divergence_of_gaussian_policies_is_that_of_their_distributions():
    random = torch.Generator().manual_seed(2)
    old_mean, mean = torch.randn(2, 6, 3, generator=random)
    old, new = torch.randn(2, 3, generator=random) * 0.3
    normal = torch.distributions.Normal
    found = _divergence(old_mean, old, mean, new, torch.ones(6))
    wanted = torch.distributions.kl_divergence(normal(old_mean, old.exp()), normal(mean, new.exp())).sum(-1).mean()
    torch.testing.assert_close(found, wanted)


def test_likelihoods_are_those_of_gaussians_but_for_a_constant():
    networks = ActorCritic(4, 5, 3, (8,), 0.4, seed=1)
    mean, action = torch.randn(2, 7, 3)
    wanted = torch.distributions.Normal(mean, 0.4).log_prob(action).sum(-1)
    found = networks.log_likelihood(mean, action)
    torch.testing.assert_close(found - found[0], wanted - wanted[0], rtol=1e-4, atol=1e-4)


def a_learner(**options):
    return Learner(PointMasses(64), PPOOptions(hidden=(32, 32), **options), seed=1)


def test_points_learn_to_come_to_the_middle():
    learner = a_learner()
    before = learner.iterate()["reward"]
    for _ in range(30):
        row = learner.iterate()
    assert before < 0.35
    assert row["reward"] > 0.75  # of at most 1


def a_mirrored_learner(**options):
    """Its points are their own images to the other side; its policy pushes to one side."""
    points, turned = PointMasses(64), Image(np.arange(2), -np.ones(2), np.zeros(2))
    points.images = Images(turned, turned, Image(np.zeros(1, int), -np.ones(1), np.zeros(1)))
    learner = Learner(points, PPOOptions(hidden=(32, 32), **options), seed=1)
    with torch.no_grad():
        learner.networks.policy[-1].bias.fill_(0.4)
    return learner


def asymmetry_of(learner):
    """Mean distance of actions from those in the mirror, over points to both sides."""
    seen = torch.randn(200, 2, generator=torch.Generator().manual_seed(4))
    with torch.no_grad():
        return float((learner.networks.act(seen) + learner.networks.act(-seen)).abs().mean())


@pytest.mark.parametrize(("mirrored", "least", "most"), [("action", 0.2, 0.5), ("noise", 0.0, 1e-6)])
def test_images_lie_outside_the_clipped_ratio_unless_noise_alone_is_mirrored(mirrored, least, most):
    still = {"learning_rate": 1e-12, "min_learning_rate": 1e-12, "divergence": 0.0}
    row = a_mirrored_learner(mirrored=mirrored, **still).iterate()
    assert least <= row["clipped"] <= most  # of all samples, half of which are images


def test_noise_that_is_mirrored_teaches_as_samples_do():
    learner = a_mirrored_learner(mirrored="noise")
    for _ in range(30):
        row = learner.iterate()
    assert row["reward"] > 0.75  # of at most 1


def test_a_policy_becomes_its_own_mirror_image_as_far_as_that_weighs():
    free, even = a_mirrored_learner(mirrored="noise"), a_mirrored_learner(mirror_weight=1.0)
    assert asymmetry_of(free) == asymmetry_of(even) > 0.7
    for _ in range(8):
        free.iterate()
        even.iterate()
    assert asymmetry_of(even) < 0.5 * asymmetry_of(free)


def test_what_a_normalizer_made_normal_is_what_it_was_again():
    normalizer, values = Normalizer(3), torch.randn(50, 3) * torch.tensor([0.1, 1.0, 30.0]) + 2.0
    normalizer.see(values)
    torch.testing.assert_close(normalizer.usual(normalizer(values)), values)


def test_a_restored_learner_goes_on_as_the_one_that_was_kept():
    learner = a_learner()
    for _ in range(3):
        learner.iterate()
    state = {name: array.copy() for name, array in learner.state().items()}
    wanted = [learner.iterate() for _ in range(3)]
    other = a_learner()
    other.restore(state)
    assert [other.iterate() for _ in range(3)] == wanted
    np.testing.assert_array_equal(other.state()["values"], learner.state()["values"])


def test_what_is_kept_is_the_mean_of_the_weights_over_the_last_decisions():
    sizes = {"instances": 8, "steps": 8, "minibatches": 2, "hidden": (8,)}
    learner, alone = (Learner(PointMasses(8), options_of(sizes | more), 1) for more in ({"mean_decisions": 160}, {}))
    begun = learner.policy()
    np.testing.assert_array_equal(begun.layers[0].weight, alone.policy().layers[0].weight)
    mean = None
    for k in range(1, 7):  # the mean of the first two; later it forgets with 160 decisions, of which an update has 64
        assert learner.iterate() == alone.iterate()  # learning goes on from the last weights
        now = [part for table in (alone.policy(), alone.critic()) for part in weights(table)]
        share = max(1.0 / k, 1.0 - np.exp(-64.0 / 160.0))
        mean = now if mean is None else [one + share * (new - one) for one, new in zip(mean, now, strict=True)]
    kept = [part for table in (learner.policy(), learner.critic()) for part in weights(table)]
    for one, wanted, last in zip(kept, mean, now, strict=True):
        np.testing.assert_allclose(one, wanted, rtol=1e-4, atol=1e-6)
        assert np.abs(one - last).max() > 1e-5
    other = Learner(PointMasses(8), learner.options, 1)
    other.restore({name: array.copy() for name, array in learner.state().items()})
    for one in (learner, other):
        one.iterate()
    for one, wanted in zip(weights(other.policy()), weights(learner.policy()), strict=True):
        np.testing.assert_array_equal(one, wanted)


def weights(table):
    """Arrays of a policy's file that are learnt by gradients or by what was seen, but for deviations."""
    return [table.mean, *(part for layer in table.layers for part in (layer.weight, layer.bias))]


@pytest.mark.parametrize("damage", ["missing", "shape", "not a number", "random"])
def test_a_damaged_state_is_refused(damage):
    learner = a_learner()
    state = learner.state()
    if damage == "missing":
        del state["first"]
    elif damage == "shape":
        state["first"] = state["first"][:-1]
    elif damage == "not a number":
        state["values"][3] = np.nan
    else:
        state["random"] = state["random"][:5]
    with pytest.raises(ValueError, match="state/"):
        learner.restore(state)


def test_the_policy_of_a_file_acts_as_the_network_that_learnt():
    learner = a_learner()
    learner.iterate()
    observation = torch.randn(10, 2)
    with torch.no_grad():
        wanted = learner.networks.act(observation).numpy()
    np.testing.assert_allclose(actions_of(learner.policy(), observation.numpy()), wanted, rtol=1e-4, atol=1e-5)


def test_options_are_checked_in_one_line():
    assert options_of(parsed(["epochs=5", "hidden=[64, 32]", "discount=0.98"])).hidden == (64, 32)
    for texts, message in (
        (["epochs"], "write KEY=VALUE"),
        (["epochs=five"], "write KEY=VALUE"),
        (["epoch=5"], "no option 'epoch' of a training; did you mean"),
        (["epochs=0"], ">= 1"),
        (["discount=1.5"], "<= 1.0"),
        (["epochs=2.5"], "epochs"),
        (["hidden=[]"], "hidden"),
        (["instances=1", "steps=2", "minibatches=4"], "too few for 4 minibatches"),
        (["learning_rate=1.0"], "between min_learning_rate"),
        (["deviation=0.01"], "min_deviation"),
    ):
        with pytest.raises(Error, match=message) as caught:
            options_of(parsed(texts))
        assert "\n" not in str(caught.value)


def test_what_was_always_the_same_does_not_count_in_what_is_learnt():
    learner = a_learner()
    learner.networks.observed.variance.copy_(torch.tensor([2.0, 0.0]))
    policy = learner.policy()
    one, other = (actions_of(policy, np.array([[0.3, value]], dtype=np.float32)) for value in (0.0, 5.0))
    np.testing.assert_allclose(one, other, atol=1e-6)
    assert policy.deviation[0] == pytest.approx(np.sqrt(2.0), rel=1e-5)


def test_a_policy_plays_what_its_noise_comes_to_where_actions_are_clipped():
    options = PPOOptions(instances=8, steps=8, minibatches=2, hidden=(8,))
    learner = Learner(PointMasses(8), options, 1)
    learner.iterate()
    noise = learner.policy().noise
    assert noise is not None
    assert (noise.low, noise.high) == (-3.0, 3.0)
    np.testing.assert_allclose(noise.deviation, np.exp(learner.networks.log_deviation.detach().numpy()), rtol=1e-6)
    seen = np.random.default_rng(1).normal(size=(20, 2)).astype(np.float32)
    means = learner.networks.act(torch.tensor(seen)).detach().numpy()
    drawn = means + noise.deviation * np.random.default_rng(2).normal(size=(100_000, 1, 1))
    np.testing.assert_allclose(actions_of(learner.policy(), seen), drawn.clip(-3.0, 3.0).mean(0), atol=0.01)
    assert Learner(PointMasses(8), options_of({"expected_action": False}), 1).policy().noise is None


def test_noise_is_held_for_a_while_falls_from_then_on_and_is_free_to_fall_further():
    sizes = {"instances": 8, "steps": 8, "minibatches": 2, "hidden": (8,), "learning_rate": 5e-3}
    held = {"deviation": 0.5, "held_deviation": 0.4, "held_decisions": 4 * 64, "entropy_weight": 0.0}
    bound = {"end_deviation": 0.1, "end_decisions": 8 * 64}
    whole = Learner(PointMasses(8), options_of(sizes | held | bound), 1)
    told = [whole.iterate()["deviation"] for _ in range(9)]
    assert all(0.4 - 1e-6 <= one <= 0.5 + 1e-6 for one in told[:3])
    bounds = 0.5 * 0.2 ** (np.array([1, 2, 3, 4, 4]) / 4.0)  # from there; an update may go below
    assert (told[4:] <= bounds * (1.0 + 1e-6)).all()
    np.testing.assert_allclose(told[4:], bounds, rtol=0.06)
    options = options_of(sizes | held | bound)
    assert np.exp([options.min_log_deviation(k) for k in (0, 3, 4, 9)]) == pytest.approx([0.4, 0.4, 0.05, 0.05])
    for wrong in (0.6, 0.01):
        with pytest.raises(Error, match="held_deviation must lie between"):
            options_of({"held_deviation": wrong})
    with pytest.raises(Error, match="held_decisions must be less than end_decisions"):
        options_of({"held_deviation": 0.3, "end_deviation": 0.1, "held_decisions": 9, "end_decisions": 9})


def test_muscles_that_do_nothing_for_the_reward_relax_and_those_that_do_something_go_on():
    class Muscles(PointMasses):
        """Of three muscles the first pushes the point; all are weighed, the third as nothing."""

        def __init__(self) -> None:
            super().__init__(64)
            self.num_actions, self.action_names, self.action_range = 3, ("push", "idle", "light"), (-0.5, 1.5)
            self.muscle_shares = torch.tensor([0.3, 0.7, 0.0])

        def step(self, actions):
            pushed = actions[:, 0].clamp(-0.5, 1.5) - 0.5  # held in the middle, it does not move
            return super().step(3.0 * pushed[:, None])

    def excitations(weight: float) -> np.ndarray:
        """Of the three muscles, in the mean over places, after some iterations."""
        sizes = {"instances": 64, "minibatches": 2, "hidden": (16,), "effort_weight": weight, "deviation": 0.3}
        learner = Learner(Muscles(), options_of(sizes), 1)
        for _ in range(25):
            learner.iterate()
        seen = torch.randn(200, 2, generator=torch.Generator().manual_seed(1))
        return (learner.networks.act(seen).detach().numpy() + 0.5).clip(0.0, 2.0).mean(axis=0) / 2.0

    free, weighed = excitations(0.0), excitations(10.0)
    assert weighed[1] < 0.3 * free[1]
    assert abs(weighed[2] - free[2]) < 0.1
    assert weighed[0] > 2.0 * weighed[1]


def test_what_effort_is_follows_from_what_actions_excite():
    effort = Effort(torch.tensor([0.25, 0.75]), -1.0, 3.0)
    mean = torch.tensor([[1.0, 5.0], [-2.0, 0.0]])
    expected = np.mean([0.25 * 0.5**2 + 0.75, 0.75 * 0.25**2])
    assert float(effort.of(mean)) == pytest.approx(expected)
    with pytest.raises(RolloutError, match="effort_weight is for policies whose actions are the excitations"):
        Learner(PointMasses(8), options_of({"effort_weight": 1.0}), 1)


def test_noise_that_would_fall_is_kept_by_its_floor():
    options = {"instances": 8, "steps": 8, "minibatches": 2, "hidden": (8,), "min_deviation": 0.05}
    learner = Learner(PointMasses(8), options_of(options | {"held_deviation": 0.3, "held_decisions": 3 * 64}), 1)
    for low, iterations in ((0.3, 2), (0.05, 1)):
        for _ in range(iterations):
            with torch.no_grad():
                learner.networks.log_deviation.fill_(-5.0)
            row = learner.iterate()
            assert low * (1.0 - 1e-6) <= row["deviation"] <= 1.03 * low
            assert row["divergence"] < 0.1  # actions were drawn with it; from noise of exp(-5) it would be nats


def test_noise_falls_evenly_to_its_end_and_goes_on_falling_after_a_kill():
    options = options_of(
        {"instances": 8, "steps": 8, "minibatches": 2, "hidden": (8,), "end_deviation": 0.1, "end_decisions": 6 * 64}
    )
    whole, told = Learner(PointMasses(8), options, 1), []
    for _ in range(3):
        told.append(whole.iterate()["deviation"])
    again = Learner(PointMasses(8), options, 1)
    again.restore(whole.state())
    for _ in range(5):
        told.append(whole.iterate()["deviation"])
    bounds = 0.5 * 0.2 ** np.minimum(np.arange(1, 9) / 6.0, 1.0)
    assert (told <= bounds * (1.0 + 1e-6)).all()
    np.testing.assert_allclose(told, bounds, rtol=0.05)
    np.testing.assert_array_equal([again.iterate()["deviation"] for _ in range(5)], told[3:])
    for wrong in (0.6, 0.01):
        with pytest.raises(Error, match="end_deviation must lie between"):
            options_of({"end_deviation": wrong})
