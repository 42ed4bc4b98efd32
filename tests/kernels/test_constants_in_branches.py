"""No function reads a constant that Warp may have left without a value.

What both branches of an `if` name first becomes a variable there: chosen behind them, and what comes later reads it.
Where that `if` is itself in a branch or a loop that is not always entered, nothing has been chosen.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

KERNELS = Path(__file__).resolve().parents[2] / "warpmuscle" / "kernels"
BLOCKS = (ast.If, ast.For, ast.While)

TRAP = """
def renew(memory):
    if memory[0] == 2.0:
        if memory[1] > 0.0:
            memory[PHASE] = 1.0
        else:
            memory[PHASE] = 0.0
    memory[PHASE] = memory[PHASE] + 1.0
"""


def constants(node: ast.AST) -> set[str]:
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name) and one.id.isupper()}


def named_in(body: list[ast.stmt]) -> set[str]:
    return {name for statement in body for name in constants(statement)}


def head(statement: ast.If | ast.For | ast.While) -> ast.expr:
    """What is looked at before a block is entered."""
    return statement.iter if isinstance(statement, ast.For) else statement.test


def chosen(body: list[ast.stmt], known: set[str]) -> set[str]:
    """Constants that some `if` in a body, at any depth, chooses between its branches, known ones apart."""
    found, known = set[str](), set(known)
    for statement in body:
        if not isinstance(statement, BLOCKS):
            known |= constants(statement)
            continue
        known |= constants(head(statement))
        if isinstance(statement, ast.If):
            found |= (named_in(statement.body) & named_in(statement.orelse)) - known
        for part in (statement.body, statement.orelse):
            found |= chosen(part, known)
    return found


def left_without(body: list[ast.stmt], known: set[str]) -> set[str]:
    """Constants that a body reads behind a block in which alone they may have got their values."""
    found, known, waiting = set[str](), set(known), set[str]()
    for statement in body:
        found |= constants(statement) & waiting
        if not isinstance(statement, BLOCKS):
            known |= constants(statement)
            continue
        known |= constants(head(statement))
        for part in (statement.body, statement.orelse):
            found |= left_without(part, known)
            waiting |= chosen(part, known) - known
    return found


def functions(source: str) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef))


def test_the_check_finds_a_constant_that_two_nested_branches_name_first():
    (function,) = functions(TRAP)
    assert left_without(function.body, set()) == {"PHASE"}
    (function,) = functions(TRAP.replace("memory[0] == 2.0", "memory[PHASE] == 2.0"))
    assert not left_without(function.body, set())


def test_no_kernel_reads_a_constant_without_a_value():
    paths = sorted(KERNELS.rglob("*.py"))
    every = [(path.name, one) for path in paths for one in functions(path.read_text())]
    assert len(every) > 1000
    found = [(name, one.name, left) for name, one in every if (left := left_without(one.body, set()))]
    assert found == []
