"""Models that nobody has written on purpose: they load, or are refused in one line that names the file."""

import warnings
from pathlib import Path
from random import Random

import pytest
from fuzzing.models import MODELS, mutated_model

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build import load_model


@pytest.mark.parametrize("name", MODELS)
def test_the_models_themselves_load(name: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(MODELS[name])
    notes = Notes()
    assert load_model(path, notes).character.muscles
    assert {note.text.split()[0] for note in notes.ignored} <= {"attached_geometry", "HuntCrossleyForce"}


def test_500_mutated_models_load_or_are_refused_in_one_line(tmp_path: Path):
    path, refused = tmp_path / "model.osim", list[tuple[int, SceneError]]()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for case in range(500):
            rng = Random(case)
            path.write_bytes(mutated_model(MODELS[rng.choice(list(MODELS))], rng))
            try:
                load_model(path, Notes())
            except SceneError as error:
                refused.append((case, error))
    for case, error in refused:
        assert error.file == path, (case, str(error))
        assert error.line > 0 or "limit" in str(error), (case, str(error))
        assert "\n" not in str(error)
        assert len(str(error)) < 1300
    assert 150 < len(refused) < 450
