"""What is published says the same everywhere, and can be read by those who take it."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_recipe_needs_what_the_package_needs_in_its_version():
    recipe = (ROOT / "tools" / "packaging" / "meta.yaml").read_text()
    assert f'version = "{PROJECT["version"]}"' in recipe
    run = recipe.partition("  run:\n")[2].partition("\ntest:")[0]
    needed = {re.sub(r"\s+", "", line.strip("- ")) for line in run.splitlines()}
    assert needed == {*PROJECT["dependencies"], f"python{PROJECT['requires-python']}"}


def test_the_image_installs_extras_that_there_are():
    image = (ROOT / "tools" / "packaging" / "Dockerfile").read_text()
    extras = re.search(r"/source\[([\w,]+)\]", image)
    assert extras is not None
    assert set(extras[1].split(",")) <= set(PROJECT["optional-dependencies"])


def test_the_page_on_installing_names_every_extra():
    page = (ROOT / "docs" / "how-to" / "install.md").read_text()
    rows = [line.split("|")[1] for line in page.partition("| extra |")[2].splitlines() if line.startswith("| `")]
    assert sorted(re.findall(r"`(\w+)`", " ".join(rows))) == sorted(PROJECT["optional-dependencies"])


@pytest.mark.parametrize("file", sorted((ROOT / ".github").rglob("*.yml")), ids=lambda file: file.name)
def test_workflows_and_templates_are_yaml(file: Path):
    yaml = pytest.importorskip("yaml")
    assert isinstance(yaml.safe_load(file.read_text()), dict)


def test_the_citation_is_of_this_version():
    assert f"\nversion: {PROJECT['version']}\n" in (ROOT / "CITATION.cff").read_text()
