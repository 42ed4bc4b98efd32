"""One word, one meaning: names of classes."""

import ast
import re
import tokenize
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "warpmuscle"
DOCS = ROOT.parent / "docs"
ONCE = {"Motion", "Force", "Row", "Run", "Term", "State", "Controller", "Progress", "Options"}


@cache
def definitions() -> list[tuple[Path, int, str, type[ast.AST]]]:
    """File, line, name and kind of every class, function, constant and field of the package."""
    found = []
    for file in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [node.name] if isinstance(node, ast.ClassDef | ast.FunctionDef) else []
            if isinstance(node, ast.ClassDef):
                fields = [one.target for one in node.body if isinstance(one, ast.AnnAssign)]
                names += [field.id for field in fields if isinstance(field, ast.Name)]
            if isinstance(node, ast.Module):
                targets = [target for one in node.body if isinstance(one, ast.Assign) for target in one.targets]
                names += [target.id for target in targets if isinstance(target, ast.Name)]
            found += [(file, getattr(node, "lineno", 1), name, type(node)) for name in names]
    return found


def test_names_that_could_mean_anything_name_one_class_of_the_host_at_most():
    places = defaultdict(list)
    for file, line, name, kind in definitions():
        # In kernels a structure of the device has the name of what it is made from.
        if kind is ast.ClassDef and name in ONCE and ROOT / "kernels" not in file.parents:
            places[name].append(f"{file.relative_to(ROOT)}:{line}")
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


PRIVATE = re.compile(
    r"\b(crowded|roomy|at_hand|afresh|hardiest|half-bands?|hangs? up|each with its line"
    r"|(come|comes|came) to (its|their) end)\b"
)


def test_no_word_of_our_own_making_is_in_the_manual_or_in_what_commands_say():
    texts = [*DOCS.rglob("*.md"), *DOCS.rglob("*.in"), *(ROOT / "cli").rglob("*.py")]
    found = [
        f"{path.relative_to(ROOT.parent)}:{number}: {line.strip()}"
        for path in texts
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if PRIVATE.search(line) and "--hardiest is called" not in line and "hardiest: Annotated" not in line
    ]
    assert found == []


UNCLEAR = {"told", "lap", "afresh", "roomy", "crowded", "hardiest"}  # what is told, and of what?
PARTS = re.compile(rf"(?<![a-z])({'|'.join(UNCLEAR)})(?![a-z])", re.IGNORECASE)  # in names, and in other text


def test_no_name_in_the_package_is_one_of_the_unclear_words():
    found = []
    for file in sorted(ROOT.rglob("*.py")):
        if not PARTS.search(file.read_text()):
            continue
        with file.open("rb") as source:
            names = [token for token in tokenize.tokenize(source.readline) if token.type == tokenize.NAME]
        found += [f"{file.relative_to(ROOT)}:{name.start[0]}: {name.string}" for name in names
                  if UNCLEAR & set(name.string.lower().split("_"))]  # fmt: skip
    assert [place for place in found if not place.endswith(": hardiest")] == []  # of an option


STAND_INS = {"own", "whole", "rolled", "together"}  # of whom, of what?


def test_no_class_function_constant_or_field_is_named_by_a_word_that_stands_for_its_subject():
    found = []
    for file, _, name, _ in definitions():
        words = re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower().split("_")
        found += [f"{file.relative_to(ROOT)}: {name}"] if STAND_INS & set(words) else []
    assert found == []


def test_the_glossary_has_sixty_words_at_most():
    lines = (DOCS / "glossary.md").read_text().splitlines()
    words = [line for line in lines if line.startswith("| ") and not line.startswith("| term of")]
    assert 30 < len(words) <= 60


def test_a_name_of_before_says_what_it_is_called_now():
    with pytest.raises(ImportError, match="is called JointKinematics now"):
        from warpmuscle.scene.joints import Motion  # noqa: F401
