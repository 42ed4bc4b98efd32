"""Episodes: where roots are, what is drawn and how clocks, headings and pushes go on."""

import numpy as np
import pytest
import warp as wp
from probes import filled, turn_about

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.learning import episodes as kernels
from warpmuscle.kernels.learning.episodes import EpisodeRules, Episodes
from warpmuscle.kernels.structs import ROOT_FIXED, ROOT_FREE, ROOT_PLANAR, State

N, PUSH, STEPS, TIME_STEP, DECISION = 4000, 12.0, 8, 0.0025, 0.02
LOW, HIGH = (0.5, -0.3, 2.0), (1.5, 0.3, 2.5)
SETTINGS = {
    "turning_share": 1.0,
    "starts": 5, "variants": 3, "command_low": LOW, "command_high": HIGH, "cycle_rate": 0.9, "clock_speed": 1.2,
    "cadence_power": 0.6, "start_phase": (0.1, 0.3, 0.5, 0.7, 0.9), "velocity_noise": 0.2, "push": PUSH,
    "push_decisions": 20, "push_steps": STEPS, "time_step": TIME_STEP, "decision_time": DECISION,
    "command_decisions": 6, "pushed_share": 1.0, "aimed_share": 0.0,
}  # fmt: skip


def begun(root: int, **settings: object) -> tuple[EpisodeRules, Episodes, State, dict[str, np.ndarray]]:
    """Rules, and episodes and states of random numbers."""
    random = np.random.default_rng(1)
    rules = filled(EpisodeRules, **(SETTINGS | settings), root=root)
    given = {
        "decision": random.integers(0, 90, N), "number": random.integers(0, 9, N), "length": random.integers(0, 30, N),
        "start_row": random.integers(0, 5, N), "variant": np.zeros(N, int), "command": random.uniform(0.1, 2.0, (N, 3)),
        "phase": random.random(N), "heading": random.normal(size=N), "side": random.normal(size=N),
        "next_push": random.integers(0, 90, N), "hardness": np.ones(N), "mask": np.arange(N) % 3 != 0,
        "push_hardness": np.ones((N, kernels.QUARTERS)), "pushed": np.full(N, kernels.NOT_YET),
    }  # fmt: skip
    places = {name: np.full((N, 3), 7.0) for name in ("place", "start_place")}
    episodes = filled(Episodes, **given, **places, seed=[11], start_step=np.zeros(N))
    numbers = {"coordinates": random.normal(size=(N, 8)), "speeds": random.normal(size=(N, 7))}
    numbers["coordinates"][:, 3:7] /= np.linalg.norm(numbers["coordinates"][:, 3:7], axis=1, keepdims=True)
    pushes = {"push": np.full((N, 3), 5.0), "push_steps": np.full((N, 2), 3), "step": random.integers(0, 900, N)}
    return rules, episodes, filled(State, **numbers, **pushes), given | numbers | pushes


