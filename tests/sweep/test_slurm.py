"""Scripts for Slurm do what their comments say: run here with programs in place of Slurm's."""

import os
import subprocess
from pathlib import Path

import pytest

from warpmuscle.core.errors import Error
from warpmuscle.sweep.slurm import slurm_script, write_slurm_script


def submitted(folder: Path, script: str, code: int) -> tuple[int, list[str], list[str]]:
    """What the job of part 2 comes to where the command ends with a code, and what it asked of Slurm."""
    for name, ending in (("srun", code), ("scontrol", 0)):
        program = folder / name
        program.write_text(f'#!/bin/bash\nprintf "%s\\n" "$@" > {folder}/{name}.said\nexit {ending}\n')
        program.chmod(0o755)
    job = {"PATH": f"{folder}:{os.environ['PATH']}", "SLURM_ARRAY_TASK_ID": "2", "SLURM_JOB_ID": "77"}
    (folder / "scontrol.said").unlink(missing_ok=True)
    done = subprocess.run(["bash", "-c", script], env=os.environ | job, check=False)
    said = [(folder / f"{name}.said") for name in ("srun", "scontrol")]
    return done.returncode, *(path.read_text().splitlines() if path.exists() else [] for path in said)


def test_each_job_runs_its_part_and_one_whose_time_is_over_goes_on(tmp_path: Path):
    script = slurm_script(Path("a b/$(weak).toml"), Path("a b/weak.h5"), 40, " --device cpu")
    words = ["warpmuscle", "sweep", "a b/$(weak).toml", "--output", "a b/weak.h5", "--device", "cpu", "--part", "2/40"]
    assert submitted(tmp_path, script, 0) == (0, words, [])
    assert submitted(tmp_path, script, 2) == (2, words, [])
    assert submitted(tmp_path, script, 138) == (138, words, ["requeue", "77"])


def test_the_array_has_all_parts_and_a_name_without_odd_letters():
    lines = slurm_script(Path("s.toml"), Path("x y;rm.h5"), 7).splitlines()
    assert lines[0] == "#!/bin/bash"
    assert {"#SBATCH --array=1-7", "#SBATCH --job-name=x_y_rm", "#SBATCH --signal=USR1@300"} <= set(lines)
    with pytest.raises(Error, match="takes a number of parts"):
        slurm_script(Path("s.toml"), Path("s.h5"), 0)


def test_a_script_of_somebody_else_stays(tmp_path: Path):
    path = tmp_path / "s.slurm"
    write_slurm_script(path, slurm_script(Path("s.toml"), Path("s.h5"), 2))
    write_slurm_script(path, slurm_script(Path("s.toml"), Path("s.h5"), 3))
    assert "1-3" in path.read_text()
    path.write_text("#!/bin/bash\n")
    with pytest.raises(Error, match="was not made by --slurm"):
        write_slurm_script(path, "")
    assert path.read_text() == "#!/bin/bash\n"
