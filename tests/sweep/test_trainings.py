"""Sweeps of trainings: every seed and value its own policy, that goes on after an interruption."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error, SceneError
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.training_plan import training_plan

SWEEP = """
scene = "reflex_planar"
name = "trainings"

[set]
duration = 0.2

[training]
iterations = 2
instances = 2
steps = 4
epochs = 1
minibatches = 1
hidden = [8]

[grid]
seed = [1, 2]
"training.learning_rate" = [1e-3, 2e-3]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "sweep.toml"
    path.write_text(SWEEP)
    return path


def test_a_sweep_file_says_what_trainings_are_told(file: Path):
    plan = read(file)
    assert plan.trains
    assert [run.name for run in plan.runs] == [
        f"seed={seed},learning_rate={rate}" for seed in (1, 2) for rate in ("0.001", "0.002")
    ]
    told = [run.training for run in plan.runs]
    assert all(one is not None and one.iterations == 2 and one.options["hidden"] == (8,) for one in told)
    assert [one.options["learning_rate"] for one in told if one is not None] == [1e-3, 2e-3, 1e-3, 2e-3]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("epochs = 1", "epoch = 1", "no option 'epoch'.*epochs"),
        ("iterations = 2", "", "needs an end"),
        ("iterations = 2", "iterations = -2", "iterations"),
        ("iterations = 2", "until = 0", "until"),
        ("1e-3, 2e-3", "1e-3, -1.0", "learning_rate"),
    ],
)
def test_impossible_trainings_are_refused_with_their_place(file: Path, old: str, new: str, message: str):
    file.write_text(SWEEP.replace(old, new))
    with pytest.raises(SceneError, match=message) as caught:
        read(file)
    assert caught.value.file == file
    assert "training" in caught.value.key


def test_options_of_trainings_need_trainings(file: Path):
    file.write_text(SWEEP.replace("[training]", "[searching]"))
    with pytest.raises(SceneError, match="searching"):
        read(file)
    text = SWEEP.partition("[training]")
    file.write_text(text[0] + "[grid]" + text[2].partition("[grid]")[2])
    with pytest.raises(SceneError, match=r"no \[training\]"):
        read(file)


def test_a_plan_keeps_what_it_is_told():
    plan = training_plan({"until": 60, "target": 0.95, "epochs": 5})
    assert (plan.iterations, plan.until, plan.target, plan.options) == (None, 60.0, 0.95, {"epochs": 5})
    with pytest.raises(Error, match="target"):
        training_plan({"target": 2.0})


def test_trainings_run_and_are_gathered_and_stay_as_they_are(file: Path, tmp_path: Path):
    pytest.importorskip("torch", reason="learning needs PyTorch")
    import h5py

    from warpmuscle.learning.options import options_of
    from warpmuscle.learning.training import learn
    from warpmuscle.results.result import read as read_result
    from warpmuscle.sweep.run import sweep
    from warpmuscle.sweep.status import sweep_status

    output, told = tmp_path / "all.h5", []

    def stop(progress):
        told.append(progress)
        if progress.ended == 2 and progress.training.iterations == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(file, output, device="cpu", threads=1, progress=stop)
    assert sweep_status(output).ended == 2
    result = sweep(file, output, device="cpu", threads=1)
    assert (result.gathered, result.failed) == (4, {})
    status = sweep_status(output)
    assert (status.ended, status.evaluated, status.trains) == (4, 8, True)
    with h5py.File(output) as gathered:
        table = gathered["table"]
        assert table["seed"][()].tolist() == [1, 1, 2, 2]
        assert table["iterations"][()].tolist() == [2, 2, 2, 2]
        np.testing.assert_allclose(table["axes/learning_rate"][()], [1e-3, 2e-3, 1e-3, 2e-3])
        names = list(gathered["runs"])
    plan = read(file)
    run = plan.runs[3]
    alone = learn(
        run.scene, options=options_of(run.training.options), seed=2, device="cpu", iterations=2, threads=1
    ).result.learned
    swept = read_result(output, run=names[3]).learned
    for one, other in zip(alone.policy.layers, swept.policy.layers, strict=True):
        np.testing.assert_array_equal(one.weight, other.weight)


def test_a_cluster_takes_no_trainings(file: Path, tmp_path: Path):
    from warpmuscle.sweep.run import sweep

    with pytest.raises(Error, match="one machine"):
        sweep(file, tmp_path / "all.h5", cluster="auto")
