"""The command line bears mutated inputs of every kind, and the tool that makes them sees what it should not do."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
if str(ROOT / "tools") not in sys.path:
    sys.path.append(str(ROOT / "tools"))

from fuzzing import judge, kinds, tables, values  # noqa: E402
from fuzzing.models import LOOP  # noqa: E402
from fuzzing.texts import mutated  # noqa: E402

from warpmuscle.formats import load  # noqa: E402
from warpmuscle.formats.toml import dumps  # noqa: E402
from warpmuscle.scene.initial_pose import initial_pose  # noqa: E402

CASES, SEED = 80, 1


@pytest.mark.long
def test_mutated_inputs_of_all_kinds_give_a_result_or_one_line_of_error(tmp_path: Path):
    command = [sys.executable, str(ROOT / "tools/fuzz.py"), "--cases", str(CASES), "--seed", str(SEED)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace")
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert f"{sum(kinds.shares(CASES).values())} cases" in done.stdout
    assert list(tmp_path.iterdir()) == []


def hang_up() -> None:
    raise SystemExit(3)


def raise_key_error() -> None:
    raise KeyError("x")


def raise_two_lines() -> None:
    print("error: one\nerror: two", file=sys.stderr)
    raise SystemExit(2)


def write_half() -> None:
    Path("half.toml").write_text("a = ")
    refuse()


def write_outside() -> None:
    Path("../outside").write_text("x")


def write_nan() -> None:
    with h5py.File("a.h5", "w") as file:
        file["x"] = np.nan


def refuse() -> None:
    print("error: no", file=sys.stderr)
    raise SystemExit(2)


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "a traceback": (raise_key_error, "traceback: KeyError"),
    "another exit code": (hang_up, "exit code 3"),
    "a warning": (lambda: print("a.py:1: RuntimeWarning: overflow", file=sys.stderr), "warns: a.py"),
    "two lines of error": (raise_two_lines, "not one line of error"),
    "an escape": (lambda: print("\x1b[31m"), "control character"),
    "a number that is none": (lambda: print("speed nan m/s"), "prints 'nan'"),
    "another file's content": (lambda: print(judge.SECRET), "content of another file"),
    "a file of a failure": (write_half, "although it failed"),
    "a temporary file": (lambda: Path(".a.h5.0123").write_text("x"), "behind"),
    "a file elsewhere": (write_outside, "outside of its folder"),
    "no number in HDF5": (write_nan, "x is not finite"),
    "no number in a table": (lambda: Path("a.csv").write_text("a,b\n1,inf\n"), "holds inf"),
    "an empty file": (lambda: Path("a.svg").touch(), "is empty"),
    "a lost input": (lambda: Path("input").unlink(), "removed input"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_a_command_must_not_do_is_seen(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    main, complaint = WRONG[what]
    monkeypatch.setattr("warpmuscle.cli.program.main", main)
    (tmp_path / "outer/case").mkdir(parents=True)
    (tmp_path / "outer/case/input").write_text("x")
    found = judge.judged([["info"]], tmp_path / "outer/case", tmp_path).complaints
    assert len(found) == 1
    assert re.search(complaint, found[0])


@pytest.mark.parametrize("main", [refuse, lambda: print("speed 1 m/s, name inf.toml, info"), lambda: None])
def test_a_result_and_one_line_of_error_are_in_order(main, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("warpmuscle.cli.program.main", main)
    (tmp_path / "outer/case").mkdir(parents=True)
    assert judge.judged([["info"]], tmp_path / "outer/case", tmp_path).complaints == []


def test_cases_are_the_same_each_time():
    text = (ROOT / "warpmuscle/scenes/torques/fwalk.toml").read_text()
    data = {"a": [1.0, {"b": "x"}], "c": {"d": 2, "e": [3, 4]}}
    for number in range(50):
        one, two = (mutated(text, Random(number)) for _ in range(2))
        assert one == two
        first, second = (values.toml_text(tables.changed(copy(data), Random(number))) for _ in range(2))
        assert first == second


def copy(data):
    """The same tables and lists, made anew."""
    if isinstance(data, dict):
        return {key: copy(value) for key, value in data.items()}
    return [copy(value) for value in data] if isinstance(data, list) else data


def test_all_cases_are_shared_out_among_the_kinds():
    numbers = kinds.shares(3000)
    assert min(numbers.values()) > 0
    assert abs(sum(numbers.values()) - 3000) < len(numbers)


def test_a_loop_that_has_opened_without_a_word_is_seen(tmp_path: Path):
    """Of a run to its end; one that ended early, or at once, has said why."""
    (tmp_path / "loop.osim").write_text(LOOP)
    scene = load(tmp_path / "loop.osim", ignored=[])
    scene.duration = 0.05
    poses, _ = initial_pose(scene)
    names = list(poses)
    cases = {"closed": (0.05, 0.0), "open": (0.05, 0.01), "ended": (0.02, 0.01), "at once": (None, 0.0)}
    found = {}
    for case, (end, moved) in cases.items():
        times = np.zeros(0) if end is None else np.linspace(0.0, end, 6)
        position = np.array([[poses[name][0] for name in names]] * len(times)).reshape(len(times), len(names), 3)
        position[:, names.index("bar")] += moved
        with h5py.File(tmp_path / "out.h5", "w") as file:
            file["scene"] = dumps(scene)
            motion = file.create_group("replay/0")
            motion["time"], motion["body_names"], motion["body_position"] = times, [*names], position
            turns = np.array([[poses[name][1] for name in names]] * len(times))
            motion["body_orientation"] = turns.reshape(-1, len(names), 4)
        found[case] = list(judge._wrong_hdf5(tmp_path / "out.h5"))
    assert [case for case, complaints in found.items() if complaints] == ["open"]
    assert "open by 0.0173 m" in found["open"][0]
