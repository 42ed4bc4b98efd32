"""The tiers of tests: what keeps a file out of the fast one, and who compiles what several workers need."""

import subprocess
import sys
import threading
from pathlib import Path

import pytest

from kernel_tests import alone
from tiers import ROOT, SLOW, is_fast, slow_import

SHARED = (str(ROOT / "tests"),)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("import numpy as np\nfrom warpmuscle.scene import Scene\nfrom warpmuscle import core\n", ""),
        ("import warp as wp\n", "warp"),
        ("import warpmuscle as wm\n", "warpmuscle"),
        ("def test_a():\n    from warpmuscle.simulation import rollout\n", "warpmuscle.simulation"),
        ("from warpmuscle import kernels\n", "warpmuscle.kernels"),
        ("from small_leg import motion\n", "warpmuscle.inverse"),
        ("from warpmuscle.model.build import build_model\n", "warpmuscle.model.build"),
        ("from warpmuscle.model.routes import fixed_segments\n", ""),
        ("import os, subprocess\n", "subprocess"),
        (
            "from warpmuscle.scene import (  # (many)\n    Body,\n    Scene,\n)\nimport subprocess  # of tests\n",
            "subprocess",
        ),
        ("from warpmuscle import (\n    kernels,\n)\n", "warpmuscle.kernels"),
        ("CODE = '''\nimport warp as wp\n'''\n", ""),
        ('def test_a():\n    """A.\n\n    import warp\n    """\n    # import warp\n', ""),
        ('run("\\"", """\nimport warp\n""")\n', ""),
    ],
)
def test_what_compiles_or_starts_processes_keeps_a_file_out_also_by_way_of_helpers(text: str, why: str, tmp_path: Path):
    file = tmp_path / "test_a.py"
    file.write_text(text)
    found = slow_import(file, SHARED)
    assert found.startswith(why)
    assert is_fast(file, SHARED) == (why == "")


def test_packages_and_modules_that_are_slow_are_there():
    places = {name: ROOT / name.replace(".", "/") for name in SLOW if name.startswith("warpmuscle.")}
    assert [
        name for name, place in places.items() if not place.is_dir() and not place.with_suffix(".py").exists()
    ] == []


def test_a_fast_test_that_launches_a_kernel_fails(tmp_path: Path):
    (tmp_path / "conftest.py").write_text((ROOT / "tests" / "conftest.py").read_text())
    (tmp_path / "test_hidden.py").write_text(
        "from importlib import import_module\n"
        "def test_launches():\n    import_module('warp').zeros(3, dtype=float, device='cpu')\n"
        "def test_computes():\n    assert 1 + 1 == 2\n"
    )
    words = [
        "-m",
        "pytest",
        "-n",
        "0",
        "-q",
        "-p",
        "no:cacheprovider",
        "-c",
        str(ROOT / "pyproject.toml"),
        "-m",
        "fast",
    ]
    done = subprocess.run(
        [sys.executable, *words, "--rootdir", str(ROOT), str(tmp_path)], cwd=ROOT, capture_output=True, text=True
    )
    assert "a fast test launches no kernel" in done.stdout, done.stdout + done.stderr
    assert "2 passed, 1 error" in done.stdout


def test_what_one_compiles_others_wait_for(tmp_path: Path):
    order, inside = [], threading.Event()

    def other() -> None:
        inside.wait()
        with alone(tmp_path / "folder" / "module"):
            order.append("other")

    waiting = threading.Thread(target=other)
    waiting.start()
    with alone(tmp_path / "folder" / "module"):
        inside.set()
        waiting.join(0.2)
        order.append("first")
    waiting.join()
    assert order == ["first", "other"]
