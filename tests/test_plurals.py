"""Texts that count things say "1 joint" and "2 joints": none has a bare number before a noun in the plural."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
FILES = sorted((ROOT / "warpmuscle").rglob("*.py"))
# Words in s that are no nouns, behind which a name or a quantity stands.
NO_NOUNS = {
    "across", "acts", "adds", "as", "begins", "changes", "chooses", "continues", "decides", "differs", "does",
    "exists", "fails", "follows", "gives", "goes", "has", "holds", "is", "its", "lacks", "lands", "leaves",
    "less", "lets", "lies", "makes", "means", "meets", "moves", "needs", "plus", "reaches", "reads", "says",
    "shows", "stands", "starts", "takes", "this", "us", "was", "weighs", "writes",
}  # fmt: skip
NOUN = re.compile(r" ((?:(?!of |to |at |in |on |and |or |for )[a-z-]+ )??)([a-z]+s)\b(?! *\()")
# Counts that are never one, with the noun behind them.
MANY = {
    "muscles": ("count", "side.capitalize()"),  # of those that drive joints, others do not; and no number
    "minibatches": ("options.minibatches",),  # more than there are numbers
    "curves": ("curves",),  # a name
    "cycles": ("count",),  # several, or another text
    "beats": ("rates",),  # a text
    "times": ("RETRIES + 1",),
    "starts": ("self.name", "deepest"),
    "quaternions": ("(frames, 4)",),
    "kernels": ("missing[0]",),
    "moments": ("body.mass",),
    "ws": ("HEADERS[POLICY]",),
    "wss": ("host",),
}  # fmt: skip


def counted(source: str) -> Iterator[tuple[int, str]]:
    """Lines of numbers before nouns in the plural in f-strings, and what stands there.

    Rounded quantities with a unit ("5 degrees") have a format; constants are capitals, and more than one.
    """
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.JoinedStr):
            continue
        for number, text in zip(node.values, node.values[1:], strict=False):
            if not isinstance(number, ast.FormattedValue) or not isinstance(text, ast.Constant):
                continue
            found, value = NOUN.match(str(text.value)), ast.unparse(number.value)
            plain = number.format_spec is None and number.conversion == -1
            if found is None or not plain or found[2] in NO_NOUNS or found[1].strip() in NO_NOUNS:
                continue
            if (
                re.fullmatch(r"[\w.]*?[A-Z_]+", value)
                or value.startswith("number_of(")
                or value in MANY.get(found[2], ())
            ):
                continue
            yield node.lineno, f"{{{value}}}{found[0]}"


def test_numbers_of_things_agree_with_their_noun():
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: {words}: write {{number_of(...)}}"
        for path in FILES
        for line, words in counted(path.read_text("utf-8"))
    ]
    assert not wrong, "\n".join(wrong)


def test_a_bare_plural_is_found():
    assert [words for _, words in counted('f"{len(joints)} joints and {number} free parameters"')] == [
        "{len(joints)} joints", "{number} free parameters",
    ]  # fmt: skip
    assert not list(counted("f\"{number_of(n, 'joint')}, {MOST} joints, {angle:.0f} degrees, {name} has\""))
