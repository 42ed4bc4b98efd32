"""What Warp writes for a compiler, made shorter where nothing is optimised: each statement is compiled, and then made.

A step has some ten thousand. What they come to is the same to the bit; `test_kernel_text.py` shows it.
"""

import re
from collections import Counter
from typing import Any

OPERATORS = {"add": "+", "sub": "-", "mul": "*"}
SCALARS = re.compile(r"\bwp::(float32|float64|int32) (var_\w+)\b")
LOADS, COPIES = re.compile(r"= wp::load\((var_\w+)\);"), re.compile(r"= wp::copy\((var_\w+)\);")
CALLS = re.compile(r"= wp::(add|sub|mul)\((var_\w+), (var_\w+)\);")
NAMES = re.compile(r"\bvar_\w+\b")
DECLARED = re.compile(r"[^=(]*\b(var_\w+);")
# What takes the address of something into a variable, and what reads from one.
READS = re.compile(r" +(?P<name>var_\w+) = (?:&(?P<place>\(.*\))|\*(?P<address>var_\w+));")
# A function that tells an optimising compiler how arrays lie in memory, see `kernels.memory.compiler_hints`.
HINTS = re.compile(r"\{\n[^\n]*\nauto whole = .*?\}\n\n", re.DOTALL)
# A statement that takes what it names by value: nobody else could change a copy that is no longer there.
TAKES_VALUES = re.compile(
    r" +(?:(?:var_\w+ = |if \(|return |wp::array_store\()[^&]*|var_\w+ = [^&]* && [^&]*);?(?: \{)?$"
)


def shortened(text: str) -> str:
    """A function as Warp writes it, by operators and with reads where they are used."""
    return text if "tile" in text else with_reads_in_place(with_operators(text))  # copies of tiles are more than that


def with_operators(text: str) -> str:
    """A function with operators of C++ instead of calls of functions that have these alone."""
    types = {name: kind for kind, name in SCALARS.findall(text)}

    def of_scalars(found: re.Match[str]) -> str:
        name, a, b = found.groups()
        return f"= {a} {OPERATORS[name]} {b};" if a in types and types[a] == types.get(b) else found[0]

    return CALLS.sub(of_scalars, COPIES.sub(r"= \1;", LOADS.sub(r"= *\1;", text)))


def with_reads_in_place(text: str) -> str:
    """A function without the variables that only hold a field, or what lies at an address, for the next statement.

    Of `a = &(b.c); d = *a; e = f(d);`, where nothing else uses a and d, `e = f((b.c));` is left.
    """
    declarations, forward, statements = text.partition("    // forward\n")
    uses = Counter(NAMES.findall(text))
    places: dict[str, tuple[int, str]] = {}  # by name of an address: which line takes it, and of what
    reads: dict[str, str] = {}  # what the next statement may read itself
    lines: list[str] = []
    gone: set[str] = set()

    def flush() -> None:
        lines.extend(f"    {name} = {what};" for name, what in reads.items())
        reads.clear()

    for line in statements.split("\n"):
        if not line.strip() or line.lstrip().startswith("//"):
            lines.append(line)
            continue
        names = NAMES.findall(line)
        read = READS.fullmatch(line)
        if read and uses[read["name"]] == 3 and reads.keys().isdisjoint(names):  # declared, set, and used once
            if read["place"]:
                places[read["name"]] = len(lines), read["place"]
                lines.append(line)
                continue
            reads[read["name"]] = f"*{read['address']}"
            if read["address"] in places:
                number, reads[read["name"]] = places.pop(read["address"])
                lines[number] = ""
                gone.add(read["address"])
            continue
        for name in reads.keys() & set(names) if TAKES_VALUES.match(line) else ():
            what = reads.pop(name)
            line = re.sub(rf"\b{name}\b", f"({what})" if what.startswith("*") else what, line)
            gone.add(name)
        flush()
        lines.append(line)
        if not names or "{" in line:
            places.clear()  # another block begins
    flush()
    kept = (line for line in declarations.split("\n") if not ((found := DECLARED.fullmatch(line)) and found[1] in gone))
    return "\n".join(kept) + forward + "\n".join(lines)


def without_hints(text: str) -> str:
    """A module without what only tells an optimising compiler something."""
    return HINTS.sub("{}\n\n", text)


def lines_of(kernel: Any) -> list[str]:
    """Lines that are compiled for a kernel, without comments, which tell a line only where another one was before."""
    import warp as wp

    module = kernel.module
    module.get_module_hash(1)
    text = module._run_codegen(module.resolve_options(wp.config) | {"block_dim": 1}, True)[0]
    return [line for line in text.splitlines() if not line.lstrip().startswith("//")]
