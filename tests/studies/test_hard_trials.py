"""Trials of a judgement that are harder than its old ones: what is asked for, and how answers are counted."""

import dataclasses

import numpy as np
import pytest

from small_result import march, with_arrays
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gait.cycles import strides
from warpmuscle.gait.quality import ACTIVE, VARIABILITY
from warpmuscle.scene import Command
from warpmuscle.studies import hard_trials
from warpmuscle.studies.hard_trials import (
    NERVES,
    all_at_once,
    commands_met,
    conditions_at_once,
    of_measures,
    pushed_aside,
    run,
    strengths_of_sides,
    stride_to_push,
    variability,
)
from warpmuscle.studies.verdicts import AT_RUNNING, FURTHER_RUN, FURTHER_WALK, RUN, WALK, Finding
from warpmuscle.studies.walkers import SceneWalker, Walker, Walks


class Scripted(Walker):
    """Walks as commanded, whatever disturbs it; falls where a test says so."""

    senses = True

    def __init__(self, commands=None, falls=lambda walker, disturbances, commands: False, turn=1.0) -> None:
        self._scene, self.commands, self._turn = SceneWalker(load("fwalk")).scene(), commands or {}, turn
        self.falls, self.nerves, self.asked = falls, None, []

    def scene(self, commands=None):
        return self._scene

    def with_nerves(self, nerves):
        other = super().with_nerves(nerves)
        other.nerves = nerves
        return other

    def _walked(self, scene, disturbances, commands, recorded):
        n = len(disturbances)
        self.asked.append((scene, disturbances, commands))
        fell = np.broadcast_to(self.falls(self, disturbances, commands), n)
        motions = []
        for k in recorded:
            motion = march(scene.character, float(commands.get("speed", np.full(n, 1.1))[k]), 4.0, 401)
            rate = self._turn * float(commands.get("turning_rate", np.zeros(n))[k])
            course = rate * motion.time
            speed = np.full(401, float(commands.get("speed", np.full(n, 1.1))[k]))
            half = 0.5 * course
            turned = np.stack([0.0 * half, np.sin(half), 0.0 * half, np.cos(half)], axis=1)
            moving = np.stack([speed * np.sin(course), 0.0 * speed, speed * np.cos(course)], axis=1)
            motions.append(with_arrays(motion, root_orientation=turned, com_velocity=moving))
        status = np.where(fell, int(Status.FELL), int(Status.COMPLETED))
        return Walks(status, np.full(n, scene.duration), motions)


def test_everything_at_once_is_as_hard_as_it_says():
    scene = load("walk56_person")
    runs = conditions_at_once(SceneWalker(scene))
    assert len(runs) == 20
    assert 0.15 < runs.velocity.std() < 0.25
    assert not runs.push.any()
    for factors in (runs.mass, runs.strength):
        assert 0.8 <= factors.min() < 0.83
        assert 1.17 < factors.max() <= 1.2
    slopes = np.degrees(runs.slope)
    assert -6.0 <= slopes.min() < -4.0
    assert 4.0 < slopes.max() <= 6.0


def test_each_side_is_stronger_or_weaker_by_itself():
    scene = load("gait2392_walk")
    names = list(scene.character.muscles)
    factors = strengths_of_sides(names, 0.2)
    left, right = ([k for k, name in enumerate(names) if name.endswith(end)] for end in ("_l", "_r"))
    assert len(left) == len(right) == 46
    for side in (left, right):
        np.testing.assert_array_equal(factors[:, side], factors[:, side[:1]].repeat(46, axis=1))
    assert np.abs(factors[:, left[0]] - factors[:, right[0]]).min() > 0.0
    assert strengths_of_sides([], 0.2) is None


def test_all_at_once_slips_and_is_late_and_the_note_says_how_it_does_otherwise():
    walker = Scripted(falls=lambda walker, *_: np.arange(20) < (5 if walker.nerves else 2))
    found = all_at_once(walker, 1.0)
    assert (found.value, found.note) == (15.0, "18 without delays and noise of nerves")
    assert [scene.ground.friction for scene, *_ in walker.asked] == [0.4, 0.4]


