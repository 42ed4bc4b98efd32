"""What makes figures and tables of a page says of which one, and every tool is named by somebody."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RESEARCH = sorted((ROOT / "tools" / "research").rglob("*.py"))
TOOLS = [*sorted((ROOT / "tools").glob("*.py")), *RESEARCH]
PAGES = [ROOT / "CONTRIBUTING.md", ROOT / "mkdocs.yml", *(ROOT / "docs").rglob("*.md*")]


@pytest.mark.parametrize("tool", RESEARCH, ids=lambda tool: tool.stem)
def test_a_tool_of_research_names_the_page_that_uses_it(tool: Path):
    page = re.search(r"^For (docs/[\w/-]+\.md)\.$", tool.read_text(), re.MULTILINE)
    assert page, "no line such as `For docs/explanation/gaits.md.`"
    text = (ROOT / page[1]).read_text()
    named = tool.relative_to(ROOT).as_posix() in text or imported(tool)
    assert named or f"{tool.relative_to(ROOT).parent.as_posix()}/NAME.py" in text


@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool.stem)
def test_no_tool_is_there_that_nothing_names(tool: Path):
    pages = "".join(page.read_text() for page in PAGES)
    assert f"{tool.stem}.py" in pages or ("NAME.py" in pages and tool.parent.name == "experiments") or imported(tool)


def imported(tool: Path) -> bool:
    """Whether another tool imports this one."""
    pattern = re.compile(rf"^\s*(from|import) {tool.stem}\b", re.MULTILINE)
    return any(pattern.search(other.read_text()) for other in TOOLS if other != tool)
