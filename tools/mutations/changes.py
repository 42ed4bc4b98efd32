"""Small changes of Python source that should change what is computed: made of the syntax tree, applied to the text.

Left out is what computes nothing (docstrings, messages, annotations, decorators, functions that return text) and what
can be told to be the same, such as the two sides of a maximum swapped, bounds of what is a number at all, and flags
that kernels have by default, since the host gives them all, what only tells a compiler more, and a value and its lower
bound swapped, of which the greater one is taken. What no rule can tell stands in `equal.py`.
"""

from __future__ import annotations

import ast
import hashlib
import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mutations.equal import EQUAL, EQUAL_CHANGES

PHYSICS = ("warpmuscle/kernels", "warpmuscle/model", "warpmuscle/gait", "warpmuscle/studies")
NO_PHYSICS = (  # how memory is laid out on a GPU, and how functions of users and parameters are put together
    "warpmuscle/kernels/memory/compiler_hints.py", "warpmuscle/kernels/force/extensions.py",
    "warpmuscle/kernels/moved.py", "warpmuscle/model/extensions.py", "warpmuscle/model/extension_arrays.py",
    "warpmuscle/model/user_functions.py",
)  # fmt: skip
SWAPPED_NAMES = {
    "sin": "cos", "cos": "sin", "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum",
    "floor": "ceil", "ceil": "floor", "argmin": "argmax", "argmax": "argmin", "nanmin": "nanmax", "nanmax": "nanmin",
}  # fmt: skip
DROPPED_CALLS = {"abs", "sqrt", "clamp", "clip", "fabs", "exp", "normalize", "transpose", "cumsum", "radians"}
COMMUTATIVE = {
    "min", "max", "minimum", "maximum", "dot", "hypot", "isclose", "isinstance", "getattr", "hasattr", "add", "print",
    "field", "import_module",
}  # fmt: skip
TELLING = {"print", "warn", "join", "format", "append_note", "replace", "strip", "split", "startswith", "endswith"}
UNSEEN_KEYWORDS = {"decimals", "digits", "tol", "rtol", "atol", "dtype", "encoding", "stacklevel", "strict", "unroll"}
UNSEEN_NAMES = re.compile(r"TOLERANCE|EPS|TINY|SMALLEST|LANES|CHUNK|REGISTERS|__all__|_logger")
NAMED = re.compile(r"\b(?:dict|Mapping)\[str,")  # numbers by name are no text
OF_ONE_TYPE = {"model", "state", "work", "device", "scene", "extensions", "arm", "self", "names"}  # swapped never run
BOUNDING = {"min", "max", "minimum", "maximum", "clamp", "clip", "fmax"}
BOUNDED_FIRST = {"clamp", "clip"}
TINIEST, HUGEST = 1e-6, 1e6  # beyond them a bound keeps what is no number, or a division by nothing, away
ARITHMETIC = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*", ast.Mod: "*"}
SIGNS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.MatMult: "@",
}  # fmt: skip
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
REVERSED = {"<": ">", "<=": ">", ">": "<", ">=": "<", "==": "!=", "!=": "=="}
AT_THE_BOUND = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}


@dataclass(frozen=True)
class Mutation:
    """A change of a file: bytes `start` to `end` become `after`."""

    path: str
    line: int
    kind: str
    before: str
    after: str
    start: int
    end: int
    digest: str  # of the file that it is a change of

    @property
    def name(self) -> str:
        """What tells it from others, also after other lines of the file have changed."""
        text = f"{self.path}|{self.kind}|{self.before}|{self.after}|{self.line}"
        return f"{Path(self.path).stem}-{hashlib.sha256(text.encode()).hexdigest()[:10]}"

    def applied(self, source: bytes) -> bytes:
        """The file's text with the change.

        Raises:
            ValueError: the file is not the one that the change was made for.
        """
        if hashlib.sha256(source).hexdigest() != self.digest:
            raise ValueError(f"{self.path}: changed since its mutations were listed; run again")
        return source[: self.start] + self.after.encode() + source[self.end :]

    def as_dict(self) -> dict[str, Any]:
        """For a file of results."""
        return asdict(self)