def place_and_yaw(root: int, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place of the root, and how it is turned about the vertical."""
    if root == ROOT_FREE:
        return q[:, :3], (2.0 * np.arctan2(q[:, 4], q[:, 6]) + np.pi) % (2.0 * np.pi) - np.pi
    yaw = np.where(np.abs((q[:, 2] + np.pi) % (2.0 * np.pi) - np.pi) < np.pi, 0.0, np.pi)
    return (np.insert(q[:, :2], 0, 0.0, axis=1) if root == ROOT_PLANAR else np.zeros((N, 3))), yaw


@wp.kernel(enable_backward=False)
def roots(root: int, state: State, place: wp.array[wp.vec3], orientation: wp.array[wp.quat]):
    i = wp.tid()
    place[i] = kernels.root_place(root, i, state)
    orientation[i] = kernels.root_orientation(root, i, state)


@pytest.mark.parametrize("root", [ROOT_FREE, ROOT_PLANAR, ROOT_FIXED])
def test_a_root_is_where_its_coordinates_say(root: int):
    _, _, state, given = begun(root)
    place, turn = wp.zeros(N, dtype=wp.vec3, device="cpu"), wp.zeros(N, dtype=wp.quat, device="cpu")
    wp.launch(roots, N, [root, state, place, turn], device="cpu")
    q = given["coordinates"]
    angle = q[:, 2] if root == ROOT_PLANAR else np.zeros(N)
    expected = q[:, 3:7] if root == ROOT_FREE else turn_about(np.array([1.0, 0.0, 0.0]), angle)
    np.testing.assert_allclose(place.numpy(), place_and_yaw(root, q)[0], atol=1e-6)
    np.testing.assert_allclose(turn.numpy(), expected, atol=1e-6)


def test_decisions_move_clock_and_heading_and_draw_commands_and_pushes_when_they_are_due():
    rules, episodes, state, before = begun(ROOT_FREE)
    wp.launch(kernels.begin_decision, N, [rules, episodes, state], device="cpu")
    decision = before["decision"] + 1
    np.testing.assert_array_equal(episodes.decision.numpy(), decision)
    np.testing.assert_array_equal(episodes.length.numpy(), before["length"] + 1)
    np.testing.assert_allclose(episodes.place.numpy(), before["coordinates"][:, :3], atol=1e-6)
    drawn = (before["length"] > 0) & (before["length"] % 6 == 0)
    command = episodes.command.numpy().astype(float)
    np.testing.assert_array_equal(command[~drawn], np.float32(before["command"])[~drawn])
    assert 0.1 < drawn.mean() < 0.2
    for k, (low, high) in enumerate(zip(LOW, HIGH, strict=True)):
        assert command[drawn, k].min() == pytest.approx(low, abs=0.01 * (high - low))
        assert command[drawn, k].max() == pytest.approx(high, abs=0.01 * (high - low))
        assert command[drawn, k].mean() == pytest.approx(0.5 * (low + high), abs=0.06 * (high - low))
    np.testing.assert_allclose(episodes.heading.numpy(), before["heading"] + DECISION * command[:, 1], atol=1e-5)
    rate = 0.9 * np.maximum(command[:, 0] / 1.2, 0.1) ** 0.6
    away = episodes.phase.numpy() - before["phase"] - DECISION * rate
    np.testing.assert_allclose(away - np.round(away), 0.0, atol=1e-5)
    assert episodes.phase.numpy().max() < 1.0
    pushed = decision >= before["next_push"]
    np.testing.assert_array_equal(state.push.numpy()[~pushed], 5.0)
    np.testing.assert_array_equal(state.push_steps.numpy()[~pushed], 3)
    np.testing.assert_array_equal(episodes.next_push.numpy()[~pushed], before["next_push"][~pushed])
    push, steps = state.push.numpy()[pushed], state.push_steps.numpy()[pushed]
    np.testing.assert_array_equal(steps, before["step"][pushed, None] + [0, STEPS])
    impulse = np.linalg.norm(push, axis=1) * STEPS * TIME_STEP
    assert impulse.max() == pytest.approx(PUSH, rel=0.01)
    assert impulse.mean() == pytest.approx(0.5 * PUSH, rel=0.05)
    np.testing.assert_array_equal(push[:, 1], 0.0)
    turns = np.arctan2(push[:, 0], push[:, 2])
    assert np.histogram(turns, 4, (-np.pi, np.pi))[0].min() > 0.2 * len(turns)
    wait = episodes.next_push.numpy()[pushed] - decision[pushed]
    assert wait.min() == 10
    assert wait.max() == 29
    assert wait.mean() == pytest.approx(19.5, rel=0.03)


@wp.kernel(enable_backward=False)
def aims(angle: float, episodes: Episodes, rules: EpisodeRules, aim: wp.array[wp.vec2]):
    i = wp.tid()
    aim[i] = kernels.aim_of(i, 7, angle, episodes, rules)


@pytest.mark.parametrize("mirrored", [0, 1])
def test_aimed_pushes_have_phases_and_directions_between_bounds_or_those_of_the_other_side(mirrored: int):
    bounds = {"push_phase": (0.9, 1.1), "push_angle": (-0.2, 0.4)}
    rules, episodes, *_ = begun(ROOT_FREE, aimed_share=0.7, push_mirrored=mirrored, **bounds)
    found = wp.zeros(N, dtype=wp.vec2, device="cpu")
    wp.launch(aims, N, [2.5, episodes, rules, found], device="cpu")
    phase, angle = found.numpy().T.astype(float)
    aimed = phase >= 0.0
    np.testing.assert_allclose(angle[~aimed], 2.5)
    assert aimed.mean() == pytest.approx(0.7, abs=0.03)
    assert phase.max() < 1.0
    assert angle.min() >= 0.0
    assert angle.max() <= 2.0 * np.pi
    phase, angle = phase[aimed], (angle[aimed] + np.pi) % (2.0 * np.pi) - np.pi
    other = (phase > 0.25) & (phase < 0.75)  # the cycle's other half
    assert other.mean() == pytest.approx(0.5 * mirrored, abs=0.03)
    for half, centre, sign in ((~other, 0.0, 1.0), (other, 0.5, -1.0)):
        if half.any():
            away = (phase[half] - centre + 0.5) % 1.0 - 0.5
            np.testing.assert_allclose(np.quantile(away, (0.0, 0.5, 1.0)), (-0.1, 0.0, 0.1), atol=0.01)
            np.testing.assert_allclose(np.quantile(sign * angle[half], (0.0, 0.5, 1.0)), (-0.2, 0.1, 0.4), atol=0.03)


def test_an_aimed_push_waits_for_its_phase_and_goes_to_its_side_of_the_wanted_heading():
    """Of each instance as many decisions as a cycle has: the clock passes every phase once."""
    aim = {"aimed_share": 1.0, "push_phase": (0.3, 0.4), "push_angle": (1.4, 1.6), "push_from_heading": 1}
    rules, episodes, state, _ = begun(ROOT_FREE, push_least=1.0, cadence_power=0.0, command_decisions=0, **aim)
    rules.push_decisions = 1000  # that none comes twice
    episodes.next_push.zero_()
    moved, came = 0.9 * DECISION, np.zeros(N)
    for _ in range(round(1.0 / moved)):
        waiting = episodes.next_push.numpy() == 0
        wp.launch(kernels.begin_decision, N, [rules, episodes, state], device="cpu")
        now = waiting & (episodes.next_push.numpy() > 0)
        came += now
        phase, push = episodes.phase.numpy()[now], state.push.numpy()[now]
        assert ((phase >= 0.3 - 1e-5) & (phase <= 0.4 + moved)).all()
        angle = np.arctan2(push[:, 0], push[:, 2]) - episodes.heading.numpy()[now] - 1.5
        np.testing.assert_allclose((angle + np.pi) % (2.0 * np.pi) - np.pi, 0.0, atol=0.1 + 1e-5)
        np.testing.assert_array_equal(state.push_steps.numpy()[now, 0], state.step.numpy()[now])
    assert came.max() == 1
    assert came.mean() > 0.98


def test_pushes_come_in_a_share_of_the_episodes_alone_and_in_all_or_none_of_one():
    shown = []
    for share in (0.0, 0.3, 1.0):
        rules, episodes, state, _ = begun(ROOT_FREE, pushed_share=share)
        waits = []
        for later in (0, 1000):  # the same episodes, twice
            episodes.decision.fill_(later)
            episodes.next_push.zero_()
            state.push.fill_(wp.vec3(5.0))
            wp.launch(kernels.begin_decision, N, [rules, episodes, state], device="cpu")
            shown.append((state.push.numpy() != 5.0).any(axis=1))
            waits.append(episodes.next_push.numpy() - later)
        np.testing.assert_array_equal(shown[-2], shown[-1])
        assert min(map(np.min, waits)) > 10  # all wait for the next one, pushed or not
        assert shown[-1].mean() == pytest.approx(share, abs=0.03)
    assert shown[-1][shown[-3]].all()


def test_a_clock_without_a_power_goes_at_its_rate_and_commands_may_stay():
    rules, episodes, state, before = begun(ROOT_FREE, cadence_power=0.0, command_decisions=0, push_decisions=0)
    wp.launch(kernels.begin_decision, N, [rules, episodes, state], device="cpu")
    away = episodes.phase.numpy() - before["phase"] - DECISION * 0.9
    np.testing.assert_allclose(away - np.round(away), 0.0, atol=1e-5)
    np.testing.assert_array_equal(episodes.command.numpy(), np.float32(before["command"]))
    np.testing.assert_array_equal(state.push.numpy(), 5.0)


def test_from_a_wanted_speed_on_the_clock_is_that_of_the_run():
    run = {"run_from": 1.1, "run_rate": 1.4, "run_speed": 2.5, "run_power": 0.3}
    rules, episodes, state, before = begun(ROOT_FREE, command_decisions=0, **run)
    before["command"][::500, 0] = 1.1
    episodes.command.assign(np.float32(before["command"]))
    wp.launch(kernels.begin_decision, N, [rules, episodes, state], device="cpu")
    speed = before["command"][:, 0]
    walk = 0.9 * np.maximum(speed / 1.2, 0.1) ** 0.6
    rate = np.where(speed >= 1.1, 1.4 * (speed / 2.5) ** 0.3, walk)
    away = episodes.phase.numpy() - before["phase"] - DECISION * rate
    np.testing.assert_allclose(away - np.round(away), 0.0, atol=1e-5)


@pytest.mark.parametrize("every", [0, 1, 2, 20])
def test_the_first_push_of_an_episode_comes_within_half_to_three_halves_of_the_mean_wait(every: int):
    rules, episodes, state, before = begun(ROOT_FREE, push_decisions=every)
    wp.launch(kernels.begin_episodes, N, [rules, episodes, state], device="cpu")
    mask = before["mask"]
    wait = episodes.next_push.numpy() - np.where(mask & (every > 0), before["decision"], before["next_push"])
    np.testing.assert_array_equal(wait[~mask | (every == 0)], 0)
    if every:
        expected = np.maximum(np.arange(every // 2, (3 * every + 1) // 2), 1)  # whole decisions, at least one
        np.testing.assert_array_equal(np.unique(wait[mask]), np.unique(expected))


@pytest.mark.parametrize("side_by_side", [0, 1])
@pytest.mark.parametrize("lanes", [1, 3])
def test_instances_that_begin_get_the_rows_that_were_drawn_and_others_keep_theirs(side_by_side: int, lanes: int):
    """Arrays (instances, elements, size), or (elements, instances, size) if neighbours lie side by side."""
    random, shape = np.random.default_rng(3), (5, 4, 3)
    source = random.integers(0, 1000, (2, 12)).astype(np.int32)
    before = random.integers(0, 1000, shape).astype(np.int32)
    mask, row = np.array([True, False, True, True, False]), np.array([0, 1, 1, 0, 0], np.int32)
    given = before.swapaxes(0, 1) if side_by_side else before
    target, rows = (wp.array(np.ascontiguousarray(a), dtype=int, device="cpu") for a in (given, source))
    entry = {"target": [target.ptr], "source": [rows.ptr], "words": [12], "size": [3], "side_by_side": [side_by_side]}
    arrays = structs_to_device(kernels.RestoredArray, {k: np.array(v) for k, v in entry.items()}, "cpu")
    chosen = [wp.array(mask, dtype=bool, device="cpu"), wp.array(row, dtype=int, device="cpu")]
    wp.launch(kernels.restore_rows, (5, lanes), [*chosen, arrays, 2, lanes], device="cpu")
    found = target.numpy().swapaxes(0, 1) if side_by_side else target.numpy()
    expected = np.where(mask[:, None], source[row], before.reshape(5, 12)).reshape(shape)
    np.testing.assert_array_equal(found, expected)


def test_starts_and_variants_are_drawn_evenly_for_episodes_that_begin():
    rules, episodes, _, before = begun(ROOT_FREE)
    wp.launch(kernels.draw_starts, N, [rules, episodes], device="cpu")
    mask = before["mask"]
    np.testing.assert_array_equal(episodes.number.numpy(), before["number"] + mask)
    np.testing.assert_array_equal(episodes.length.numpy(), np.where(mask, 0, before["length"]))
    np.testing.assert_array_equal(episodes.start_row.numpy()[~mask], before["start_row"][~mask])
    for name, count in (("start_row", 5), ("variant", 3)):
        share = np.bincount(getattr(episodes, name).numpy()[mask], minlength=count) / mask.sum()
        np.testing.assert_allclose(share, 1.0 / count, atol=0.03)
    both = episodes.start_row.numpy()[mask], episodes.variant.numpy()[mask]
    assert abs(np.corrcoef(*both)[0, 1]) < 0.1


@pytest.mark.parametrize("root", [ROOT_FREE, ROOT_PLANAR, ROOT_FIXED])
def test_an_episode_begins_where_its_start_stands_with_noise_of_the_roots_velocity(root: int):
    rules, episodes, state, before = begun(root)
    wp.launch(kernels.begin_episodes, N, [rules, episodes, state], device="cpu")
    mask = before["mask"]
    place, _ = place_and_yaw(root, before["coordinates"])
    for name in ("place", "start_place"):
        np.testing.assert_allclose(getattr(episodes, name).numpy()[mask], place[mask], atol=1e-6)
        np.testing.assert_array_equal(getattr(episodes, name).numpy()[~mask], 7.0)
    np.testing.assert_array_equal(episodes.start_step.numpy(), np.where(mask, before["step"], 0))
    np.testing.assert_array_equal(episodes.side.numpy()[mask], 0.0)
    np.testing.assert_allclose(episodes.phase.numpy()[mask], (0.1 + 0.2 * before["start_row"])[mask], atol=1e-6)
    np.testing.assert_array_equal(state.push.numpy()[mask], 0.0)
    np.testing.assert_array_equal(state.push_steps.numpy()[mask], 0)
    noise = state.speeds.numpy() - before["speeds"]
    np.testing.assert_allclose(noise[~mask], 0.0, atol=1e-6)
    moving = {ROOT_FREE: 3, ROOT_PLANAR: 2, ROOT_FIXED: 0}[root]
    np.testing.assert_allclose(noise[mask, :moving].std(axis=0), 0.2, rtol=0.05)
    np.testing.assert_allclose(noise[:, moving:], 0.0, atol=1e-6)
    if root == ROOT_FREE:
        away = episodes.heading.numpy() - place_and_yaw(root, before["coordinates"])[1]
        np.testing.assert_allclose(np.sin(0.5 * away[mask]), 0.0, atol=1e-4)
    wait = (episodes.next_push.numpy() - before["decision"])[mask]
    assert wait.min() == 10
    assert wait.max() == 29
    command = episodes.command.numpy()[mask]
    assert (command >= np.float32(LOW)).all()
    assert (command <= np.float32(HIGH)).all()
