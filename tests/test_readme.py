"""README.md: what it names is there, and the two commands that CI mirrors are the ones of CI."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text()


def test_files_that_the_readme_names_are_there():
    linked = re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT)
    assert len(linked) > 10
    assert [path for path in linked if not (ROOT / path).exists()] == []


def test_the_tests_are_run_by_the_command_of_ci():
    tests = TEXT.partition("Run the tests:\n\n```sh\n")[2].partition("\n```")[0]
    install, run = (part.replace(".venv/bin/", "").replace('"', "") for part in tests.split(" && "))
    ci = (ROOT / ".ci" / "run").read_text().replace('"', "").replace("$environment/bin/", "")
    assert install.removeprefix("pip install ") in ci
    assert run in ci.splitlines()


def test_the_citation_is_of_this_version():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()