def files(root: Path, only: str | None = None) -> list[str]:
    """Files of physics, relative to the repository's root, and of these those whose path contains `only`."""
    found = sorted(str(path.relative_to(root)) for folder in PHYSICS for path in (root / folder).rglob("*.py"))
    return [path for path in found if path not in NO_PHYSICS and (only is None or only in path)]


def all_mutations(root: Path, only: str | None = None) -> list[Mutation]:
    """Every mutation of the files of physics, in the order of files and lines."""
    return [mutation for path in files(root, only) for mutation in mutations_of(path, (root / path).read_bytes())]


def sample(mutations: Sequence[Mutation], count: int, seed: int) -> list[Mutation]:
    """Some of them: of lines drawn at random, one each, so that long lines count no more than others.

    Each line has its own place in the draw, so that one that is listed as equal, or a change of another file, changes
    no other choice, and a run goes on.
    """
    lines: dict[tuple[str, int], list[Mutation]] = {}
    for mutation in mutations:
        lines.setdefault((mutation.path, mutation.line), []).append(mutation)
    draws = {place: random.Random(f"{seed} {place}") for place in lines}
    order = sorted((draw.random(), place) for place, draw in draws.items())
    return [_drawn(lines[place], draws[place]) for _, place in order[:count]]


def _drawn(candidates: list[Mutation], draw: random.Random) -> Mutation:
    """One of a line's, of a kind drawn first."""
    kind = draw.choice(sorted({mutation.kind for mutation in candidates}))
    return draw.choice([mutation for mutation in candidates if mutation.kind == kind])


def mutations_of(path: str, source: bytes) -> list[Mutation]:
    """Every mutation of a file, in the order of its text, without two of the same effect."""
    text = _Text(path, source)
    found = {(m.start, m.end, m.after): m for m in text.mutations()}
    return sorted(found.values(), key=lambda m: (m.start, m.end, m.kind, m.after))


