"""The experiment on weak muscles, from the file of a tiny sweep: its figure, its table, and what is no such file."""

import sys
from pathlib import Path

import pytest

from warpmuscle.core.errors import Error
from warpmuscle.sweep.run import sweep

EXPERIMENTS = Path(__file__).parents[2] / "tools" / "research" / "experiments"
if str(EXPERIMENTS) not in sys.path:
    sys.path.append(str(EXPERIMENTS))

import weakness  # noqa: E402

SWEEP = """
scene = "walk56"
[set]
duration = 4
[search]
candidates = 1
[[grid]]
calf = { keys = ["character.muscles.?SOL.f_max"], factors = [1, 0.5] }
[[grid]]
hip_muscles = { keys = ["character.muscles.?HipAbd.f_max"], factors = [0.01] }
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep of three runs, of which one falls."""
    folder = tmp_path_factory.mktemp("weak")
    (folder / "weak.toml").write_text(SWEEP)
    sweep(folder / "weak.toml", folder / "weak.h5", device="cpu", command="test")
    return folder / "weak.h5"


def test_a_weak_gait_stands_beside_the_normal_one_and_a_fall_is_told(done: Path, tmp_path: Path, capsys):
    weakness.main(done, tmp_path / "new")
    assert (tmp_path / "new" / "weakness.png").stat().st_size > 50_000
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert [row[:3] for row in rows[2:]] == [
        ["calf", "100", "4"], ["calf", "50", "4"], ["hip muscles", "100", "4"], ["hip muscles", "1", rows[5][2]],
    ]  # fmt: skip
    assert rows[5][2].startswith("falls at ")
    assert rows[5][3] == ""
    speed = rows[0].index("speed, m/s")
    assert 0.5 < float(rows[2][speed]) < 1.5
    assert "(" in rows[3][speed]
    assert "SOL +" in rows[3][-1]


def test_weaker_gaits_come_after_the_normal_one_from_strong_to_weak(done: Path):
    groups = weakness.runs_of(done)
    assert {group: [run.level for run in runs] for group, runs in groups.items()} == {
        "calf": [1.0, 0.5],
        "hip_muscles": [1.0, 0.01],
    }
    assert "SOL" in weakness.compensating(groups["calf"])
    assert [run.fell for run in groups["hip_muscles"]] == [False, True]


def test_a_file_without_a_normal_run_is_an_error_of_the_user(tmp_path: Path, capsys):
    (tmp_path / "other.toml").write_text('scene = "fwalk"\n[set]\nduration = 0.01\n[search]\ncandidates = 1\n')
    sweep(tmp_path / "other.toml", tmp_path / "other.h5", device="cpu", command="test")
    (tmp_path / "no.h5").write_bytes(b"no")
    for name in ("other.h5", "no.h5", "missing.h5"):
        with pytest.raises(Error, match=name):
            weakness.main(tmp_path / name, tmp_path)
    assert not (tmp_path / "weakness.png").exists()
