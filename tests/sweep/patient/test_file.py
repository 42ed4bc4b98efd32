"""What a patient's file says is understood, or refused with file, line and key."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.sweep.patient.file import LEAST_SPREAD, PatientFile, read

TEXT = """title = "A brace"
scene = "fwalk"
seeds = 2
[[recording]]
motion = "walk.h5"
[match]
candidates = 4
[[change]]
name = "heavy"
"character.bodies.torso.mass" = 40.0
"""


def written(folder: Path, text: str) -> PatientFile:
    file = folder / "patient.toml"
    file.write_text(text)
    return read(file)


def test_what_is_not_told_is_as_usual(tmp_path: Path):
    found = written(tmp_path, TEXT)
    assert found.title == "A brace"
    assert found.changes == {"heavy": {"character.bodies.torso.mass": 40.0}}
    assert (found.asked.match.candidates, found.asked.adapt.habit, found.asked.least_spread) == (4, 0.1, LEAST_SPREAD)
    assert found.beside("walk.h5") == tmp_path / "walk.h5"
    assert read(tmp_path / "patient.toml", seeds=9).asked.seeds == 9
    assert written(tmp_path, TEXT.removeprefix('title = "A brace"\n')).title == "patient"


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("seeds = 2", "sedes = 2", 3, "sedes: unknown key; did you mean 'seeds'"),
        ("seeds = 2", "seeds = 0", 3, "seeds: are 1 to 1000, not 0"),
        ("seeds = 2", "least_spread = -1", 3, "least_spread: is greater than 0"),
        ("seeds = 2", "speed = nan", 3, "speed: is greater than 0"),
        ('scene = "fwalk"', 'scene = ""', 2, "scene: name the scene"),
        ('motion = "walk.h5"', 'motion = "walk.mot"', 4, "name its file"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nloads = "a.xml"', 6, "has its own"),
        ('motion = "walk.h5"', 'motion = "walk.mot"\nmodel = "a.osim"', 4, "or give `events`"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nevents = { lefft = [1, 2] }', 6, "'lefft'; did you mean 'left'"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nevents = { left = [2, 1], right = [1, 2] }', 6, "in order"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nevents = { left = [1, 2] }', 6, "of both sides"),
        ("candidates = 4", "candidtes = 4", 7, "match.candidtes"),
        ("candidates = 4", "duration = 1", 7, "2 to 600 s"),
        ("candidates = 4", "speed = -1", 7, "is a weight"),
        ("candidates = 4", "feed_forward = 0", 7, "match.feed_forward: is greater than 0 and at most 1, not 0"),
        ("candidates = 4", "reach = nan", 7, "match.reach: is greater than 0 and at most 1000"),
        ("candidates = 4", "walk = 0", 7, "is a number of candidates"),
        ("candidates = 4", "candidates = 0", 7, "match.candidates: candidates must be a positive"),
        ("candidates = 4", 'strategy = ""', 7, "match.strategy: there is no search strategy ''"),
        ("candidates = 4", "sigma = 3", 7, "match.sigma: sigma must be above 0"),
        ("candidates = 4", "[adapt]\npopulation = 1", 8, "adapt.population: the population must be"),
        ("candidates = 4", "[adapt]\nuntil = nan", 8, "adapt.until: until must be a finite number"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\n[[recording]]\nmotion = "walk.h5"', 6, "is there twice"),
        ('motion = "walk.h5"', 'motion = " "', 5, "name the file of the recording"),
        ('motion = "walk.h5"', 'motion = "walk.mot"\nfilter = -1', 6, "is a frequency greater than 0, not -1 Hz"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nbegin = nan', 6, "is a time of 0 or more, not nan s"),
        ('motion = "walk.h5"', 'motion = "walk.h5"\nevents = { left = [1, nan], right = [1, 2] }', 6, "in order"),
        ('name = "heavy"', 'name = "a\\nb"', 8, "a change has a name, text in one line"),
        ("seeds = 2", "hip_offset = 100", 3, "is -90 to 90 degrees, not 100"),
        ('name = "heavy"', 'name = "no change"', 9, "is the name of another one"),
        ('name = "heavy"', "", 8, "a change has a name"),
        ('"character.bodies.torso.mass" = 40.0', "", 8, "changes nothing"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(tmp_path: Path, old: str, new: str, line: int, words: str):
    with pytest.raises(SceneError, match=words) as caught:
        written(tmp_path, TEXT.replace(old, new, 1))
    assert f"patient.toml:{line}: " in str(caught.value)


@pytest.mark.parametrize("table", ["recording", "change"])
def test_recordings_and_changes_are_needed(tmp_path: Path, table: str):
    text = TEXT.replace(f"[[{table}]]", f"[[{table}s]]")
    with pytest.raises(SceneError, match=table):
        written(tmp_path, text)
    with pytest.raises(SceneError, match=r"patient.toml.*give one at least"):
        written(tmp_path, f'scene = "fwalk"\n{"change" if table == "recording" else "recording"} = []\n{table} = []\n')
