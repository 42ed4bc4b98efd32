"""The laws of muscles, by the name that a scene has for them: those of `law_names`, each from its file."""

from importlib import import_module
from pathlib import Path

from warpmuscle.kernels.muscle.law_names import NAMES
from warpmuscle.kernels.muscle.muscle_kind import MuscleLaw


def law_of_file(name: str) -> MuscleLaw:
    """The law in the file of its name.

    Raises:
        TypeError: there is no such file, or what it has is no law; it names both.
    """
    file, constant = f"{name}_law.py", name.upper()
    module = f"{__package__}.{name}_law"
    try:
        law = getattr(import_module(module), constant, None)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise TypeError(f"law of muscles {name!r} has no file {file} with its {constant}") from None
    if not isinstance(law, MuscleLaw):
        raise TypeError(f"law of muscles {name!r}: {file} has no {constant}, a `muscle_kind.MuscleLaw`")
    for field in ("activate", "contract", "strength"):
        if not callable(getattr(law, field)):
            message = f"{constant} in {file} needs a function of the `MuscleKind` that makes a Warp function"
            raise TypeError(f"law of muscles {name!r} has no {field!r}: {message}")
    return law


def laws_of(folder: Path) -> dict[str, MuscleLaw]:
    """All laws, in the order of their names.

    Args:
        folder: where the files of laws lie.

    Raises:
        TypeError: a name has no law, or a file has no name, which no scene could then choose.
    """
    for file in sorted(folder.glob("*_law.py")):
        name = file.stem.removesuffix("_law")
        if name not in NAMES:
            raise TypeError(f"law of muscles {name!r} in {file.name} has no name: add it to `Law` in law_names.py")
    return {name: law_of_file(name) for name in NAMES}


LAWS: dict[str, MuscleLaw] = laws_of(Path(__file__).parent)
HILL, LEGACY, IDEAL = LAWS["hill"], LAWS["legacy"], LAWS["ideal"]
