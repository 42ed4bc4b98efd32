"""A wheel and a source distribution hold all that the program needs: they run from an empty folder."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from patience import PATIENCE

ROOT = Path(__file__).parents[1]
SOURCES = ("warpmuscle", "pyproject.toml", "setup.py", "README.md", "LICENSE")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a source distribution of a copy of the tree, and the wheel that is built of that."""
    pytest.importorskip("build", reason="no build: pip install build")
    folder = tmp_path_factory.mktemp("dist")
    copy = folder / "tree"
    copy.mkdir()
    for name in SOURCES:  # building leaves files behind, and the tree may be read by others meanwhile
        subprocess.run(["cp", "-r", str(ROOT / name), str(copy)], check=True)
    done = subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(copy)],
        capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return folder


def names(folder: Path) -> set[str]:
    """Files of the wheel."""
    return set(zipfile.ZipFile(next(folder.glob("*.whl"))).namelist())


def test_the_wheel_that_the_source_distribution_makes_holds_all_files_of_the_packages(built: Path):
    wanted = {
        str(file.relative_to(ROOT))
        for file in (ROOT / "warpmuscle").rglob("*.*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    assert wanted - names(built) == set()
    with tarfile.open(next(built.glob("*.tar.gz"))) as archive:
        assert any(name.endswith("/LICENSE") for name in archive.getnames())


def test_the_wheel_runs_from_an_empty_folder(built: Path, tmp_path: Path):
    library, empty = tmp_path / "library", tmp_path / "empty"
    empty.mkdir()
    zipfile.ZipFile(next(built.glob("*.whl"))).extractall(library)
    variables = os.environ | {"PYTHONPATH": str(library), "PYTHONDONTWRITEBYTECODE": "1"}

    def run(*words: str) -> str:
        command = [sys.executable, "-m", "warpmuscle", *words]
        done = subprocess.run(command, cwd=empty, env=variables, capture_output=True, text=True, timeout=PATIENCE)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    where = "import warpmuscle, warpmuscle.kernels; print(warpmuscle.__file__, warpmuscle.kernels.__file__)"
    shown = subprocess.run([sys.executable, "-c", where], cwd=empty, env=variables, capture_output=True, text=True)
    assert shown.stdout.count(str(library)) == 2
    assert "simulate" in run("--help")
    assert "walk56_human" in run("scenes")
    assert "0.1 s simulated" in run("simulate", "fwalk", "--duration", "0.1", "--device", "cpu", "-o", "walk.h5")
    assert (empty / "walk.h5").is_file()
    assert "knees.toml" in run("example", "muscles")


def test_the_description_for_indexes_has_no_picture_or_link_that_leads_nowhere(built: Path):
    wheel = zipfile.ZipFile(next(built.glob("*.whl")))
    metadata = wheel.read(next(name for name in names(built) if name.endswith("METADATA"))).decode()
    assert "Description-Content-Type: text/markdown" in metadata
    assert "warpmuscle optimize stumble56" in metadata
    assert "How gaits are measured" in metadata
    links = re.findall(r"\]\(([^)]*)\)", metadata)
    assert links
    assert all(link.startswith("https://") for link in links)
