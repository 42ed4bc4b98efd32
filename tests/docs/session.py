"""Works through one page of the documentation as a reader would, in the current folder, with small numbers.

python session.py PAGE [--marked]

With `--marked` it also does what is marked as needing PyTorch, Ray or a policy, where the package is installed.
"""

from __future__ import annotations

import importlib.util
import re
import runpy
import sys
from glob import glob
from pathlib import Path

from pages import ROOT, SHELL, Block, blocks, is_ours

FEW = 12  # candidates of a search
SMALL = {"--candidates": str(FEW), "--until": "2s", "--searches": "2", "--population": "4", "--most-robust": "2"}
SMALL["--pushes"] = "1"
SMALL_CODE = {'"walk56", 4096': '"walk56", 8', "range(1000)": "range(3)", "until=120": "until=1", "until=60": "until=1"}
SMALL_CODE |= {"instances=100": "instances=4", "(100, len(": "(4, len("}
NEEDED = {"needs PyTorch": "torch", "needs the policy": "torch", "needs Ray": "ray"}  # modules, by what a mark says


def work_through(page: Path, marked: bool) -> None:
    """Run what a page has, block by block."""
    for block in blocks(page):
        if block.title:
            put(block)
        elif block.mark and not (marked and has_what_it_needs(block.mark)):
            continue
        elif block.language in SHELL:
            for words in block.commands:
                run(block, words)
        elif block.language == "python":
            file = Path(f"block{block.line}.py").absolute()
            text = block.text
            for large, small in SMALL_CODE.items():
                text = text.replace(large, small)
            file.write_text(text)  # Warp reads the source of kernels from their file
            runpy.run_path(str(file))


def has_what_it_needs(mark: str) -> bool:
    """Whether what a mark says is missing in tests is there."""
    modules = [module for words, module in NEEDED.items() if words in mark]
    return bool(modules) and all(importlib.util.find_spec(module) for module in modules)


def put(block: Block) -> None:
    """Write a file of the page; one that an example has written must be the same."""
    path = Path(block.title)
    if path.exists() and path.read_text() != block.text:
        raise SystemExit(f"{block}: {block.title} is not what `warpmuscle example` writes")
    path.write_text(block.text)


def run(block: Block, words: list[str]) -> None:
    """Run a command of this program, but for those that wait for somebody."""
    if not is_ours(words) or (words[1] == "view" and "--export" not in words) or "--install-completion" in words:
        return
    for file in Path().glob("*.toml"):
        file.write_text(re.sub(r"^candidates = \d\d+", f"candidates = {FEW}", file.read_text(), flags=re.M))
    from warpmuscle.cli.program import main

    small = smaller(words)
    sys.argv = ["warpmuscle", *small]
    print("$", *sys.argv, flush=True)
    try:
        main()
    except SystemExit as done:
        if done.code not in (0, None):
            raise SystemExit(f"{block}: `{' '.join(words)}` ended with code {done.code}") from None


def smaller(words: list[str]) -> list[str]:
    """The arguments of a command with small numbers, and with the files that its patterns stand for."""
    arguments = words[1:]
    for place, word in enumerate(arguments[:-1]):
        if word in SMALL and arguments[place + 1] != "none":
            arguments[place + 1] = SMALL[word]
    if arguments[0] == "optimize" and "--candidates" not in arguments and "--until" not in arguments:
        arguments += ["--candidates", str(FEW)]
    found = [sorted(glob(word)) if "*" in word and "/" in word and "=" not in word else [word] for word in arguments]
    return [word for words in found for word in words or ["*"]]


if __name__ == "__main__":
    work_through(ROOT / sys.argv[1], "--marked" in sys.argv[2:])
