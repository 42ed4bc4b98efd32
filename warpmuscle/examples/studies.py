"""Published studies that models of the package can repeat, as files for `warpmuscle study`."""

from __future__ import annotations

from importlib import resources

STUDIES = {
    "brace": "stiffness of ankle-foot orthoses and weakness (Waterval 2019, 2023)",
    "brace_found": "the stiffness that costs least, by weakness (Waterval 2023)",
    "calves": "weakness and contracture of calf muscles (Ong 2019)",
    "hyperreflexia": "spastic calf muscles (Bruel 2022)",
    "loads": "loads on pelvis, thighs and feet (Browning 2007)",
    "locked_ankles": "ankles that do not move (Vanderpool 2008)",
    "objectives": "objectives one by one and together (Veerkamp 2021)",
    "slopes": "walking up and down (Koelewijn 2019)",
    "strength": "strength of one side and the speed that costs least (Johnson 2022)",
    "weakness": "weak muscles of the biped of 56 muscles",
}


BEGIN_LEVEL = tuple(name for name in STUDIES if name != "weakness")  # studies that begin with the walk of this file
LEVEL_WALK = "level_walk.toml"


def study_files(name: str) -> dict[str, str]:
    """The files of a study, by name: its own first, and the scene that it names, if that is none of the package's."""
    found = {f"{name}.toml": study_text(name)}
    if name in BEGIN_LEVEL:
        found[LEVEL_WALK] = _text(LEVEL_WALK)
    return found


def study_text(name: str) -> str:
    """The file of a study, by its name in `STUDIES`."""
    return _text(f"{name}.toml")


def _text(file: str) -> str:
    return (resources.files("warpmuscle.examples") / "files" / file).read_text("utf-8")
