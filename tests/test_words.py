"""One word, one meaning: names of classes."""

import ast
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1] / "warpmuscle"
ONCE = {"Motion", "Force", "Row", "Run", "Term", "State", "Controller", "Progress", "Options"}


def test_names_that_could_mean_anything_name_one_class_of_the_host_at_most():
    places = defaultdict(list)
    for file in sorted(ROOT.rglob("*.py")):
        if ROOT / "kernels" in file.parents:
            continue  # where a structure of the device has the name of what it is made from
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ClassDef) and node.name in ONCE:
                places[node.name].append(f"{file.relative_to(ROOT)}:{node.lineno}")
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_a_name_of_before_says_what_it_is_called_now():
    with pytest.raises(ImportError, match="is called JointKinematics now"):
        from warpmuscle.scene.joints import Motion  # noqa: F401
