"""A training bears real kills of its process."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="learning needs PyTorch")

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from kill_trainings import killed_and_resumed  # noqa: E402


def test_after_kills_of_its_process_a_training_comes_to_the_same_bits(tmp_path: Path):
    assert killed_and_resumed(tmp_path, 2, 60, seed=3) == (2, [])
