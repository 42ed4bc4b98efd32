"""Warp starts without its greeting and without its warning of a missing driver; what else it says is passed on."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from patience import PATIENCE
from warpmuscle.core.warp_start import FOLDERS, NO_DRIVER, _absolute_folders, _without

# For kernels that only one process needs, or two.
UNOPTIMIZED = "import warp; warp.config.optimization_level, warp.config.use_precompiled_headers = 0, False; "
USES = {
    "a rollout": "import warpmuscle as wm; wm.Rollout(wm.load('fwalk'), 1, 'cpu').run(0.01)",
    "moment arms": "import warpmuscle as wm; from warpmuscle.studies.moment_arms import useless_muscles as f; "
    "from warpmuscle.scene.parameters import start_values, substitute; s = wm.load('walk56'); "
    f"{UNOPTIMIZED}f(substitute(s, start_values(s)))",
    "the command line": f"{UNOPTIMIZED}import sys; sys.argv = ['warpmuscle', 'info', 'walk56']; "
    "from warpmuscle.__main__ import main; main()",
}  # fmt: skip


@pytest.mark.parametrize("code", USES.values(), ids=USES)
def test_nothing_of_warp_is_printed(code: str):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    for words in ("Warp 1", "Devices:", "CUDA", "Module "):
        assert words not in done.stdout + done.stderr
    slow = re.compile(r"(?m)^(starting|measuring|compiling) .*\n")  # what a slow machine, or one without kernels, says
    assert slow.sub("", done.stderr) == ""


def test_a_level_of_words_that_the_user_chose_stays():
    code = f"import warp as wp; wp.config.log_level = wp.LOG_DEBUG; {USES['a rollout']}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    assert "Kernel cache:" in done.stdout + done.stderr


def test_other_words_of_compiled_code_come_through(capfd: pytest.CaptureFixture[str]):
    with _without(NO_DRIVER):
        os.write(2, b"Warp CUDA warning: " + NO_DRIVER + b". GPU execution will not be available.\n")
        os.write(2, b"Warp CUDA error: Warp requires CUDA driver 12.0 or higher\n")
    assert capfd.readouterr().err == "Warp CUDA error: Warp requires CUDA driver 12.0 or higher\n"


def test_what_was_said_before_a_failure_comes_through(capfd: pytest.CaptureFixture[str]):
    with pytest.raises(RuntimeError), _without(NO_DRIVER):  # noqa: PT012
        os.write(2, b"a reason\n")
        raise RuntimeError
    assert capfd.readouterr().err == "a reason\n"


def test_warp_starts_where_there_is_no_error_stream(tmp_path: Path):
    code = "import os; os.close(2); import warpmuscle as wm; wm.Rollout(wm.load('fwalk'), 1, 'cpu'); print('there')"
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, timeout=PATIENCE)
    assert done.stdout == "there\n"


@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.parametrize("folder", ["", ".", "kernels", "./kernels", "~/kernels"])
def test_warp_does_not_see_folders_that_are_not_given_from_the_root_on(
    name: str, folder: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv(name, folder)
    with _absolute_folders():
        assert name not in os.environ
    assert os.environ[name] == folder
    monkeypatch.setenv(name, "/kernels")
    with _absolute_folders():
        assert os.environ[name] == "/kernels"


@pytest.mark.parametrize(("name", "folder"), [("XDG_CACHE_HOME", "kernels"), ("WARP_CACHE_PATH", "")])
def test_kernels_are_not_compiled_into_the_current_folder(name: str, folder: str, tmp_path: Path):
    code = (
        "from warpmuscle.core.warp_start import start_warp as f; f(); import warp; print(warp.config.kernel_cache_dir)"
    )
    kept = {key: value for key, value in os.environ.items() if key not in ("XDG_CACHE_HOME", "WARP_CACHE_PATH")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        cwd=tmp_path,
        env=kept | {name: folder},
    )
    assert done.returncode == 0, done.stderr
    assert not Path(done.stdout.strip()).is_relative_to(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_for_kernels_from_the_root_on_is_used(tmp_path: Path):
    code = (
        "from warpmuscle.core.warp_start import start_warp as f; f(); import warp; print(warp.config.kernel_cache_dir)"
    )
    environment = os.environ | {"WARP_CACHE_PATH": str(tmp_path / "kernels")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, env=environment
    )
    assert Path(done.stdout.strip()).is_relative_to(tmp_path / "kernels")