def test_pushes_come_from_both_sides_at_ten_phases_of_a_stride():
    plain = march(load("fwalk").character, 1.1, 8.0, 801)
    walker = Scripted(falls=lambda _, disturbances, __: (disturbances.push[:, 0] > 0) & (disturbances.push_start > 6.5))
    begin, length = stride_to_push(plain, walker.scene())
    assert (begin, begin + length) == strides(plain, "left", 5.0)[0]
    found = pushed_aside(walker, plain)
    ((_, asked, _),) = walker.asked
    np.testing.assert_array_equal(asked.push[:, 0], [80.0, -80.0] * 10)
    assert not asked.push[:, 1:].any()
    phases = (asked.push_start - begin) / length
    np.testing.assert_allclose(phases, np.repeat(np.arange(10) / 10.0, 2), atol=1e-9)
    assert walker.asked[0][0].duration == pytest.approx(asked.push_start.max() + 4.0)
    late = int(np.sum(asked.push_start[::2] > 6.5))
    assert 0 < late < 10
    assert found.value == 20.0 - late
    assert found.note == f"falls when pushed to the left at {', '.join(f'{10 * k}' for k in range(10 - late, 10))} %"


def test_who_falls_at_every_phase_is_told_in_few_words():
    plain = march(load("fwalk").character, 1.1, 8.0, 801)
    found = pushed_aside(Scripted(falls=lambda _, disturbances, __: disturbances.push[:, 0] < 0), plain)
    assert (found.value, found.note) == (10.0, "falls when pushed to the right at any phase")


def test_who_takes_no_strides_is_pushed_all_the_same():
    still = march(load("fwalk").character, 1.1, 0.2, 21)
    assert stride_to_push(still, SceneWalker(load("fwalk")).scene()) == (5.0, 1.1)


SPEED, TURNING = Command(1.2, 0.8, 1.6, unit="m/s"), Command(0.0, -0.3, 0.3, unit="rad/s")


def test_commands_that_are_followed_are_met():
    walker = Scripted({"speed": SPEED, "turning_rate": TURNING})
    assert commands_met(walker, 4.0) == (20.0, "", False, True)
    assert len(walker.asked) == 3
    for _, disturbances, told in walker.asked:
        assert all(low <= told[name].min() < told[name].max() <= high
                   for name, low, high in (("speed", 0.8, 1.6), ("turning_rate", -0.3, 0.3)))  # fmt: skip
        assert 0.0 < disturbances.velocity.std() < 0.1
    assert commands_met(Scripted(), 4.0) == (None, "takes no command", False, True)


def test_who_turns_too_little_or_falls_once_misses_a_command():
    lazy = commands_met(Scripted({"turning_rate": TURNING}, turn=0.0), 4.0)
    rates = np.random.default_rng(hard_trials.SEED).uniform(-0.3, 0.3, 20)
    assert lazy.value == np.sum(np.abs(np.degrees(rates * 4.0)) <= 15.0)
    assert "degrees off" in lazy.note
    calls = iter(range(3))
    falling = Scripted({"speed": SPEED}, falls=lambda *_: np.arange(20) == next(calls))
    assert commands_met(falling, 4.0).value == 17.0
    slow = Scripted({"speed": SPEED})
    slow.commands = {"speed": SPEED}
    told = hard_trials._off(march(load("fwalk").character, 1.1, 4.0, 401), {"speed": 1.5})
    assert told.endswith("m/s")


