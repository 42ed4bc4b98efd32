"""Whether every command and block of the manual works from an installed wheel, in empty folders.

    .venv/bin/python tools/wheel_tour.py                      # all pages
    .venv/bin/python tools/wheel_tour.py README.md tutorials  # those whose names hold one of these words

Builds the wheel, installs it into a new environment, and works through each page there as `tests/docs` does, with
small numbers; what needs PyTorch or Ray, where the environment has it (`--extras`). Commands that open the viewer are
started, asked for their page, and ended by Ctrl-C. Nothing of the checkout is in reach but the pages themselves.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "docs"))

from pages import PAGES, SHELL, blocks, is_ours  # noqa: E402

EXTRAS = "view,plot,video,synergies,c3d,gym,data"
PORT = 18200
PATIENCE = 300.0  # s, for a page of the manual


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="of names of pages")
    parser.add_argument("--extras", default=EXTRAS)
    parser.add_argument("--python", type=Path, help="of an environment that has the wheel already")
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells have what they start with `&` ignore it
    with tempfile.TemporaryDirectory() as folder:
        python = given.python.absolute() if given.python else installed(Path(folder), given.extras)
        failed = []
        for page in PAGES:
            name = str(page.relative_to(ROOT))
            if any(block.language in ("python", *SHELL) for block in blocks(page)) and (
                not given.words or any(word in name for word in given.words)
            ):
                place = Path(tempfile.mkdtemp(dir=folder))
                failed += [f"{name}: {why}" for why in tour(page, python, place)]
        print(*(failed or ["every page works"]), sep="\n")
    sys.exit(bool(failed))


def installed(folder: Path, extras: str) -> Path:
    """The Python of a new environment that has the wheel."""
    call([sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(ROOT)], folder)
    venv.create(folder / "env", with_pip=True)
    python = folder / "env" / "bin" / "python"
    wheel = next(folder.glob("*.whl"))
    begin = time.monotonic()
    call([str(python), "-m", "pip", "install", "-q", f"{wheel}[{extras}]"], folder)
    print(f"installed {wheel.name} in {time.monotonic() - begin:.0f} s")
    return python


def tour(page: Path, python: Path, folder: Path) -> list[str]:
    """What of a page does not work in an empty folder."""
    begin, before = time.monotonic(), spent()
    name = str(page.relative_to(ROOT))
    words = [str(python), str(ROOT / "tests" / "docs" / "session.py"), name, "--marked"]
    done = subprocess.run(words, cwd=folder, env=surroundings(), capture_output=True, text=True, timeout=PATIENCE * 4)
    failed = [] if done.returncode == 0 else [done.stderr.strip()[-600:]]
    shown = 0
    for block in blocks(page):
        if block.language in SHELL and not block.mark:
            for command in block.commands:
                if is_ours(command) and command[1:2] == ["view"] and "--export" not in command:
                    failed += view(command, python, folder)
                    shown += 1
    print(f"{'FAILED' if failed else 'ok':6} {name}: {spent() - before:.0f} CPU s, {time.monotonic() - begin:.0f} s, "
          f"{shown} viewers", flush=True)  # fmt: skip
    return failed


def view(words: list[str], python: Path, folder: Path) -> list[str]:
    """Start a viewer, fetch its page, and end it."""
    command = [str(python.parent / "warpmuscle"), *words[1:], "--no-open", "--port", str(PORT)]
    process = subprocess.Popen(
        command, cwd=folder, env=surroundings(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    address = process.stdout.readline().split()
    found = bool(address) and b"<canvas" in urllib.request.urlopen(address[0], timeout=PATIENCE).read()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE)
    return [] if found and process.returncode == 130 else [f"{' '.join(words)}: {process.returncode} {errors[-400:]}"]


def surroundings() -> dict[str, str]:
    """Variables without a way to the checkout."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    return kept | {"MPLBACKEND": "agg"}


def spent() -> float:
    """CPU seconds of what has been run."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def call(words: list[str], folder: Path) -> None:
    """Run a command that has to work."""
    subprocess.run(words, cwd=folder, env=surroundings(), check=True)


if __name__ == "__main__":
    main()