class _Text:
    """A file's text and tree."""

    def __init__(self, path: str, source: bytes) -> None:
        self.path, self.source, self.digest = path, source, hashlib.sha256(source).hexdigest()
        self.lines = [0]
        for line in source.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))
        self.tree = ast.parse(source)
        self.left_out = {id(node) for node in _bounds(self.tree)}
        if path.startswith("warpmuscle/kernels/"):
            self.left_out |= {id(node) for node in _flags(self.tree)}
        self.equal = {line for file, line in EQUAL if file == path}
        self.equal_changes = {(line, after) for file, line, after in EQUAL_CHANGES if file == path}

    def mutations(self) -> Iterator[Mutation]:
        for node in _computing(self.tree):
            for kind, place, after in self._changes(node) if id(node) not in self.left_out else ():
                start, end = self._span(place)
                before = self.source[start:end].decode()
                after = _kept_together(after) if isinstance(place, ast.BinOp) else after
                line = self.source[self.lines[place.lineno - 1] : self.lines[place.lineno]].decode().strip()
                told_equal = line in self.equal or (line, " ".join(after.split())) in self.equal_changes
                if before != after and not told_equal:
                    yield Mutation(self.path, place.lineno, kind, before, after, start, end, self.digest)

    def _span(self, node: Any) -> tuple[int, int]:
        return self.lines[node.lineno - 1] + node.col_offset, self.lines[node.end_lineno - 1] + node.end_col_offset

    def _of(self, node: ast.AST) -> str:
        start, end = self._span(node)
        return self.source[start:end].decode()

    def _changes(self, node: ast.AST) -> Iterator[tuple[str, Any, str]]:
        """Kind, node whose text is replaced, and the new text."""
        if isinstance(node, ast.Constant):
            yield from _numbers(node)
        elif isinstance(node, ast.BinOp):
            yield from self._sums(node)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            yield "sign" if isinstance(node.op, ast.USub) else "condition", node, f"({self._of(node.operand)})"
        elif isinstance(node, ast.Compare) and len(node.ops) == 1:
            yield from self._comparisons(node)
        elif isinstance(node, ast.BoolOp):
            word = " or " if isinstance(node.op, ast.And) else " and "
            yield "condition", node, f"({word.join(f'({self._of(value)})' for value in node.values)})"
        elif isinstance(node, ast.Call):
            yield from self._calls(node)
        elif isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div):
            sign = ARITHMETIC[type(node.op)]
            yield "operator", node, f"{self._of(node.target)} {sign}= {_kept_together(self._of(node.value))}"
            yield "statement", node, "pass"
        elif _may_go(node):
            yield "statement", node, "pass"

    def _sums(self, node: ast.BinOp) -> Iterator[tuple[str, Any, str]]:
        if _is_text(node.left) or _is_text(node.right) or type(node.op) not in SIGNS:
            return
        left, right, sign = self._of(node.left), self._of(node.right), SIGNS[type(node.op)]
        if type(node.op) in ARITHMETIC and not _is_one(node.right):
            yield "operator", node, f"{left} {ARITHMETIC[type(node.op)]} {_bracketed(node.right, right)}"
        yield "term dropped", node, left
        if sign == "+":
            yield "term dropped", node, right
            yield "term doubled", node, f"({left} + {right} + {right})"
        elif sign == "-":
            yield "term dropped", node, f"(-({right}))"
            yield "term doubled", node, f"({left} - {_bracketed(node.right, right)} - {_bracketed(node.right, right)})"
            yield "swapped", node, f"({_bracketed(node.right, right)} - {_bracketed(node.left, left)})"
        elif sign in "*@":
            yield "term dropped", node, right
        if sign == "@" and left != right:
            yield "swapped", node, f"({_bracketed(node.right, right)} @ {_bracketed(node.left, left)})"

    def _comparisons(self, node: ast.Compare) -> Iterator[tuple[str, Any, str]]:
        sign = COMPARISONS.get(type(node.ops[0]))
        if sign is None or _is_text(node.comparators[0]):
            return
        left, right = self._of(node.left), self._of(node.comparators[0])
        yield "comparison", node, f"{left} {REVERSED[sign]} {right}"
        if sign in AT_THE_BOUND and (_counts(node.left) or _counts(node.comparators[0])):
            yield "comparison", node, f"{left} {AT_THE_BOUND[sign]} {right}"

    def _calls(self, node: ast.Call) -> Iterator[tuple[str, Any, str]]:
        called = _called(node)
        if called in SWAPPED_NAMES:
            function = self._of(node.func)
            yield "function", node.func, function[: -len(called)] + SWAPPED_NAMES[called]
        if called in DROPPED_CALLS and node.args:
            yield "function", node, f"({self._of(node.args[0])})"
        if called in COMMUTATIVE or called[:1].isupper():
            return
        bounded = called in BOUNDED_FIRST and len(node.args) == 3  # as min(max(low, x), high)
        for one, other in list(zip(node.args, node.args[1:], strict=False))[bounded:]:
            if isinstance(one, ast.Starred) or isinstance(other, ast.Starred) or _is_text(one) or _is_text(other):
                continue
            if self._of(one) != self._of(other) and not {self._of(one), self._of(other)} & OF_ONE_TYPE:
                both = _Both(one, other)
                between = self.source[self._span(one)[1] : self._span(other)[0]].decode()
                yield "swapped", both, self._of(other) + between + self._of(one)


class _Both:
    """Where two neighbours stand."""

    def __init__(self, one: ast.expr, other: ast.expr) -> None:
        self.lineno, self.col_offset = one.lineno, one.col_offset
        self.end_lineno, self.end_col_offset = other.end_lineno, other.end_col_offset


