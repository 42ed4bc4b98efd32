"""Every tool finds what it uses of the package."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("tools", "tools/research", "tools/research/experiments")
TOOLS = sorted(path.relative_to(ROOT) for folder in FOLDERS for path in (ROOT / folder).glob("*.py"))


@pytest.mark.parametrize("tool", TOOLS, ids=str)
def test_a_tool_can_be_imported(tool: Path, monkeypatch: pytest.MonkeyPatch):
    if "import torch" in (ROOT / tool).read_text():
        pytest.importorskip("torch", reason='no PyTorch: pip install "warpmuscle[learn]"')
    monkeypatch.syspath_prepend(str((ROOT / tool).parent))
    assert runpy.run_path(str(ROOT / tool))["__doc__"]
