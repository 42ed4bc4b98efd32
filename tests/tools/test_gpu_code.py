"""The code of a GPU is compiled where there is none."""

import sys
from pathlib import Path

import pytest
import warp as wp

ROOT = Path(__file__).parents[2]
if str(ROOT / "tools") not in sys.path:
    sys.path.append(str(ROOT / "tools"))

from gpu_code import compile_step, main  # noqa: E402


@pytest.mark.skipif(wp.get_cuda_supported_archs() == [], reason="this Warp compiles for no GPU")
def test_the_step_of_a_walk_on_stairs_is_compiled_for_a_gpu(tmp_path: Path):
    made = compile_step("bwalk_stairs", 90, tmp_path)
    assert made
    assert all(file.read_bytes().startswith(b"\x7fELF") for file in made)


def test_a_scene_that_is_not_there_is_told_and_counted(capsys: pytest.CaptureFixture[str]):
    assert main(["no_such_scene"]) == 1
    assert "no_such_scene: SceneError" in capsys.readouterr().out
