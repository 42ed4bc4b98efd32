"""Damaged recordings are refused by those who read them, in one line that names the file; the tool sees what is not."""

import copy
import re
import sys
import warnings
from pathlib import Path
from random import Random

import numpy as np
import pytest

import small_leg
from leg_model import leg, markers_of, walk
from warpmuscle.core.errors import Error
from warpmuscle.formats.load import load
from warpmuscle.inverse.chain import chain_of
from warpmuscle.inverse.emg import read_emg
from warpmuscle.inverse.files import read_coordinates, read_markers
from warpmuscle.inverse.loads import read_loads

ROOT = Path(__file__).parents[2]
if str(ROOT / "tools") not in sys.path:
    sys.path.append(str(ROOT / "tools"))

from damaging import cases  # noqa: E402
from damaging.trial import NAMES, Columns, Trial, smooth_emg  # noqa: E402
from fuzzing.judge import Verdict  # noqa: E402

FEWEST = {"markers": 15, "coordinates": 14, "loads": 16, "emg": 14}  # damages that the reading of a file sees


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return load(small_leg.small_leg(tmp_path_factory.mktemp("model")), ignored=[])


@pytest.fixture(scope="module")
def sound(scene, tmp_path_factory) -> Trial:
    """Short recordings of two small models: markers of one, and all else of the other."""
    folder = tmp_path_factory.mktemp("leg")
    chain = chain_of(leg(folder))
    markers = markers_of(chain, walk(chain, frames=20))
    motion = small_leg.motion(20)
    ground = small_leg.loads(motion.times)
    plate = ground.plates[0]
    names = [f"calcn_ground_{part}{axis}" for part in ("force_v", "force_p", "torque_") for axis in "xyz"]
    starts = ("calcn_ground_force_v", "calcn_ground_force_p", "calcn_ground_torque_")
    turned = [not name.endswith(("_tx", "_ty", "_tz")) for name in motion.names]
    return Trial(
        next(folder.glob("*.osim")), list(markers.names), markers.times, 1000.0 * markers.positions,
        ["" for _ in markers.names],
        Columns(list(motion.names), motion.times, np.where(turned, np.degrees(motion.values), motion.values),
                {"inDegrees": "yes"}),
        Columns(names, ground.times, np.concatenate([plate.force, plate.point, plate.moment], axis=1)),
        [("calcn_r", *starts)], smooth_emg(list(scene.character.muscles)[:4], (0.0, 0.2)),
    )  # fmt: skip


def read(kind: str, folder: Path, scene) -> None:
    if kind == "markers":
        read_markers(folder / NAMES["markers"])
    elif kind == "coordinates":
        read_coordinates(folder / NAMES["coordinates"], scene)
    elif kind == "loads":
        read_loads(folder / NAMES["described"])
    else:
        read_emg(folder / NAMES["emg"], list(scene.character.muscles))


@pytest.mark.parametrize("kind", FEWEST)
def test_each_damage_that_a_file_shows_is_one_line_with_its_name(kind, sound, scene, tmp_path):
    refused = 0
    for number, damage in enumerate(cases.KINDS[kind]):
        if damage.name in ("gap of all bodies but one", "two labels swapped", "two labels swapped half-way", "spike"):
            continue  # these need a whole body, and are not seen by reading
        trial = copy.deepcopy(sound)
        damage.change(trial, Random(number))
        folder = tmp_path / str(number)
        folder.mkdir()
        trial.write(folder, kind)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            try:
                read(kind, folder, scene)
            except Error as error:
                refused += 1
                text = str(error)
                assert "\n" not in text
                assert any(name in text for name in NAMES.values()), (damage.name, text)
                assert damage.told is not None, (damage.name, text)
                assert re.search(damage.told, text), (damage.name, text)
    assert refused >= FEWEST[kind]


def test_sound_recordings_are_read(sound, scene, tmp_path):
    sound.write(tmp_path, "markers")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in FEWEST:
            read(kind, tmp_path, scene)


def test_each_damage_comes_once_before_any_comes_again():
    every = sum(map(len, cases.KINDS.values()))
    found = cases.cases(every + 5, list(cases.KINDS), seed=3)
    assert len({(case.kind, case.number) for case in found}) == every + 5
    assert [case.damage.name for case in found[:5]] == [case.damage.name for case in found[every:]]


def test_silence_about_a_damage_is_a_complaint():
    case = cases.Case("emg", 0, 1)
    assert case.damage.told
    assert "says nothing of" in cases._complaints(case, Verdict(), Path(), Path())[0]
    wrong = Verdict(refused=True, said="error: something")
    assert "does not name the file" in cases._complaints(case, wrong, Path(), Path())[0]
    right = Verdict(refused=True, said="error: emg.csv:3: column 'a' is not a finite number")
    assert cases._complaints(case, right, Path(), Path()) == []
