"""Pages of the reference that follow from the code: commands, Python names, fields of scenes, terms, largest sizes.

MkDocs calls this as a hook (see mkdocs.yml). `python tools/reference_pages.py FOLDER` writes the pages instead.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import json
import re
import sys
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import warp as wp
from typer.main import get_command

import warpmuscle as wm
from warpmuscle.cli.program import app
from warpmuscle.core.limits import GREATEST_NUMBER, LEAST_NUMBER, LIMITS
from warpmuscle.formats.schema import notes, scene_schema, unit_of
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import STAGES, Declaration
from warpmuscle.kernels.objective.objective_terms import REWARDS, TERMS
from warpmuscle.kernels.stable import FIELDS, STABLE
from warpmuscle.model.found_parts import IN_STEP, TERM_ARGUMENTS
from warpmuscle.model.task_parts import DRAW, USES
from warpmuscle.model.user_functions import name_of, signature
from warpmuscle.results.recording import QUANTITIES
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free, Number, Vector
from warpmuscle.session.public import PUBLIC


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    cells = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in cells)


def command_line() -> str:
    """Every command with its arguments and options."""
    pages = ["# Command line", "", "`warpmuscle COMMAND --help` prints the same.", ""]
    for name, command in commands(get_command(app).commands):
        given = [p for p in command.params if p.name != "help" and not getattr(p, "hidden", False)]
        arguments = [p.metavar or p.name.upper() for p in given if p.param_type_name == "argument"]
        usage = " ".join(["warpmuscle", name, *arguments, "[OPTIONS]"])
        pages += [f"## {name}", "", f"```text\n{usage}\n```", "", prose(command.help or ""), ""]
        rows = []
        for parameter, argument in [(p, p.param_type_name == "argument") for p in given]:
            words = parameter.metavar or parameter.name.upper()
            if not argument:
                value = f" {parameter.metavar}" if parameter.metavar else ""
                words = ", ".join((*parameter.opts, *parameter.secondary_opts)) + value
            default = parameter.default
            plain = default not in (None, False, (), []) and not callable(default)
            rows.append((f"`{words}`", prose(parameter.help or ""), f"`{default}`" if plain else ""))
        if rows:
            pages += [table(("argument or option", "meaning", "default"), rows), ""]
    return "\n".join(pages)


def commands(named: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Commands by what is typed for them, those of groups such as `throw fit` in place of these."""
    for name, command in named.items():
        if hasattr(command, "commands"):
            yield from commands(command.commands, f"{before}{name} ")
        elif not command.hidden:
            yield f"{before}{name}", command


def prose(text: str) -> str:
    """Help as Markdown: `Example:` and `Examples:` become code, and `[` is not escaped."""
    text = inspect.cleandoc(text).replace("\\[", "[")
    said, _, examples = re.sub(r"\bExamples?: (?=warpmuscle)", "\0", text, count=1).partition("\0")
    said = re.sub(r"(?<![`\w])(--[a-z][\w-]*)", r"`\1`", said.strip())
    if not examples:
        return said
    lines = [" ".join(line.split()).rstrip(".") for line in re.split(r";\s+", examples.strip())]
    return f"{said}\n\n```text\n" + "\n".join(lines) + "\n```"


def python() -> str:
    """The names of the package with their signatures and docstrings."""
    pages = ["# Python", "", "`import warpmuscle as wm` gives these names. `help(wm.Rollout)` prints the same.", ""]
    for name in sorted(n for n in wm.__all__ if not n.startswith("__")):
        pages += [*of_object(f"wm.{name}", getattr(wm, name), "##"), ""]
    return "\n".join(pages)


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


def scene() -> str:
    """Every structure of a scene with its fields, from the scene downwards."""
    pages = [
        "# Scene", "", *SCENE_INTRODUCTION, "",
    ]  # fmt: skip
    for part in structures():
        pages += [f"## {part.__name__}", "", re.sub(r"\s*\n\s*\n\s*", "\n\n", inspect.getdoc(part) or ""), ""]
        rows = []
        hints = typing.get_type_hints(part)
        tag = part.__struct_config__.tag
        if tag:
            rows.append(("`type`", f'`"{tag}"`', "", "", ""))
        for field in msgspec.structs.fields(part):
            said = notes(part).get(field.name, "") or summary_of(hints[field.name])
            row = (f"`{field.name}`", kind(hints[field.name]), unit_of(part, field.name), default(field), said)
            rows.append(row)
        pages += [table(("field", "type", "unit", "default", "meaning"), rows), ""]
    return "\n".join(pages)


SCENE_INTRODUCTION = (
    "A scene is a TOML file whose fields are those of [Scene](#scene_1). Units are SI and radians; y is up, x to the",
    "left, z forward; quaternions are x, y, z, w. Every *number* may also be a table that makes it a free parameter,",
    "see [Free](#free). `base` names another scene, a file or a shipped one, from which a file takes all that it does",
    "not say itself; `character` may be the name of a file, or a list of files whose tables add up. A list may be",
    "written as a table of the items that change, counted from 0: `[controller.states.0]`.",
    "",
    "`warpmuscle schema` writes the same as a [JSON schema](scene.schema.json), which editors complete from:",
    "see [how to edit with completion](../how-to/edit-with-completion.md).",
)


