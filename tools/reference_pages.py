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
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import warp as wp
from notebooks import notebooks
from reference_scene import scene
from reference_text import of_object, one_paragraph, prose, table
from typer.main import get_command

import warpmuscle as wm
from warpmuscle.cli.program import COMMANDS, GROUPS, app
from warpmuscle.core.limits import GREATEST_NUMBER, LEAST_NUMBER, LIMITS
from warpmuscle.formats.schema import scene_schema
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import STAGES, Declaration
from warpmuscle.kernels.objective.objective_terms import REWARDS, TERMS
from warpmuscle.kernels.stable import FIELDS, STABLE
from warpmuscle.model.part_checks import IN_STEP, TERM_ARGUMENTS
from warpmuscle.model.task_parts import DRAW, USES
from warpmuscle.model.user_functions import name_of, signature
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.session.public import PUBLIC

# Names of Python by what one wants to do; commands have their topics in `cli.program`.
NAMES = {
    "Load and describe scenes": ("load", "save", "scenes", "Scene", "trust", "convert"),
    "Run simulations": (
        "simulate", "Run", "Rollout", "make_rollout", "MultiDeviceRollout", "Stages", "Status", "quadratic_program",
    ),
    "Search for parameters": ("optimize", "resume", "best_scene", "Evaluator", "sweep", "Sweep"),
    "Learn policies": ("learn",),
    "Look at motions": ("show", "plot", "measure"),
    "Read, write and export": ("read", "write", "Result", "Recording", "Motions", "read_motions", "append_motions"),
    "From recordings to muscles": (
        "scale", "inverse_kinematics", "inverse_dynamics", "static_optimization", "track", "joint_reactions",
        "run_reactions",
    ),
    "Errors": ("Error", "SceneError", "RolloutError", "ResultError"),
}  # fmt: skip


def by_topic(topics: Mapping[str, tuple[str, ...]], names: Iterable[str]) -> dict[str, list[str]]:
    """Names by what they are for; raises ValueError where one has no topic."""
    left = set(names)
    found = {topic: [name for name in listed if name in left] for topic, listed in topics.items()}
    if none := left - {name for listed in found.values() for name in listed}:
        raise ValueError(f"tools/reference_pages.py gives no topic to {', '.join(sorted(none))}")
    return {topic: listed for topic, listed in found.items() if listed}


def command_line() -> str:
    """Every command with its arguments and options, by topic."""
    pages = ["# Command line", "", "`warpmuscle COMMAND --help` prints the same.", ""]
    known = dict(commands(get_command(app).commands))
    groups = {group: name for name, group in GROUPS.items()}
    for topic, members in COMMANDS.items():
        pages += [f"## {topic}", ""]
        for first in (groups.get(one) or one.__name__.replace("_", "-") for one in members):
            for name in (name for name in known if name.split()[0] == first):
                pages += of_command(name, known[name])
    return "\n".join(pages)


def of_command(name: str, command: Any) -> list[str]:
    """Usage, help, arguments and options of a command."""
    given = [p for p in command.params if p.name != "help" and not getattr(p, "hidden", False)]
    arguments = [p.metavar or p.name.upper() for p in given if p.param_type_name == "argument"]
    usage = " ".join(["warpmuscle", name, *arguments, "[OPTIONS]"])
    pages = [f"### {name}", "", f"```text\n{usage}\n```", "", prose(command.help or ""), ""]
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
    return pages


def commands(named: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Commands by what is typed for them, those of groups such as `throw fit` in place of these."""
    for name, command in named.items():
        if hasattr(command, "commands"):
            yield from commands(command.commands, f"{before}{name} ")
        elif not command.hidden:
            yield f"{before}{name}", command


def python() -> str:
    """The names of the package with their signatures and docstrings, by topic."""
    pages = ["# Python", "", "`import warpmuscle as wm` gives these names. `help(wm.Rollout)` prints the same.", ""]
    for topic, names in by_topic(NAMES, (name for name in wm.__all__ if not name.startswith("__"))).items():
        pages += [f"## {topic}", ""]
        for name in names:
            pages += [*of_object(f"wm.{name}", getattr(wm, name), "###"), ""]
    return "\n".join(pages)


def objective() -> str:
    """The terms of the objective."""
    rows = [(f"`{t.name}`", t.unit, t.description) for t in TERMS.values()]
    text = (Path(__file__).parents[1] / "docs" / "reference" / "objective.md.in").read_text()
    taken = {"cost": "taken off", "earned": "earned"}
    rewards = [(f"`{r.name}`", taken[r.sign], r.unit, f"`{r.weight:g}`", r.description) for r in REWARDS.values()]
    text = text.replace("@REWARDS@", table(("reward", "", "unit of the weight", "weight by default", "what"), rewards))
    return text.replace("@TERMS@", table(("term", "unit", "what it adds up"), rows))


def custom_parts() -> str:
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
        for of, given in (("each muscle", "muscle"), ("each joint", "body"), ("the whole", "instance"))
    ]
    whole = signature(TERM_ARGUMENTS["instance"])
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
    "reference/parts.md": custom_parts,
    "reference/files.md": files,
    "reference/sizes.md": sizes,
    "reference/kernels.md": kernels,
    "reference/scene.schema.json": lambda: json.dumps(scene_schema(), indent=1),
}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages to those that MkDocs found."""
    from mkdocs.structure.files import File

    made = {path: make() for path, make in PAGES.items()} | notebooks()
    for path, text in made.items():
        files.append(File.generated(config, path, content=text))
    return files


if __name__ == "__main__":
    for path, make in PAGES.items():
        target = Path(sys.argv[1]) / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(make())