def test_who_takes_no_such_speed_does_not_run_and_a_run_tells_its_own():
    found = run(Scripted({"speed": SPEED}), 4.0, {"flight": 0.0})
    assert {(one.value, one.note) for one in found.values()} == {(None, "takes no such speed")}
    own = {"flight": 13.0, "speed": 2.5, "maximum vertical force": 1.9, "knee, maximum in swing": 74.0}
    found = run(Scripted(), 4.0, own)
    assert [one.value for one in found.values()] == [13.0, 1.9, 74.0]
    assert not any(one.judges for one in found.values())
    assert found[next(iter(AT_RUNNING))].note == "takes no such speed; this is at 2.50 m/s"


def test_a_run_at_that_speed_is_measured_or_falls():
    fast = Command(3.0, 0.8, 5.0, unit="m/s")
    walker = Scripted({"speed": fast})
    found = run(walker, 4.0, {})
    assert list(found) == list(AT_RUNNING)
    assert all(one.note == "at 3.50 m/s" for one in found.values())
    assert walker.asked[0][2]["speed"].tolist() == [3.5]
    fell = run(Scripted({"speed": fast}, falls=lambda *_: True), 4.0, {})
    assert {(one.value, one.note, one.failed) for one in fell.values()} == {(None, "falls", True)}


@pytest.mark.parametrize(("share", "missed"), [(0.92, False), (0.88, True), (1.12, True)])
def test_who_comes_to_another_speed_has_not_run_at_that_one(share: float, missed: bool):
    class Slow(Scripted):
        def _walked(self, scene, disturbances, commands, recorded):
            return super()._walked(scene, disturbances, {"speed": share * commands["speed"]}, recorded)

    found = run(Slow({"speed": Command(3.0, 0.8, 5.0, unit="m/s")}), 4.0, {})
    assert {one.failed for one in found.values()} == {missed}
    assert all(one.value is None for one in found.values()) or not missed
    assert {one.note for one in found.values()} == {f"at {3.5 * share:.2f} m/s"}


def test_steps_vary_with_noise_of_nerves_where_there_can_be_any():
    walker = Scripted()
    found = variability(walker, 4.0, 1.8)
    assert found.value == pytest.approx(0.0, abs=0.1)
    assert found.note == "1.8 without noise of nerves"
    deaf = SceneWalker(load("fwalk"))
    assert variability(deaf, 4.0, 1.8) == (1.8, "its controller has no noise of nerves", False, False)
    fell = variability(Scripted(falls=lambda *_: True), 4.0, 1.8)
    assert (fell.value, fell.failed) == (None, True)


def test_idle_windows_are_named():
    scene = load("walk56")
    motion = march(scene.character, 1.2, 8.0, 801, len(scene.character.muscles))
    still = dataclasses.replace(motion, muscle_activation=0.0 * motion.muscle_activation + 0.1)
    found = of_measures({ACTIVE: 0.0, "mean activation": 0.1, VARIABILITY: 3.0}, still, scene)
    assert found[ACTIVE].note.startswith("7 muscles; idle: gluteus maximus 96 to 14 %, hip abductors 96 to 41 %")
    assert (found["mean activation"].value, found["mean activation"].judges) == (0.1, False)
    assert found[VARIABILITY].value == 3.0
    assert of_measures({}, still, scene) == {}


def test_what_a_body_lacks_is_told_where_it_has_been_measured():
    scene = load("fwalk")
    still = march(scene.character, 1.0, 4.0, 401)
    found = of_measures({"speed": 1.0, "arm swing, range": 20.0}, still, scene)
    assert found["arm swing, range"].value == 20.0
    assert found["gastrocnemius in swing, of stance"] == Finding(None, "no gastrocnemius")
    assert of_measures({"speed": 1.0}, still, scene)["arm swing, range"] == Finding(None, "no arms")


def test_rows_besides_are_no_rows_of_the_table_that_stays():
    for old, further in ((WALK, FURTHER_WALK), (RUN, FURTHER_RUN)):
        assert not {bar.name for bar in old} & {bar.name for bar in further}
        assert {bar.name for bar in further} >= {"upright, all at once", "commands met", *AT_RUNNING}
    assert NERVES.delay == 0.02  # Geyer, Herr 2010, of the ankle
