"""The rule from goals to signals of new throws."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error
from warpmuscle.throw import job
from warpmuscle.throw.fit import Settings
from warpmuscle.throw.goals import PAST_LIMITS, fly
from warpmuscle.throw.rules import rule
from warpmuscle.throw.rules.rule import Walk, beyond_learned, goals_about, learned, release_velocity


def test_a_ball_that_leaves_at_the_velocity_of_a_goal_lands_there():
    goals = goals_about(20, 0.0, np.random.default_rng(0))
    place = np.array([0.3, 2.2])
    velocity = release_velocity(goals, place, 9.81)
    for goal, individual in zip(goals, velocity, strict=True):
        flight = fly(place, individual, 9.81, float(goal[1]))
        assert float(flight.distance) == pytest.approx(goal[0], abs=1e-9)
        assert float(flight.angle) == pytest.approx(goal[2], abs=1e-9)


def test_a_rule_gives_back_what_it_learned_and_what_lies_between():
    rng = np.random.default_rng(1)
    goals = goals_about(60, 0.0, rng)
    place = np.array([0.3, 2.2])

    def signals(asked: np.ndarray) -> np.ndarray:
        return release_velocity(asked, place, 9.81) @ np.array([[0.1, -0.2, 0.0], [0.05, 0.1, 0.3]])

    rule = learned(goals, signals(goals), place, 9.81)
    asked = goals_about(20, 0.0, rng)
    np.testing.assert_allclose(rule(asked), signals(asked), atol=0.01)


def test_goals_beyond_those_learned_from_are_named():
    assert beyond_learned(np.array([4.0, 0.0, np.radians(10.0)])) == ""
    text = beyond_learned(np.array([1.0, 0.5, np.radians(45.0)]))
    assert text == "a distance of 1 m, but of 2 to 4 m; an angle of 45 deg, but of 10 to 40 deg"


def near_goals(count: int, beyond: float, rng: np.random.Generator) -> np.ndarray:
    """Goals that few simulations lead to from the middle."""
    return np.array([3.0, 0.5, np.radians(25.0)]) + 0.02 * rng.uniform(-1.0, 1.0, (count, 3))


def throw_rule(folder: Path, *arguments: object) -> Any:
    """What `throw predict` says, with quick fits and goals near the middle."""

    def quick(**given: Any) -> Settings:
        return Settings(common=False, parameter_steps=3, signal_steps=3, starts=1, **given)

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(job, "Settings", quick)
        patch.setattr(rule, "goals_about", near_goals)
        return CliRunner().invoke(
            app, ["throw", "predict", "--between", "2", "--beyond", "1", *map(str, arguments)], standalone_mode=False
        )


def interrupted_after(goals: int, met: Callable[[Walk, Any], bool]) -> Callable[[Walk, Any], bool]:
    """The same, with Ctrl-C in the middle of the goal after so many."""

    def to(walk: Walk, goal: Any) -> bool:
        if len(walk.goals) > goals:
            walk.outcomes(walk.changes[0][None], goal[None])
            raise KeyboardInterrupt
        return met(walk, goal)

    return to


@pytest.mark.parametrize("kept", [0, 1, 2], ids=["before it is kept", "when half is kept", "when all is kept"])
def test_a_goal_during_which_ctrl_c_comes_is_as_if_it_had_not_been_tried(monkeypatch: pytest.MonkeyPatch, kept: int):
    """Else the file of the rule would hold goals that are not told to be met, and be refused."""
    wanted = near_goals(4, 0.0, np.random.default_rng(0))
    walk = Walk(None, [wanted[0]], [np.zeros(2)])  # type: ignore[arg-type]
    begun = rule.Rule(walk, np.zeros(2), 1.0, np.zeros(1), wanted, np.zeros(4, dtype=bool), np.full(4, -1), 0)

    def to(walk: Walk, goal: np.ndarray) -> bool:
        late = len(walk.goals) == 3
        for parts, part in ((walk.goals, goal), (walk.changes, np.ones(2)))[: kept if late else 2]:
            parts.append(part)
        if late:
            raise KeyboardInterrupt
        return True

    monkeypatch.setattr(Walk, "to", to)
    with pytest.raises(KeyboardInterrupt):
        begun.meet()
    assert len(walk.goals) == len(walk.changes) == 1 + begun.met.sum() == 3
    assert begun.tried_from.tolist() == [0, begun.tried_from[1], -1, -1]


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, rule.Rule]:
    """A folder with what a search that was interrupted after 2 of 10 goals left, what it said, and what it had."""
    folder = tmp_path_factory.mktemp("rule")
    begun: list[rule.Rule] = []
    begin = rule.begin

    def remembered(*given: Any) -> rule.Rule:
        begun.append(begin(*given))
        return begun[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Walk, "to", interrupted_after(2, Walk.to))
        patch.setattr(rule, "begin", remembered)
        result = throw_rule(folder, "--goals", 10, "--seed", 3, "-o", "part.h5")
    assert result.return_value == 130, result.exception
    return folder, " ".join(result.output.split()), begun[0]


@pytest.mark.long
def test_an_interrupted_search_keeps_its_goals_and_goes_on_from_the_file_as_if_nothing_had_been(
    interrupted: tuple[Path, str, rule.Rule],
):
    folder, said, whole = interrupted
    assert "done so far: 2 of 10 goals tried, 2 of them met; --resume part.h5 goes on from there" in said
    with h5py.File(folder / "part.h5") as file:
        part, simulations = file["changes"][:], int(file["simulations"][()])
        assert len(part) == 3
        assert file["met"][:].tolist() == 7 * [True] + 3 * [False]
    gone_on = throw_rule(folder, "--resume", "part.h5", "--target", "3", "--target", "7", "-o", "rest.h5")
    assert gone_on.return_value == 0, gone_on.exception
    assert "10 of 10 goals are met" in gone_on.output
    told = " ".join(gone_on.output.split())
    assert told.count("note: the rule has learned nothing of") == 1
    assert "the rule has learned nothing of a distance of 7 m, but of 2 to 4" in told
    whole.meet()
    begun, counted = re.search(r"are met, by (\d+) simulations", told), whole.walk.simulations
    assert begun is not None
    assert int(begun[1]) == counted > simulations > 0
    with h5py.File(folder / "rest.h5") as rest:
        np.testing.assert_array_equal(rest["changes"][:3], part)
        for name in ("wanted", "met", "tried_from", "goals", "changes"):
            np.testing.assert_array_equal(rest[name][()], getattr(whole, name))
        errors = rest["errors/learned_between"][:]
        assert errors.shape == (2, 3)
        assert np.all(errors[:, 0] < 0.05)
        assert np.all(errors[:, 2] <= PAST_LIMITS)


def test_signals_behind_the_release_are_not_searched_for_and_change_no_outcome(
    interrupted: tuple[Path, str, rule.Rule],
):
    learned_of = interrupted[2]
    walk, goal = learned_of.walk, learned_of.wanted[:1]
    assert 0 < np.sum(~walk.acting) < np.sum(walk.acting)
    assert not learned_of.changes[:, ~walk.acting].any()
    usual, _ = walk.outcomes(np.zeros((1, len(walk.acting))), goal)
    behind, _ = walk.outcomes(0.3 * ~walk.acting[None], goal)
    np.testing.assert_array_equal(behind, usual)
    last = np.flatnonzero(walk.acting[: walk.thrower.hats.shape[1]])[-1]  # of the first synergy
    change = np.zeros((2, len(walk.acting)))
    change[1, last :: walk.thrower.hats.shape[1]] = 0.3
    moved = walk.thrower.simulated(walk.signals(change), int(walk.thrower.frames[-1])).speed[:, -1]
    assert np.abs(moved[1] - moved[0]).max() > 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scene", "throw_ball", "-n", "4"], "learned out of another motion, scene or number of synergies"),
        (["--goals", "20"], "leave out --goals and --seed"),
        (["--seed", "1"], "leave out --goals and --seed"),
    ],
)
def test_a_search_goes_on_with_what_it_began_with_alone(
    interrupted: tuple[Path, str, rule.Rule], arguments: list[str], message: str
):
    result = throw_rule(interrupted[0], "--resume", "part.h5", *arguments)
    assert isinstance(result.exception, Error), result.output
    assert message in str(result.exception)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("goals", np.zeros((3, 2))), ("changes", np.full((3, 80), np.nan)), ("changes", np.zeros((3, 7))),
        ("release", 99.0), ("tried_from", np.zeros(3)), ("tried_from", np.full(10, 40)), ("met", np.ones(10)),
        ("simulations", np.zeros(2)), ("simulations", -1), ("known", np.array(["a"], dtype="S1")),
    ],
)  # fmt: skip
def test_damaged_files_are_refused_in_a_line(interrupted: tuple[Path, str, rule.Rule], name: str, value: Any):
    folder = interrupted[0]
    (folder / "bad.h5").write_bytes((folder / "part.h5").read_bytes())
    with h5py.File(folder / "bad.h5", "r+") as file:
        del file[name]
        file[name] = value
    result = throw_rule(folder, "--resume", "bad.h5")
    assert isinstance(result.exception, Error), result.output
    assert "\n" not in str(result.exception)


def test_files_of_others_are_no_rules(tmp_path: Path):
    (tmp_path / "text.h5").write_text("no")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["wanted"] = 1.0
    for name in ("text.h5", "other.h5", "none.h5"):
        result = throw_rule(tmp_path, "--resume", name)
        assert isinstance(result.exception, Error), result.output
        assert name in str(result.exception)
