"""Help and docstrings as Markdown, for the pages of the reference."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import msgspec


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    cells = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in cells)


def prose(text: str) -> str:
    """Help as Markdown: `Example:` and `Examples:` become code, and `[` is not escaped."""
    text = inspect.cleandoc(text).replace("\\[", "[")
    said, _, examples = re.sub(r"\bExamples?: (?=warpmuscle)", "\0", text, count=1).partition("\0")
    said = re.sub(r"(?<![`\w])(--[a-z][\w-]*)", r"`\1`", said.strip())
    if not examples:
        return said
    lines = [" ".join(line.split()).rstrip(".") for line in re.split(r";\s+", examples.strip())]
    return f"{said}\n\n```text\n" + "\n".join(lines) + "\n```"


def of_object(name: str, value: Any, level: str) -> Iterator[str]:
    """Heading, signature and docstring of a class, with its methods, or of a function."""
    yield f"{level} {name.removeprefix('wm.')}\n"
    if not (isinstance(value, type) and issubclass(value, BaseException)):
        yield f"```text\n{name}{signature_of(value)}\n```\n"
    yield docstring(inspect.getdoc(value) or "")
    if not isinstance(value, type) or issubclass(value, BaseException | msgspec.Struct):
        return
    for key, member in vars(value).items():
        if key.startswith("_") or not (inspect.isfunction(member) or isinstance(member, property | classmethod)):
            continue
        if said := inspect.getdoc(member):
            if isinstance(member, property):
                yield f"\n`{key}`\n:   {one_paragraph(said)}\n"
            else:
                function = member.__func__ if isinstance(member, classmethod) else member
                yield f"\n{level}# {key}\n"
                yield f"```text\n{name}.{key}{signature_of(function)}\n```\n"
                yield docstring(said)


def signature_of(value: Any) -> str:
    """The signature of a class or a function, a line a parameter if it is long."""
    try:
        signature = inspect.signature(value)
    except (TypeError, ValueError):
        return "(...)"

    def plain(text: str) -> str:
        unquoted = re.sub(r": '([^']+)'", r": \1", text)
        return re.sub(r"\b(warpmuscle|numpy|pathlib|collections)(\.\w+)*\.(?=\w)", "", unquoted)

    given = [plain(str(p)) for name, p in signature.parameters.items() if name not in ("self", "cls")]
    kinds = [p.kind for name, p in signature.parameters.items() if name not in ("self", "cls")]
    if inspect.Parameter.KEYWORD_ONLY in kinds and inspect.Parameter.VAR_POSITIONAL not in kinds:
        given.insert(kinds.index(inspect.Parameter.KEYWORD_ONLY), "*")
    back = signature.return_annotation
    result = "" if back in (inspect.Signature.empty, "None", None) else f" -> {plain(f': {back!r}')[2:]}"
    line = f"({', '.join(given)}){result}"
    return line if len(line) < 70 else "(\n" + "".join(f"    {text},\n" for text in given) + f"){result}"


def one_paragraph(text: str) -> str:
    return " ".join(escaped(text).split())


def escaped(text: str) -> str:
    return text.replace("<", "&lt;").replace("*", "\\*") if "`" not in text else text


def docstring(text: str) -> str:
    """A docstring of this project as Markdown: sections become lists, examples code."""
    out: list[str] = []
    section = ""
    for line in text.splitlines():
        if match := re.fullmatch(r"(Args|Attributes|Raises|Returns|Example|Examples):(.*)", line.strip()):
            section = match[1]
            out += ["", f"**{section}**", ""]
            if section.startswith("Example"):
                out.append("```text")
            elif match[2].strip():
                out.append(match[2].strip())
        elif section.startswith("Example"):
            out.append(line)
        elif section and line.startswith("    ") and not line.startswith("     "):
            name, colon, rest = line.strip().partition(":")
            known = colon and re.fullmatch(r"[\w, *`]+", name)
            out.append(f"- `{name}`:{rest}" if known else f"- {line.strip()}")
        elif section and line.strip():
            out.append(f"  {line.strip()}")
        else:
            out.append(line)
    if section.startswith("Example"):
        out.append("```")
    return "\n".join(out)
