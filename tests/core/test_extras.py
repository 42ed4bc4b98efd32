"""Commands that need an extra say so before any work, whatever else is wrong with what they are given."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error
from warpmuscle.core.extras import EXTRAS, imported

FIND = importlib.util.find_spec


@pytest.mark.parametrize(
    ("missing", "words", "says"),
    [
        ("sklearn", ["throw", "fit", "none.csv"], r"need scikit-learn: pip install 'warpmuscle\[synergies\]'"),
        ("sklearn", ["throw", "goal", "--target", "2"], r"need scikit-learn: pip install 'warpmuscle\[synergies\]'"),
        ("sklearn", ["synergies", "extract", "none.csv"], "need scikit-learn"),
        ("sklearn", ["synergies", "cluster", "none.h5", "no.h5"], "need scikit-learn"),
        ("matplotlib", ["throw", "fit", "none.csv", "--plot", "a.png"], r"pip install 'warpmuscle\[plot\]'"),
        ("matplotlib", ["throw", "fit", "none.csv", "--plot-each", "figures"], r"pip install 'warpmuscle\[plot\]'"),
        ("matplotlib", ["synergies", "extract", "none.csv", "--plot", "a.svg"], r"pip install 'warpmuscle\[plot\]'"),
        ("matplotlib", ["simulate", "fwalk", "--plot", "a.png"], r"pip install 'warpmuscle\[plot\]'"),
        ("matplotlib", ["report", "none.h5", "-o", "a.html"], r"pip install 'warpmuscle\[plot\]'"),
        (
            "matplotlib",
            ["video", "none.h5", "-o", "a.webp"],
            r"a film needs matplotlib: pip install 'warpmuscle\[plot\]'",
        ),
        ("jinja2", ["report", "none.h5", "-o", "a.html"], r"pip install 'warpmuscle\[plot\]'"),
        ("jinja2", ["patient", "none.toml"], "a report page needs jinja2"),
        ("jinja2", ["adaptation", "none.json"], "a report page needs jinja2"),
        ("matplotlib", ["study", "none.toml"], "a report page needs matplotlib"),
    ],
)
def test_an_extra_is_asked_for_before_any_file_is_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, missing: str, words: list[str], says: str
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == missing else FIND(name, *rest))
    result = CliRunner().invoke(app, words)
    assert isinstance(result.exception, Error), result.output
    with pytest.raises(Error, match=says):
        raise result.exception
    assert list(tmp_path.iterdir()) == []


def test_whatever_may_be_lacking_is_known_with_its_extra():
    asked = set()
    for file in (Path(__file__).parents[2] / "warpmuscle").rglob("*.py"):
        asked |= set(re.findall(r"(?<![.\w])(?:need|imported)\(\"(\w+)[\".]", file.read_text()))
    assert {"pandas", "xarray", "sklearn"} <= asked
    assert asked <= set(EXTRAS)


@pytest.mark.parametrize("module", ["pandas", "sklearn.cluster"])
def test_what_is_imported_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch, module: str):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(Error, match=r"a table needs .*: pip install 'warpmuscle\["):
        imported(module, "a table needs")
