"""A script for the scheduler Slurm that runs a sweep as an array of jobs, one a part."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.sweep.part import MOST_PARTS

NOTICE = 300  # s before the end of its time, when a job is asked to end
_MADE = "# Made by `warpmuscle sweep --slurm`."
_SCRIPT = """#!/bin/bash
{made} Add what your cluster asks for, such as --partition, --account, --time and --gres=gpu:1.
#SBATCH --job-name={name}
#SBATCH --array=1-{parts}
#SBATCH --output={name}.%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=USR1@{notice}

srun warpmuscle sweep {file} --output {output}{more} --part "$SLURM_ARRAY_TASK_ID/{parts}"
code=$?
# Ended by a signal (128 and its number), such as at the end of its time: what was evaluated is kept. Go on.
if [ "$code" -gt 128 ]; then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$code"
"""


def slurm_script(file: Path, output: Path, parts: int, more: str = "") -> str:
    """The text of a script for `sbatch`.

    Args:
        more: further options of the command, as in a shell, such as " --device cpu".

    Raises:
        Error: no sweep has so many parts.
    """
    if not 1 <= parts <= MOST_PARTS:
        raise Error(f"--slurm {parts}: takes a number of parts from 1 to {MOST_PARTS}")
    name = re.sub(r"[^A-Za-z0-9._-]", "_", output.stem)
    quoted = shlex.quote(str(file)), shlex.quote(str(output))
    return _SCRIPT.format(
        made=_MADE, name=name, parts=parts, notice=NOTICE, file=quoted[0], output=quoted[1], more=more
    )


def write_slurm_script(path: Path, text: str) -> None:
    """Write a script, which may replace an earlier one; raises Error if it cannot, or another file is there."""
    if path.exists():
        try:
            earlier = path.read_text(errors="replace")
        except OSError:
            earlier = ""
        if _MADE not in earlier:
            raise Error(f"{path}: would be replaced, and was not made by --slurm; move it out of the way")
    replace_file(path, text)