def summary_of(hint: Any) -> str:
    """The first sentence of what the structures of a field are, if they are of one kind."""
    found = [inner for inner in (hint, *typing.get_args(hint)) if isinstance(inner, type) and inner is not Free]
    of_scene = [inner for inner in found if issubclass(inner, msgspec.Struct)]
    return (inspect.getdoc(of_scene[0]) or "").split(". ")[0].splitlines()[0].rstrip(".") if len(of_scene) == 1 else ""


def structures() -> list[type]:
    """The structures that a scene may have, each after the one that names it first."""
    found: list[type] = []

    def follow(hint: Any) -> None:
        known = (*found, Free)
        if isinstance(hint, type) and issubclass(hint, msgspec.Struct) and hint not in known:
            found.append(hint)
            for inner in typing.get_type_hints(hint).values():
                follow(inner)
        for inner in typing.get_args(hint):
            follow(inner)

    follow(Scene)
    return [*found, Free]


def kind(hint: Any) -> str:
    """A type in words."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if hint == Number:
        return "number"
    if hint == Vector:
        return "3 numbers"
    if origin is typing.Literal:
        return ", ".join(f'`"{word}"`' for word in inner)
    if origin in (typing.Union, types.UnionType):
        if set(typing.get_args(Number)) <= set(inner):
            inner = (Number, *(i for i in inner if i not in typing.get_args(Number)))
        return " or ".join(dict.fromkeys(kind(i) for i in inner if i is not type(None)))
    if origin is list:
        return f"list of {kind(inner[0])}"
    if origin is dict:
        return f"table of {kind(inner[1])} by name"
    if origin is tuple:
        return f"list of {kind(inner[0])}" if inner[-1] is ... else f"{len(inner)} of {kind(inner[0])}"
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        anchor = "scene_1" if hint is Scene else hint.__name__.lower()
        return f"[{hint.__name__}](#{anchor})"
    return {float: "fixed number", int: "whole number", str: "text", bool: "true or false"}.get(hint, str(hint))


def default(field: Any) -> str:
    """A default as TOML has it; empty if there is none, or it says nothing."""
    value = field.default if field.default is not msgspec.NODEFAULT else None
    if field.default is msgspec.NODEFAULT and field.default_factory is msgspec.NODEFAULT:
        return "needed"
    if value is None or value == "" or isinstance(value, msgspec.Struct):
        return ""
    return f"`{json.dumps(value)}`"


def objective() -> str:
    """The terms of the objective."""
    rows = [(f"`{t.name}`", t.unit, t.description) for t in TERMS.values()]
    text = (Path(__file__).parents[1] / "docs" / "reference" / "objective.md.in").read_text()
    taken = {"cost": "taken off", "earned": "earned"}
    rewards = [(f"`{r.name}`", taken[r.sign], r.unit, f"`{r.weight:g}`", r.description) for r in REWARDS.values()]
    text = text.replace("@REWARDS@", table(("reward", "", "unit of the weight", "weight by default", "what"), rewards))
    return text.replace("@TERMS@", table(("term", "unit", "what it adds up"), rows))


def own_parts() -> str:
    """What parts of one's own declare, where scenes name them, and what their functions take."""
    text = (Path(__file__).parents[1] / "docs" / "reference" / "parts.md.in").read_text()
    said = field_comments(Declaration)
    rows = [
        (f"`{one.name}`", said.get(one.name, "")) for one in dataclasses.fields(Declaration) if one.name in OF_ONES_OWN
    ]
    stages = [(f"`{stage}`", meaning) for stage, meaning in STAGES.items()]
    step = ", ".join(f"`{stage}`" for stage in IN_STEP)
    uses = [
        (
            f"a term, of {of}",
            "`objective.custom`, `objective.reported`, `learning.rewards.custom`",
            f"`{signature(TERM_ARGUMENTS[given])}`",
            "`float`",
            "`forces`" if given == "muscle" else step,
        )
        for of, given in (("each muscle", "muscle"), ("each joint", "body"), ("the whole", "whole"))
    ]
    whole = signature(TERM_ARGUMENTS["whole"])
    decision = [(f"`{name}`", comment) for name, comment in field_comments(Decision.cls).items()]
    uses.append(("a failing condition", "`failure.custom`", f"`{whole}`", "`bool`", "`forces`"))
    uses.append(("a recorded quantity", "`recorded`", f"`{whole}`", "`float` or `wp.vec3`", step))
    for use in USES:
        takes = signature(DRAW) if use.draws else f"{whole[:-1]} [, Decision])"
        results = " or ".join(f"`{name_of(kind)}`" for kind in use.results if kind is not None) or "nothing"
        uses.append(
            (use.what.removeprefix("a ").removeprefix("an "), f"`{use.key}`", f"`{takes}`", results, "`decision`")
        )
    return (
        text.replace("@DOC@", "\n\n".join((inspect.getdoc(Declaration) or "").split("\n\n")[1:]))
        .replace("@FIELDS@", table(("field", "meaning"), rows))
        .replace("@STAGES@", table(("stage", "what is known then"), stages))
        .replace("@USES@", table(("part", "named in", "takes", "returns", "stage"), uses))
        .replace("@DECISION@", table(("field", "meaning"), decision))
    )  # fmt: skip


