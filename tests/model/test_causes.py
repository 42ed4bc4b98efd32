"""What of a user's own, or from outside, is no number ends the instance, and is named."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warpmuscle as wm
from importing import importable_from
from muscle_arm import arm, constant
from warpmuscle.cli.program import main
from warpmuscle.core.array_interop import rows_of
from warpmuscle.core.errors import UserPartWarning
from warpmuscle.core.status import Status
from warpmuscle.formats import toml
from warpmuscle.scene import Actuation, Force, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation import inputs
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.rollout import Rollout

NAME = "unsound_parts"
MODULE = '''
import warp as wp
from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.structs import ModelRef, StateRef, ScratchRef
from warpmuscle.kernels.objective.term_functions import MuscleWork


@wp.func
def wrong(instance: int, unsound: int, state: StateRef) -> float:
    """Not a number for one of the instances, from the tenth step on; else 0."""
    if instance == unsound and state.step[instance] > 9:
        return wp.sqrt(-1.0 - float(instance))
    return 0.0


@wp.func
def of_all(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return wrong(instance, 1, state)


@wp.func
def of_body(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return wrong(instance, 2, state)


@wp.func
def of_muscle(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    if instance == 3 and m == 1:
        return 1.0 / (w.activation * 0.0)
    return 0.0


@wp.func
def drag(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> Wrench:
    w = Wrench()
    if body == 1:
        w.moment = wp.vec3(0.0, wrong(instance, 4, state), 0.0)
    return w


@wp.func
def spring(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    return wp.vec3(wrong(instance, 5, state), 0.0, 0.0)


@wp.func
def effort(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    return wp.vec3(wrong(instance, 6, state), 0.0, 0.0)


@wp.func
def excitation(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    if muscle == 1:
        return 0.1 + wrong(instance, 7, state)
    return 0.1


controller = CustomController(effort=effort, excitation=excitation)
drags = ForceKind(wrench=drag)
springs = ForceKind(effort=spring)
'''
PARTS = [
    "",
    f"the term '{NAME}:of_all' gave a value",
    f"the term '{NAME}:of_body' gave a value",
    f"the term '{NAME}:of_muscle' gave a value",
    f"the force 'wind' ({NAME}:drags) gave a value",
    f"the force 'brace' ({NAME}:springs) gave a value",
    f"the controller '{NAME}:controller' gave the joint 'elbow' an effort",
    f"the controller '{NAME}:controller' gave the muscle 'extensor' an excitation",
]


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("unsound")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield place


def scene(**changes: Any) -> Scene:
    given = arm(duration=0.05, actuation={"elbow": Actuation("muscle")}, **changes)
    given.custom_controller = f"{NAME}:controller"
    given.forces = {
        "calm": Force(f"{NAME}:drags", body="base"),
        "wind": Force(f"{NAME}:drags", body="tip"),
        "brace": Force(f"{NAME}:springs", joint="elbow"),
    }
    given.objective.custom = {f"{NAME}:{name}": 1.0 for name in ("of_all", "of_body", "of_muscle")}
    return given


def test_each_part_that_gives_no_number_is_named() -> None:
    given = scene()
    rollout = Rollout(given, len(PARTS), "cpu", trust=True)
    rollout.run()
    assert rollout.status().tolist() == [Status.COMPLETED, *[Status.DIVERGED] * 7]
    for cause, expected in zip(rollout.causes(), PARTS, strict=True):
        assert cause.startswith(expected)
        assert (NAME in cause) == bool(expected)
    assert rollout.end_time()[1] == pytest.approx(10 * given.time_step)
    assert np.isfinite(rollout.cost()).all()
    rollout.reset(mask=np.arange(len(PARTS)) == 4)
    assert rollout.causes()[4] == ""
    assert rollout.causes()[5]
    rollout.reset()
    assert not any(rollout.causes())


def test_several_devices_name_them_too() -> None:
    given = scene()
    batch = make_rollout(given, 4, "cpu")
    batch.run()
    assert [cause[:8] for cause in batch.causes()] == ["", *["the term"] * 3]
    assert [len(rollout.causes()) for rollout in getattr(batch, "rollouts", [batch])] == [4]


def test_a_search_says_it_once() -> None:
    given = scene()
    given.objective.effort_squared = Free(0.5, 0.0, 1.0)
    given.character.bodies["tip"].mass = Free(2.0, 1.0, 3.0)
    with pytest.warns(UserPartWarning) as told:
        wm.optimize(given, 16, device="cpu", trust=True)
    said = [str(one.message) for one in told if one.category is UserPartWarning]
    assert len(said) == len(set(said)) > 4
    assert said[0].startswith("candidates have failed because the controller")


def test_torques_and_excitations_from_outside_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a GPU arrays are not looked at before the step, as here."""
    monkeypatch.setattr(inputs, "rows_of", lambda *given, numbers=False: rows_of(*given))
    given = arm(duration=0.05, actuation={"elbow": Actuation("muscle")})
    for muscle in given.character.muscles.values():
        muscle.excitation = constant(0.1)
    rollout = Rollout(given, 3, "cpu")
    excitations = np.full((3, 2), 0.2)
    excitations[1, 1], excitations[2, 0] = np.nan, np.inf  # beyond 0..1 it is 1
    rollout.step(20, excitations=excitations)
    assert rollout.status().tolist() == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    assert rollout.causes() == ("", "the muscle 'extensor' was given an excitation that is not a number", "")
    rollout.reset()
    rollout.step(20, torques=[[0.0], [1.0], [np.nan]])
    assert [bool(cause) for cause in rollout.causes()] == [False, False, True]
    assert rollout.causes()[2].startswith("the joint 'elbow' was given a torque that is not a number")


def test_the_command_line_names_it(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    (folder / "single.py").write_text(MODULE.replace("instance, 1, state", "instance, 0, state"))
    given = scene()
    given.custom_controller, given.forces = "", {}
    given.objective.custom = {"single:of_all": 1.0}
    toml.write(given, folder / "single.toml")
    monkeypatch.chdir(folder)
    monkeypatch.setattr("sys.argv", ["warpmuscle", "simulate", "single.toml", "--trust", "--device", "cpu"])
    with suppress(SystemExit):
        main()
    said = " ".join(capsys.readouterr().out.split())
    assert "was none: the term 'single:of_all' gave a value that is not a number" in said