def _computing(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a tree that compute something."""
    if isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.FunctionDef):
        if node.returns is not None and re.search(r"\bstr\b", NAMED.sub("", ast.unparse(node.returns))):
            return  # text for people
        for child in [*node.body, *node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]:
            yield from _computing(child)
        return
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
        return
    if isinstance(node, ast.Assign) and any(UNSEEN_NAMES.search(ast.unparse(t)) for t in node.targets):
        return
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return  # docstring
    if isinstance(node, ast.Call) and (_tells(node) or _called(node) in {"NewType", "TypeVar", "Option"}):
        return
    if isinstance(node, ast.keyword) and node.arg in UNSEEN_KEYWORDS:
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _computing(child)


def _bounds(tree: ast.AST) -> Iterator[ast.Constant]:
    """Tiny and huge numbers that something is compared with or bounded by, and names of tiny ones."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            operands = [node.left, *node.comparators]
        elif isinstance(node, ast.Call) and _called(node) in BOUNDING:
            operands = node.args
        elif isinstance(node, ast.Assign):
            operands = [node.value] if _size(node.value) <= TINIEST else []
        else:
            continue
        for operand in operands:
            if not TINIEST < _size(operand) < HUGEST:
                yield from (one for one in ast.walk(operand) if isinstance(one, ast.Constant))


def _size(node: ast.expr) -> float:
    """Magnitude of a number other than 0, also within a type or `wp.static`; 1 of anything else."""
    if isinstance(node, ast.Call) and _called(node) in {"static", "float32", "float64", "constant"} and node.args:
        return _size(node.args[0])
    if isinstance(node, ast.UnaryOp):
        return _size(node.operand)
    return abs(node.value) if isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value else 1.0


def _flags(tree: ast.AST) -> Iterator[ast.Constant]:
    """Truth values that parameters, and what is compiled in, have by default."""
    for node in ast.walk(tree):
        values: list[ast.expr | None] = []
        if isinstance(node, ast.FunctionDef):
            values = [*node.args.defaults, *node.args.kw_defaults]
        elif isinstance(node, ast.ClassDef):
            values = [line.value for line in node.body if isinstance(line, ast.AnnAssign)]
        yield from (one for one in values if isinstance(one, ast.Constant) and isinstance(one.value, bool))


def _numbers(node: ast.Constant) -> Iterator[tuple[str, Any, str]]:
    value = node.value
    if isinstance(value, bool):
        yield "number", node, str(not value)
    elif isinstance(value, int):
        yield "number", node, str(value + 1)
        if value > 1:
            yield "number", node, str(value - 1)
    elif isinstance(value, float) and value == 0.0:
        yield "number", node, "1.0"
    elif isinstance(value, float):
        yield "number", node, repr(1.25 * value)
        yield "number", node, repr(0.8 * value)


def _called(node: ast.Call) -> str:
    """Name of the function, without what it belongs to."""
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _tells(node: ast.Call) -> bool:
    """Whether a call only makes or writes text, makes an error, or tells the compiler something."""
    called = _called(node)
    hints = {"not_unrolled", "synchronize", "static_assert", "set_module_options"}  # for the compiler
    hint = called in hints or called.startswith("know_")
    return hint or called in TELLING or called.endswith("Error")


def _may_go(node: ast.AST) -> bool:
    """Whether the rest runs without this statement: one that puts something somewhere, or calls something."""
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], ast.Subscript | ast.Attribute)
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and not _tells(node.value)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _is_one(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value in (1, 1.0)


def _counts(node: ast.expr) -> bool:
    """Whether it is surely a whole number, so that a bound may be met."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int) and not isinstance(node.value, bool) and node.value != 0
    return isinstance(node, ast.Call) and _called(node) in ("len", "int")


def _kept_together(text: str) -> str:
    """Text of an expression that may stand alone, in brackets where it goes on in another line."""
    return f"({text})" if "\n" in text else text


def _bracketed(node: ast.expr, text: str) -> str:
    """Text of an operand, which may have to be kept together."""
    return f"({text})" if isinstance(node, ast.BinOp | ast.IfExp | ast.BoolOp | ast.Compare | ast.UnaryOp) else text
