"""The command that learns, and those that take what it has learnt."""

import subprocess
import sys
from pathlib import Path

import pytest

from warpmuscle.formats import toml
from warpmuscle.results.result import read

FILES = Path(__file__).parents[2] / "warpmuscle" / "examples" / "files"


def warpmuscle(folder, *words):
    """Exit code, and what was printed on either stream, of a command in a folder."""
    command = [sys.executable, "-m", "warpmuscle", *map(str, words)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    said = "\n".join(line for line in done.stderr.splitlines() if "Warp" not in line)
    return done.returncode, done.stdout, said


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a scene and the policy that was learnt in it."""
    pytest.importorskip("torch", reason="learning needs PyTorch")
    folder = tmp_path_factory.mktemp("learn")
    followed = "gravity = { value = 9.81, per = { heavier = 1.0 } }\n"
    command = '\n[commands]\nheavier = { reference = 0, min = 0, max = 5, unit = "m/s^2" }\n'
    (folder / "reaching.toml").write_text(followed + (FILES / "reaching.toml").read_text() + command)
    words = ["--iterations", 2, "--instances", 4, "--option", "hidden=[16]", "--device", "cpu", "-o", "p.h5"]
    code, told, said = warpmuscle(folder, "learn", "reaching.toml", *words)
    assert code == 0, said
    assert "2 iterations" in told
    assert "4 of 4 last 4 s, return" in told
    assert "wrote p.h5" in told
    return folder


def test_a_policy_moves_the_scene_and_is_reported(folder):
    asked = ["simulate", "reaching.toml", "--policy", "p.h5", "-c", "shoulder=1", "-c", "heavier=4", "-o", "s.h5"]
    code, told, said = warpmuscle(folder, *asked, "--device", "cpu")
    assert code == 0, said
    assert "wrote s.h5" in told
    assert "heavier 4 m/s^2" in told
    assert "warning" not in said
    assert toml.loads(read(folder / "s.h5").scene).commands["heavier"].value == 4.0
    code, told, said = warpmuscle(folder, "report", "p.h5")
    assert code == 0, said
    assert "observations, layers of 16-6, 6 actions" in told
    assert "made by: warpmuscle learn reaching.toml" in told
    code, told, said = warpmuscle(folder, "plot", "p.h5", "--what", "convergence", "-o", "curve.png")
    assert code == 0, said
    assert (folder / "curve.png").stat().st_size > 10_000


def test_a_training_begins_with_the_policy_of_a_file(folder):
    words = ["--iterations", 1, "--instances", 4, "--device", "cpu", "-o", "q.h5"]
    code, told, said = warpmuscle(folder, "learn", "reaching.toml", "--from", "p.h5", *words)
    assert code == 0, said
    assert "begun with p.h5: seed 1" in told
    assert "hidden (16,)" in warpmuscle(folder, "report", "q.h5")[1]


def test_a_command_beyond_what_was_learnt_is_said_to_be_so(folder):
    asked = ["simulate", "reaching.toml", "--policy", "p.h5", "-c", "shoulder=2.2", "--device", "cpu"]
    code, _, said = warpmuscle(folder, *asked)
    assert code == 0, said
    assert "warning: shoulder = 2.2 rad or m: the policy has learnt" in said.replace("\n", " ")


MISTAKES = {
    "no scene": (["learn"], "learn takes a scene"),
    "no time": (["learn", "reaching.toml", "--until", "soon"], "is not a time"),
    "unknown option": (["learn", "reaching.toml", "--option", "epoch=3"], "no option 'epoch'"),
    "resume and seed": (["learn", "--resume", "p.h5", "--seed", 3], "--seed cannot be given with --resume"),
    "resume and from": (["learn", "--resume", "p.h5", "--from", "p.h5"], "--from cannot be given with --resume"),
    "from itself": (["learn", "reaching.toml", "--from", "p.h5", "-o", "p.h5"], "would replace the policy"),
    "nothing to resume": (["learn", "--resume", "none.h5"], "no training to go on with"),
    "no policy": (["simulate", "reaching.toml", "--policy", "reaching.toml"], "not an HDF5 file"),
    "of another scene": (["simulate", "fwalk", "--policy", "p.h5", "--device", "cpu"], "scene reaching, not for fwalk"),
    "not live": (["view", "reaching.toml", "--policy", "p.h5"], "takes no --policy"),
    "too much": (["simulate", "reaching.toml", "--policy", "p.h5", "-c", "heavier=9"], "heavier is 0 to 5 m/s^2"),
    "unknown command": (["simulate", "reaching.toml", "--policy", "p.h5", "-c", "hip=1"], "KEY is speed, turning_rate"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_line(name, folder):
    words, message = MISTAKES[name]
    code, _, said = warpmuscle(folder, *words)
    assert code == 2, said
    assert message in said.replace("\n", " ")
    assert "Traceback" not in said


def test_a_policy_is_written_for_other_programs(tmp_path):
    onnx = pytest.importorskip("onnx", reason="the extra `onnx` is not installed")
    code, told, said = warpmuscle(tmp_path, "export", FILES / "walk56_tasks.h5", "-o", "walk.onnx")
    assert code == 0, said
    assert "wrote walk.onnx: " in told
    assert onnx.load(tmp_path / "walk.onnx").graph.input[0].name == "observation"
    code, _, said = warpmuscle(tmp_path, "export", FILES / "walk56_tasks.h5", "-o", "w.onnx", "--replay", 1)
    assert code == 2
    assert "a policy has no motions" in said.replace("\n", " ")


def test_who_cannot_write_a_policy_is_told_what_to_install(tmp_path):
    hidden = "import sys; sys.modules['onnx'] = None; from warpmuscle.__main__ import main; main()"
    command = [sys.executable, "-c", hidden, "export", str(FILES / "walk56_tasks.h5"), "-o", "walk.onnx"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stderr
    assert 'pip install "warpmuscle[onnx]"' in said.replace("\n", " ")
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir())
