"""Files of TensorBoard of a search, a training and a sweep."""

import math

import pytest

from warpmuscle.core.errors import Error
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.optimization.progress import Progress
from warpmuscle.report.scalar_log import TensorBoard, points
from warpmuscle.sweep.board import SweepProgress


def search(done: int, generation: int, best: float, median: float = math.inf) -> Progress:
    return Progress(100, done, 5, best, 2.0 * done, done / 100, generation, median, 0)


def test_a_search_has_a_point_a_generation_and_names_its_stage():
    assert points(search(0, 0, math.inf))[0] is None
    mark, step, values = points(search(20, 1, 5.0, 8.0))
    assert (step, values["least cost"], values["median cost"], values["simulated seconds"]) == (20, 5.0, 8.0, 40.0)
    assert mark != points(search(20, 2, 5.0))[0]
    staged = Progress(100, 20, 5, 5.0, 40.0, 0.2, 1, 8.0, 0, stage=1, stages=2, stage_name="hills")
    assert points(staged)[2]["hills/least cost"] == 5.0


def test_a_training_and_a_sweep_have_points_of_their_own():
    training = TrainingProgress(3, 6000, 0.1, 2000.0, 1.5, 0.25, 1.1, 42.0)
    assert points(training) == (3, 6000, {"return": 42.0, "upright, s": 1.5, "completed": 0.25, "speed, m per s": 1.1,
                                          "disturbances": 1.0, "pushes": 1.0,
                                          "decisions a second": 2000.0})  # fmt: skip
    assert points(TrainingProgress(0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, compiling=True))[0] is None
    assert points(SweepProgress(4, 1, 40, 15, 3.5, "a", 2)) == (1, 15, {"least cost": 3.5, "runs ended": 1.0})
    mark, step, values = points(SweepProgress(4, 1, 0, 0, math.inf, "a", 0, training=training))
    assert (mark, step, values["a/return"]) == (("a", 3), 6000, 42.0)


def test_without_tensorboard_an_error_says_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(Error, match=r"files of TensorBoard need TensorBoard: pip install 'warpmuscle\[tensorboard\]'"):
        TensorBoard(tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_the_last_progress_of_each_generation_is_written_once(monkeypatch):
    written = []
    board = object.__new__(TensorBoard)
    board._mark, board._kept = None, None
    monkeypatch.setattr(TensorBoard, "_write", lambda self, step, values: written.append((step, values["least cost"])))
    for progress in (
        search(0, 0, math.inf),
        search(4, 0, 9.0),
        search(10, 0, 7.0),
        search(12, 1, 7.0),
        search(20, 1, 6.0),
    ):
        board(progress)
    assert written == [(10, 7.0)]
    board._writer = type("Closed", (), {"close": lambda self: None})()
    board.close()
    assert written == [(10, 7.0), (20, 6.0)]


def test_tensorboard_reads_what_was_written(tmp_path):
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    with TensorBoard(tmp_path / "runs") as board:
        board(search(10, 0, 7.0))
        board(search(20, 1, 6.0, 8.0))
    read = EventAccumulator(str(tmp_path / "runs")).Reload()
    assert [(one.step, one.value) for one in read.Scalars("least cost")] == [(10, 7.0), (20, 6.0)]
    assert [(one.step, one.value) for one in read.Scalars("median cost")] == [(20, 8.0)]  # none before