OF_ONES_OWN = (
    "function",
    "parameters",
    "memory",
    "stage",
    "sign",
    "unit",
    "description",
    "defaults",
    "limits",
    "follows_cycles",
)


def field_comments(owner: type) -> dict[str, str]:
    """The comments behind the fields of a class."""
    lines = inspect.getsource(owner).splitlines()
    found = (re.match(r"    (\w+): .*?  # (.+)$", line) for line in lines)
    return {match[1]: match[2] for match in found if match}


def sizes() -> str:
    """The largest sizes of inputs."""
    rows = [(f"`{name}`", f"{limit.most:,} {limit.of}", limit.why) for name, limit in LIMITS.items()]
    return "\n".join(
        [
            "# Largest sizes", "",
            "What is larger than this is refused before work starts, by the name of the limit, rather than running for",
            "hours in silence. Batches must also fit into the memory of the device. Inputs are regular files, not",
            f"pipes or devices. Numbers of a scene are at most {GREATEST_NUMBER:g}, and at least {LEAST_NUMBER:g}",
            "where they must be positive.", "",
            table(("limit", "at most", "of what"), rows), "",
        ]
    )  # fmt: skip


def files() -> str:
    """The layout of result files."""
    rows = []
    for name, quantity in QUANTITIES.items():
        rows.append((f"`{name}`", ", ".join(quantity.axes), quantity.units, quantity.description, quantity.at))
    text = (Path(__file__).parents[1] / "docs" / "reference" / "files.md.in").read_text()
    return text.replace("@RECORDING@", table(("dataset", "axes", "unit", "what", "when"), rows))


def kernels() -> str:
    """The stable names of `warpmuscle.kernels`, with their arguments."""
    pages = [
        "# Kernels", "",
        "Programs of your own may rely on these names of `warpmuscle.kernels`: they keep their arguments, their order "
        "and units, and what changes is told in the list of changes. All else there may change with any version. "
        "[How to use them](../how-to/use-the-kernels.md).", "",
    ]  # fmt: skip
    for module, names in STABLE.items():
        values = vars(importlib.import_module(f"warpmuscle.kernels.{module}"))
        rows = []
        for name in names:
            value = values[name]
            given, said = "", (inspect.getdoc(getattr(value, "func", None) or value) or "").partition("\n\n")[0]
            if isinstance(value, wp.Function):
                given = f"({', '.join(value.input_types)})"
            elif isinstance(value, wp.Kernel):
                given = f"({', '.join(argument.label for argument in value.adj.args)})"
            elif isinstance(value, int):
                said = f"number {value} of the curves"
            if name in FIELDS:
                said += " Fields: " + ", ".join(f"`{field}`" for field in FIELDS[name])
            elif name.endswith("Ref"):
                said = f"`{name.removesuffix('Ref')}`, given by reference"
            rows.append((f"`{name}{given}`", one_paragraph(said)))
        pages += [f"## {module}", "", table(("name", "meaning"), rows), ""]
    return "\n".join(pages)


def modules() -> str:
    """The names of modules that programs of others may import."""
    pages = [
        "# Modules", "",
        "Studies of your own may import these names besides those of [`import warpmuscle as wm`](python.md): "
        "`from warpmuscle.search.cma import CmaSearch`. Changes to them are listed. All else may change "
        "with any version. The commands `throw`, `synergies` and `arm-angles` are built on nothing else.", "",
    ]  # fmt: skip
    for module, names in PUBLIC.items():
        home = importlib.import_module(f"warpmuscle.{module}")
        pages += [f"## {module}", ""]
        for name in names:
            value = getattr(home, name)
            if inspect.isfunction(value) or (inspect.isclass(value) and not issubclass(value, msgspec.Struct)):
                pages += [*of_object(name, value, "###"), ""]
            else:
                said = inspect.getdoc(value) if inspect.isclass(value) else f"`{value!r}`"
                pages += [f"### {name}", "", one_paragraph((said or "").partition("\n\n")[0]), ""]
    return "\n".join(pages)


PAGES = {
    "reference/command-line.md": command_line,
    "reference/python.md": python,
    "reference/modules.md": modules,
    "reference/scene.md": scene,
    "reference/objective.md": objective,
    "reference/parts.md": own_parts,
    "reference/files.md": files,
    "reference/sizes.md": sizes,
    "reference/kernels.md": kernels,
    "reference/scene.schema.json": lambda: json.dumps(scene_schema(), indent=1),
}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages to those that MkDocs found."""
    from mkdocs.structure.files import File

    for path, make in PAGES.items():
        files.append(File.generated(config, path, content=make()))
    return files


if __name__ == "__main__":
    for path, make in PAGES.items():
        target = Path(sys.argv[1]) / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(make())
