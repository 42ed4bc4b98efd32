"""Several seeds of one task, learnt at once."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools" / "research"))

from several_seeds import command_of, main  # noqa: E402

from warpmuscle.core.errors import Error  # noqa: E402


def test_each_seed_is_learnt_by_the_command_of_the_manual():
    paths = Path("task.toml"), Path("begun.h5")
    command = command_of(*paths, 3, "432s", ["clip=0.1"], ["learning.rewards.alive=2"], "cuda:0", Path("m_3.h5"))
    assert command[1:] == [
        "-m", "warpmuscle", "learn", "task.toml", "--from", "begun.h5", "--until", "432s", "--seed", "3",
        "--option", "clip=0.1", "--set", "learning.rewards.alive=2", "--device", "cuda:0", "-o", "m_3.h5",
    ]  # fmt: skip


def test_seeds_that_fail_are_told_and_there_is_no_mean(tmp_path: Path):
    with pytest.raises(Error, match=r"learning ended with an error: mean_1\.h5, mean_2\.h5"):
        main(tmp_path / "none.toml", tmp_path / "none.h5", seeds=2, output=tmp_path / "mean.h5")
    assert not (tmp_path / "mean.h5").exists()
