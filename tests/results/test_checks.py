"""Results and journals with absurd content: one line that says where, no warning, and nothing infinite comes out."""

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from small_result import march, search_result
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.formats import sto
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.plots.subject import Choices, Subject
from warpmuscle.report.summary import report
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.journal import Journal
from warpmuscle.results.result import glance, read, write
from warpmuscle.view.sources import of_replays, tracks_of

Change = Callable[[h5py.File], Any]


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A file with a search and a motion."""
    path = tmp_path_factory.mktemp("whole") / "result.h5"
    write(path, search_result("fwalk"))
    return path


def put(name: str, value: Any) -> Change:
    """One number of a dataset, or all of it, is another."""

    def change(file: h5py.File) -> None:
        dataset = file[name]
        dataset[(0,) * dataset.ndim if np.ndim(value) == 0 else ...] = value

    return change


def replaced(name: str, value: Any) -> Change:
    """A dataset is another one."""

    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = value

    return change


def attribute(name: str, value: Any, group: str = "/") -> Change:
    return lambda file: file[group].attrs.__setitem__(name, value)


ABSURD: dict[str, tuple[Change, str]] = {
    "cost nan": (put("evaluations/cost", np.nan), "evaluations/cost holds nan"),
    "cost inf": (put("evaluations/cost", np.inf), "evaluations/cost holds inf"),
    "cost huge": (put("evaluations/cost", 1e300), "evaluations/cost holds 1e"),
    "status": (put("evaluations/status", 99), "evaluations/status holds 99"),
    "stage": (put("evaluations/stage", -1), "evaluations/stage holds -1"),
    "far stage": (put("evaluations/stage", 7), "has no stage 7"),
    "generation": (replaced("evaluations/generation", np.full(60, 0.5)), "generation holds no whole numbers"),
    "params shape": (replaced("evaluations/params", np.zeros((60, 2))), "evaluations/params has shape"),
    "cost text": (replaced("evaluations/cost", ["a"] * 60), "evaluations/cost holds no numbers"),
    "cost scalar": (replaced("evaluations/cost", 1.0), "len|shape"),
    "cost group": (lambda file: (file.pop("evaluations/cost"), file.create_group("evaluations/cost")), "cost"),
    "unknown term": (replaced("evaluations/term_names", ["torque", "wings"]), "no term 'wings'"),
    "term twice": (replaced("evaluations/term_names", ["speed", "speed"]), "twice"),
    "best index": (replaced("best/index", 10**6), "best/index is 1000000"),
    "best cost": (replaced("best/cost", np.nan), "best/cost holds nan"),
    "best params": (replaced("best/params", np.zeros(3)), "best/params has shape"),
    "scale": (replaced("parameters/scale", ["cubic"] * 90), "scale"),
    "bounds": (put("parameters/min", 1e9), "above that of parameters/max"),
    "history": (replaced("history/generation", [1, 2]), "history/.* has shape"),
    "crc": (put("history/asks_crc32", -5), "history/asks_crc32 holds -5"),
    "candidates": (attribute("candidates", -1, "searches"), "candidates is -1"),
    "sigma": (attribute("sigma", np.inf, "searches"), "sigma is inf"),
    "strategy": (attribute("strategy", 3.0, "searches"), "strategy is 3.0"),
    "seed": (attribute("seed", -1), "the seed is -1"),
    "no device": (lambda file: file.attrs.pop("device"), "attribute 'device' of / is missing"),
    "no parameters": (lambda file: file.pop("parameters"), "parameters"),
    "stance": (put("replay/0/stance", -1000000), "replay/0/stance holds -1e"),
    "time inf": (put("replay/0/time", np.inf), "replay/0/time holds inf"),
    "time back": (put("replay/0/time", 3.0), "times that do not increase"),
    "time far": (lambda file: put("replay/0/time", file["replay/0/time"][()] * 1e9)(file), "replay/0/time holds"),
    "quaternion nan": (put("replay/0/joint_orientation", np.nan), "joint_orientation holds nan"),
    "quaternion zero": (put("replay/0/root_orientation", np.zeros(4)), "far from unit length"),
    "velocity": (put("replay/0/com_velocity", 1e30), "com_velocity holds 1e"),
    "shape": (replaced("replay/0/com", np.zeros((401, 2))), "com has shape"),
    "joint twice": (lambda file: put("replay/0/joint_names", ["lHip"] * 14)(file), "a name twice"),
    "joints unknown": (put("replay/0/joint_names", [f"j{k}" for k in range(14)]), "another character"),
    "state": (put("replay/0/state", 77), "in state 77"),
    "no time": (lambda file: file.pop("replay/0/time"), "time"),
    "scene": (replaced("scene", "name = ["), "not valid TOML"),
    "other scene": (replaced("scene", 'name = "a"'), "."),
    "scene numbers": (replaced("scene", 3.0), "scene|string"),
}


def use(path: Path, table: Path) -> None:
    """Do with a file what commands do."""
    result = read(path)
    report(result)
    sto.write(result.replays[0], scene_in(result), table)
    tracks_of(of_replays(result))
    assert Subject(result, Choices(), path).recording.frames


def test_file_as_it_was_written_serves_all_purposes(whole: Path, tmp_path: Path):
    use(whole, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").exists()


@pytest.mark.parametrize("name", ABSURD)
@pytest.mark.filterwarnings("error")
def test_absurd_content_is_one_line(name: str, whole: Path, tmp_path: Path):
    path = shutil.copy(whole, tmp_path / "a.h5")
    change, message = ABSURD[name]
    with h5py.File(path, "a") as file:
        change(file)
    with pytest.raises(Error, match=message) as caught:
        use(path, tmp_path / "a.csv")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "a.csv").exists()


@pytest.mark.filterwarnings("error")
def test_terms_that_are_no_numbers_do_not_leave_by_the_report(whole: Path, tmp_path: Path):
    path = shutil.copy(whole, tmp_path / "a.h5")
    with h5py.File(path, "a") as file:
        file["evaluations/terms"][...] = np.nan
    said = "\n".join(report(read(path)))
    assert "cost of the best" in said
    assert not any(word in said.split() for word in ("nan", "inf", "-inf"))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("suffix", [".csv", ".mot"])
def test_motion_with_a_number_that_is_not_finite_is_not_exported(suffix: str, tmp_path: Path):
    scene = scene_in(search_result("fwalk"))
    motion = march(scene.character, 1.0)
    motion.root_position[3, 1] = np.inf
    with pytest.raises(Error, match="holds a value that is not finite; nothing was written"):
        sto.write(motion, scene, tmp_path / f"a{suffix}")
    assert not list(tmp_path.iterdir())


def test_names_with_separators_stay_one_column(tmp_path: Path):
    scene = scene_in(search_result("fwalk"))
    motion = march(scene.character, 1.0, frames=5, muscles=0)
    named = dataclasses.replace(
        motion, muscle_names=('a,b"\n',), **{
            name: np.zeros((5, 1)) for name in (
                "muscle_path_length", "muscle_fibre_length", "muscle_fibre_velocity", "muscle_desired_force",
                "muscle_excitation", "muscle_activation", "muscle_force",
            )
        },
    )  # fmt: skip
    scene.character.muscles['a,b"\n'] = None  # type: ignore[assignment]
    sto.write(named, scene, tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert len(lines) == 6
    assert lines[0].endswith(',"a,b"" .activation","a,b"" .force"')


RECORDS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "cost missing": lambda record: record.pop("cost"),
    "cost shape": lambda record: record.update(cost=record["cost"][:3]),
    "cost nan": lambda record: record.update(cost=record["cost"] * np.nan),
    "status": lambda record: record.update(status=record["status"] + 100),
    "text": lambda record: record.update(end_time=record["end_time"].astype(str)),
    "empty": lambda record: record.update({name: array[:0] for name, array in record.items()}),
    "two generations": lambda record: record.update(generation=np.arange(len(record["cost"]))),
    "scalars": lambda record: record.update({name: np.float64(0) for name in record}),
    "other parameters": lambda record: record.update(params=record["params"][:, :2]),
    "other terms": lambda record: record.update(term_names=np.array(["wings", "speed"])),
}


@pytest.mark.parametrize("name", RECORDS)
@pytest.mark.filterwarnings("error")
def test_whole_record_of_a_journal_with_absurd_content_is_one_line(name: str, tmp_path: Path):
    result = search_result("fwalk")
    evaluations = result.evaluations
    begun = dataclasses.replace(result, evaluations=evaluations.rows(slice(0, 50)), replays=(), best=None)
    path = tmp_path / "a.h5"
    with Checkpoint.begin(path, begun) as checkpoint, pytest.MonkeyPatch.context() as patch:
        from warpmuscle.results import journal

        write_record = journal.packed

        def absurd(record: dict[str, Any]) -> bytes:
            changed = dict(record)
            RECORDS[name](changed)
            return write_record(changed)

        patch.setattr(journal, "packed", absurd)
        checkpoint._journal.append(evaluations.rows(slice(50, 60)))
    assert isinstance(Journal.look(tmp_path / "a.h5.journal"), list)
    with pytest.raises(ResultError, match=r"damaged journal: .*move it out of the way") as caught:
        Checkpoint.resume(path)
    assert "\n" not in str(caught.value)


def test_glance_gives_the_columns_that_a_sweep_counts_by(whole: Path):
    ended, cost, generation, stage, evaluated = glance(whole)
    assert evaluated == len(cost)
    found = search_result("fwalk").evaluations
    assert ended == "all candidates have been evaluated"
    for column, name in ((cost, "cost"), (generation, "generation"), (stage, "stage")):
        np.testing.assert_array_equal(column, getattr(found, name))
