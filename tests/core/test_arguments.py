"""Every public function says in one line, by name, which of its arguments it cannot use."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple
from unittest.mock import MagicMock

import numpy as np
import pytest

import warpmuscle as wm
from small_result import search_result
from small_scene import muscle_scene
from warpmuscle.core.arguments import as_array, as_integer, as_number, as_path, as_texts, in_words
from warpmuscle.core.errors import ArgumentError
from warpmuscle.simulation.perturbations import none

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
NAN, INF = math.nan, math.inf
ONE = np.int64(1)
STRANGE: list[Any] = [
    None, "a", "", b"a", 1.5, NAN, INF, -1, 0, 10**400, True, [], ["a"], [None], [[1.0], [1.0, 2.0]], {}, {"a": 1},
    object(), lambda: None, np.zeros(0), np.zeros((7, 7, 7)), np.array(["a"]), np.array([NAN]), Path("no/such/file"),
    "\0", "cuda:99", 1j, range(3), iter(()), set(), slice(3), int,
]  # fmt: skip


# Made by the package itself; or of trials and trainings, whose mistakes tests/inverse and tests/learning have.
MADE = ("Motions", "Recording", "Result", "Run", "Scene", "Status", "Sweep")  # by this package or msgspec alone
OF_TRIALS = (
    "inverse_dynamics", "inverse_kinematics", "joint_reactions", "learn", "run_reactions", "scale",
    "static_optimization", "track",
)  # fmt: skip


class Case(NamedTuple):
    """A public function, and what all is well with."""

    call: Callable[..., Any]
    good: dict[str, Any]


@cache
def parts() -> SimpleNamespace:
    """A small scene, a batch of two instances of it on the CPU, and what else functions take."""
    scene = muscle_scene()
    result = search_result()
    evaluator = wm.Evaluator(scene, set={"duration": 0.02}, device="cpu")
    evaluator(evaluator.start)
    return SimpleNamespace(
        scene=scene, rollout=wm.Rollout(scene, 2, "cpu", record=[0]), stages=wm.Stages(scene, 2, "cpu"),
        nothing=replace(result, evaluations=None, best=None, replays=()),
        split=wm.MultiDeviceRollout(scene, 2, ["cpu"], record=[0]), result=result, motion=result.replays[0],
        evaluator=evaluator,
    )  # fmt: skip


BATCH = {
    "instances": 2, "device": "cpu", "record": [0], "record_rate": 50.0, "quantities": ["speeds"], "threads": 1,
    "lanes": 8, "trust": False,
}  # fmt: skip


def cases(folder: Path, p: Any = None) -> dict[str, Case]:
    """All that is public, by name; of other parts than `parts` if there are any."""
    p = p or parts()
    rollout, split, stages = p.rollout, p.split, p.stages
    joints, speeds = len(stages.names.joints), stages.names.speeds
    time, excited = [0.0, 1.0], np.zeros((1, 2, 2))
    state = {
        "root_position": np.zeros((2, 3)), "root_orientation": [0, 0, 0, 1.0], "root_velocity": 0.0,
        "root_angular_velocity": 0.0, "joint_orientation": np.tile([0, 0, 0, 1.0], (2, joints, 1)),
        "joint_angular_velocity": 0.0, "phase": 0.0, "stance": 0, "machine_state": 0, "foot_force": 0.0,
    }  # fmt: skip
    start = {
        "coordinates": rollout.state.coordinates.numpy()[:1],
        "speeds": np.zeros((1, speeds)),
        "activation": np.zeros((1, 2)),
    }
    found = {
        "Rollout": Case(wm.Rollout, {"scene": p.scene, **BATCH}),
        "make_rollout": Case(wm.make_rollout, {"scene": p.scene, **BATCH}),
        "Stages": Case(wm.Stages, {"scene": p.scene, "instances": 2, "device": "cpu", "trust": False}),
        "MultiDeviceRollout": Case(
            wm.MultiDeviceRollout,
            {"scene": p.scene, **{k: v for k, v in BATCH.items() if k != "device"}, "devices": ["cpu"], "name": ""},
        ),
        "Stages.set_state": Case(stages.set_state, state),
        "Stages.muscle_torques": Case(stages.muscle_torques, {"desired": 0.0}),
        "Stages.forward_dynamics": Case(stages.forward_dynamics, {"joint_torque": 0.0}),
        "optimize": Case(
            wm.optimize,
            {
                "scene": p.scene, "candidates": 2, "seed": 1, "device": "cpu", "search": "random", "searches": 1,
                "population": 2, "sigma": 0.1, "restarts": "none", "until": 1.0, "target": 1.0,
                "output": folder / "out.h5", "threads": 1, "command": "", "progress": None, "batches": stopped,
                "trust": False, "quantities": None, "single": False,
            },
        ),
        "Evaluator": Case(
            wm.Evaluator,
            {
                "scene": p.scene, "set": {"duration": 0.05}, "unit_cube": False, "device": "cpu", "threads": 1,
                "trust": False,
            },
        ),
        "Evaluator.evaluate": Case(p.evaluator.evaluate, {"candidates": p.evaluator.start}),
        "Evaluator.result": Case(p.evaluator.result, {"command": ""}),
        "resume": Case(
            wm.resume,
            {
                "path": folder / "none.h5", "candidates": 2, "device": "cpu", "until": 1.0, "target": 1.0,
                "threads": 1, "command": "", "progress": None, "batches": stopped, "trust": False,
                "quantities": None, "single": False,
            },
        ),
        "read": Case(wm.read, {"path": folder / "result.h5", "run": None, "replay": 0}),
        "read_motions": Case(
            wm.read_motions,
            {"path": folder / "result.h5", "quantities": ["time"], "instances": slice(0, 1), "run": None},
        ),
        "append_motions": Case(
            wm.append_motions, {"path": folder / "result.h5", "recordings": [p.motion], "names": ()}
        ),
        "write": Case(
            wm.write,
            {"path": folder / "written.h5", "result": p.result, "quantities": ["time"], "single": False},
        ),
        "load": Case(
            wm.load,
            {"source": "fwalk", "ignored": None, "keyword_rule": False, "trust": False, "ball_joints": False}
            | {"hard_points": False, "merge_welds": False, "limit_stiffness": 0.0, "set": None, "duration": 1.0},
        ),
        "simulate": Case(
            wm.simulate,
            {
                "scene": p.scene, "duration": 0.05, "set": {"duration": 0.05}, "commands": {}, "policy": None,
                "excitations": {"HFL": 0.1}, "device": "cpu", "record_rate": 100.0, "trust": False,
            },
        ),
        "scenes": Case(wm.scenes, {"words": "fwalk"}),
        "quadratic_program": Case(
            wm.quadratic_program,
            {
                "mass": np.ones((1, 1, 1)), "bias": np.zeros((1, 1)), "forces": np.ones((1, 1, 1)),
                "wanted": np.ones((1, 1)), "weight": 1.0, "cost": 1.0, "low": 0.0, "high": 1.0, "device": "cpu",
            },
        ),
        "sweep": Case(
            wm.sweep,
            {
                "file": folder / "none.toml", "output": folder / "swept.h5", "grid": None, "search": None, "set": None,
                "device": "cpu", "threads": 1, "progress": None, "trust": False,
            },
        ),
        "convert": Case(wm.convert, {"source": p.scene, "target": folder / "converted.toml"}),
        "save": Case(wm.save, {"scene": p.scene, "path": folder / "saved.toml", "ignored": None}),
        "trust": Case(wm.trust, {"scene": p.scene, "folder": folder}),
        "best_scene": Case(wm.best_scene, {"result": p.nothing, "fixed": [], "among": None}),
        "measure": Case(
            wm.measure,
            {"recording": p.motion, "left_foot": "lFoot", "right_foot": "rFoot", "start": 1.0, "by": "contact"},
        ),
        "plot": Case(
            wm.plot,
            {
                "source": p.nothing, "kind": "convergence", "path": folder / "plot.svg", "scene": None, "joints": (),
                "muscles": (), "norms": True, "replay": 0, "start": None, "end": None, "run": None,
            },
        ),
        "show": Case(wm.show, {"motion": p.motion, "scene": p.scene, "replay": None, "meshes": None, "over": False}),
        "show a result": Case(wm.show, {"motion": p.nothing, "replay": None, "meshes": None}),
        "Recording.window": Case(p.motion.window, {"start": 0.0, "end": 1.0}),
        "Recording.position_of": Case(p.motion.position_of, {"body": "lFoot"}),
        "Recording[...]": Case(p.motion.__getitem__, {"name": "com"}),
    }  # fmt: skip
    for kind, batch in (("Rollout", rollout), ("MultiDeviceRollout", split)):
        found |= {
            f"{kind}.set_parameters": Case(batch.set_parameters, {"values": [12.0]}),
            f"{kind}.set_excitations": Case(batch.set_excitations, {"time": time, "values": excited, "restart": True}),
            f"{kind}.set_initial": Case(batch.set_initial, dict(start)),
            f"{kind}.reset": Case(batch.reset, {"velocity_noise": 0.0, "seed": 0, "mask": None}),
            f"{kind}.disturb": Case(batch.disturb, {"disturbances": none(2)}),
            f"{kind}.run": Case(batch.run, {"duration": 0.0, "progress": None}),
            f"{kind}.recorded": Case(batch.recorded, {"quantity": "speeds"}),
            f"{kind}.recording": Case(batch.recording, {"instance": 0}),
        }
    found |= {
        "Rollout.parts": Case(rollout.parts, {"instance": 0}),
        "Rollout.restore": Case(rollout.restore, {"snapshot": rollout.snapshot()}),
        "Rollout.step": Case(refused_step, {"k": ONE, "excitations": None, "torques": None}),
    }
    return found


# What is said where a strange value was no worse than the good one.
TAKEN = (
    "nothing was wrong", ": no such file",
    "there is no such file", "holds no", "'no torques'", "no quantity is called", "a mask takes",
    "the mask cannot be taken", "there is no device", ": unknown key", "takes no command", "a scene is written as",
    "is of another character",
)  # fmt: skip


def stopped(scene: Any) -> Any:
    """In place of batches, so that no search begins."""
    raise wm.Error("nothing was wrong with the arguments")


def refused_step(k: Any, excitations: Any = None, torques: Any = None) -> None:
    """A step whose arguments are checked, and that is not made."""
    wrong = None if k is not ONE or excitations is not None or torques is not None else "no torques"
    parts().rollout.step(k, excitations, wrong if torques is None else torques)


def call(case: Case, **changes: Any) -> Any:
    given = case.good | changes
    source = (given.pop("source"),) if case.call is wm.load else ()
    return case.call(*source, **given)


def strange(case: Case) -> Iterator[tuple[str, Any]]:
    for name in case.good:
        for value in STRANGE:
            if name != "batches" or not callable(value):  # which would be called
                yield name, value


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("arguments")
    wm.write(place / "result.h5", parts().result)
    return place


NAMES = tuple(cases(Path(), MagicMock()))  # each worker looks for tests: nothing is built for them before they run


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("name", NAMES)
def test_strange_arguments_are_taken_or_refused_in_one_line_that_names_them(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(folder)
    case = cases(folder)[name]
    for argument, value in strange(case):
        try:
            call(case, **{argument: value})
        except wm.Error as error:
            text = str(error)
            assert "\n" not in text, (argument, value)
            assert 0 < len(text) < 1200, (argument, value)
            known = (argument, *TAKEN, *([repr(str(value))[1:-1]] if isinstance(value, str | Path) else []))
            assert any(words in text for words in known), (argument, value, text)
        except Exception as error:  # the test is that there is none
            pytest.fail(f"{name}({argument}={in_words(value)}) ends in {type(error).__name__}: {error}")


def test_every_public_function_and_argument_is_in_the_table(tmp_path: Path):
    table = cases(tmp_path)
    for name in wm.__all__:
        value = getattr(wm, name)
        made = name in (
            "Motions",
            "Recording",
            "Result",
            "Run",
            "Scene",
            "Status",
            "Sweep",
            *OF_TRIALS,
        )  # or by msgspec
        if callable(value) and not (made or (inspect.isclass(value) and issubclass(value, wm.Error))):
            wanted = {k for k, v in inspect.signature(value).parameters.items() if v.kind is not v.VAR_POSITIONAL}
            assert wanted <= set(table[name].good), name


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("Rollout", {"record": ["a"]}, "a number in record must be a whole number, not 'a'"),
        ("Rollout", {"record": 0}, "record must be a list of instances' numbers, not 0"),
        ("Rollout", {"record": [2]}, "record: cannot record instance 2 of 2"),
        ("Rollout", {"record_rate": 0}, "record_rate must be a finite number greater than 0, not 0"),
        ("Rollout", {"record_rate": NAN}, "record_rate must be a finite number greater than 0, not nan"),
        ("Rollout", {"instances": NAN}, "instances must be a positive whole number, not nan"),
        ("Rollout", {"instances": True}, "instances must be a positive whole number, not True"),
        ("Rollout", {"lanes": -1}, "lanes must be a whole number from 1 to 32, not -1"),
        ("Rollout", {"threads": "2"}, "threads must be a positive whole number, not '2'"),
        ("Rollout", {"device": 0}, "device must be text, not 0"),
        ("Rollout", {"quantities": ["angle"]}, "quantities: no quantity 'angle'"),
        ("Rollout", {"scene": {"name": "a"}}, "scene must be a scene, its name or its file, not a dict"),
        ("Rollout", {"scene": "fwlk"}, "there is no scene called 'fwlk'; did you mean 'fwalk'?"),
        ("Rollout", {"trust": "yes"}, "trust must be True or False, not 'yes'"),
        ("MultiDeviceRollout", {"devices": []}, "devices must name at least one"),
        ("Rollout.set_parameters", {"values": ["a"]}, "values must be an array of numbers, not a list"),
        ("Rollout.set_parameters", {"values": [[1.0], [1.0, 2.0]]}, "values must be an array of numbers, and a list"),
        ("Rollout.reset", {"seed": -1}, "seed must be a whole number, 0 or greater, not -1"),
        ("Rollout.reset", {"velocity_noise": -1}, "velocity_noise must be a finite number, 0 or greater, not -1"),
        ("Rollout.run", {"duration": "long"}, "duration must be a finite number, 0 or greater, not 'long'"),
        ("Rollout.run", {"progress": 1}, "progress must be a function, not 1"),
        ("Rollout.recorded", {"quantity": 3}, "quantity must be text, not 3"),
        ("Rollout.parts", {"instance": -1}, "instance must be a whole number from 0 to 1, not -1"),
        ("Rollout.disturb", {"disturbances": 1}, "disturbances must be a Perturbations, not 1"),
        ("Rollout.set_initial", {"speeds": "fast"}, "initial speeds must be an array of numbers, not 'fast'"),
        ("Stages.set_state", {"root_position": np.zeros((3, 3))}, r"root_position has shape \(3, 3\), not \(2, 3\)"),
        ("Stages.set_state", {"stance": 2}, "stance must lie within 0 and 1"),
        ("Stages.set_state", {"phase": NAN}, "a number of phase is not finite"),
        ("optimize", {"seed": -1}, "seed must be a whole number from 0 to"),
        ("optimize", {"candidates": 0}, "candidates must be a positive whole number, not 0"),
        ("optimize", {"candidates": "many"}, "candidates must be a positive whole number, not 'many'"),
        ("optimize", {"search": 3}, "search must be text, not 3"),
        ("optimize", {"sigma": -1}, "sigma must be a finite number greater than 0, not -1"),
        ("optimize", {"output": 3}, "output must be the path of a file, not 3"),
        ("resume", {"candidates": NAN}, "candidates must be a positive whole number, not nan"),
        ("read", {"path": 3}, "path must be the path of a file, not 3"),
        ("read", {"run": 3}, "run must be text, not 3"),
        ("write", {"result": "r"}, "result must be a Result, not 'r'"),
        ("load", {"source": 3}, "source must be the path of a file, not 3"),
        ("save", {"scene": None}, "scene must be a scene, its name or its file, not None"),
        ("trust", {"scene": "fwalk"}, "scene must be a scene as wm.load gives it, not 'fwalk'"),
        ("best_scene", {"result": None}, "result must be a Result, not None"),
        ("best_scene", {"among": -1}, "among must be a positive whole number, not -1"),
        ("measure", {"left_foot": "lFot"}, "left_foot: no body is called 'lFot'; did you mean 'lFoot'?"),
        ("measure", {"start": "now"}, "start must be a finite number, not 'now'"),
        ("plot", {"kind": 3}, "kind must be text, not 3"),
        ("plot", {"norms": 1}, "norms must be True or False, not 1"),
        ("plot", {"replay": -1}, "replay must be a whole number, 0 or greater, not -1"),
        ("show a result", {"replay": -1}, "replay must be a whole number, 0 or greater, not -1"),
        ("Recording.window", {"start": "a"}, "start must be a number, not 'a'"),
    ],
)
def test_the_argument_is_named(name: str, changes: dict[str, Any], message: str, folder: Path):
    with pytest.raises(wm.Error, match=message):
        call(cases(folder)[name], **changes)


@pytest.mark.parametrize(
    "name", ["Rollout", "make_rollout", "Stages", "MultiDeviceRollout", "optimize", "Evaluator", "save", "show"]
)
def test_a_scene_may_be_given_by_its_name_or_file(name: str, folder: Path):
    wm.save(parts().scene, folder / "small.toml")
    for scene in (folder / "small.toml", str(folder / "small.toml"), "fwalk"):
        case = cases(folder)[name]
        try:
            call(case, scene=scene)
        except wm.Error as error:
            assert str(error).startswith(("nothing was wrong", "the motion", "a motion", "motion"))  # noqa: PT017


def test_a_bad_start_leaves_the_batch_as_it_was():
    rollout = wm.Rollout(parts().scene, 2, "cpu")
    before = rollout.state.coordinates.numpy()
    with pytest.raises(wm.RolloutError, match="initial speeds"):
        rollout.set_initial(coordinates=before + 1.0, speeds=[NAN])
    rollout.reset()
    np.testing.assert_array_equal(rollout.state.coordinates.numpy(), before)


def test_numbers_of_numpy_are_numbers():
    assert as_integer(np.int32(3), "n") == as_integer(np.float64(3.0), "n") == as_integer(np.array(3), "n") == 3
    assert as_number(np.float32(0.5), "x") == 0.5
    assert as_texts("one", "names") == ("one",)
    assert as_path(Path("a"), "path") == as_path("a", "path")
    assert as_array([], "values").shape == (0,)


@pytest.mark.parametrize("value", [10**5000, "a" * 10**6, np.zeros((3, 3)), "\n\n", object(), Path("\n")], ids=type)
def test_what_is_said_of_a_value_is_short_and_one_line(value: object):
    with pytest.raises(ArgumentError) as caught:
        as_integer(value, "n", most=1)
    assert len(str(caught.value)) < 140
    assert "\n" not in str(caught.value)
