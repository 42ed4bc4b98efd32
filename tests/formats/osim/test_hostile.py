"""Models that nobody has written on purpose: they load, or are refused in one line that names the file."""

import warnings
from pathlib import Path
from random import Random

import pytest
from fuzzing.models import MODELS, mutated_model

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import LIMITS
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build import load_model


@pytest.mark.parametrize("name", MODELS)
def test_the_models_themselves_load(name: str, tmp_path: Path):
    path = tmp_path / name
    path.write_text(MODELS[name])
    notes = Notes()
    assert load_model(path, notes).character.muscles
    assert {note.text.split()[0] for note in notes.ignored} <= {
        "attached_geometry",
        "HuntCrossleyForce",
        "Model",
        "Schutte1993Muscle_Deprecated",
    }  # ranges without a force, and what of an old muscle is taken otherwise


def polynomial(dimension: int, order: str) -> str:
    """A muscle whose path is a polynomial of one coefficient."""
    inner = f"<coefficients>1</coefficients><dimension>{dimension}</dimension><order>{order}</order>"
    function = f"<MultivariatePolynomialFunction>{inner}</MultivariatePolynomialFunction>"
    paths = " ".join(["/jointset/pin/q"] * dimension)
    path = f"<coordinate_paths>{paths}</coordinate_paths><length_function>{function}</length_function>"
    kind = "Millard2012EquilibriumMuscle"
    return small.pendulum(forces=f'<{kind} name="m"><FunctionBasedPath>{path}</FunctionBasedPath></{kind}>')


def spline(half_order: str, knots: int) -> str:
    """A joint that turns by a spline."""
    x, y = " ".join(map(str, range(knots))), " ".join(["0.1", "0.2"] * (knots // 2))
    given = f'<GCVSpline name="f"><half_order>{half_order}</half_order><x>{x}</x><y>{y}</y></GCVSpline>'
    axes = small.axes(rotation1=("q", "0 0 1", given))
    return small.model(
        small.body("rod"), small.joint("CustomJoint", "pin", "ground", "rod", small.coordinate("q"), axes)
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (polynomial(6, "20"), "1 coefficient for the 230230 terms"),
        (polynomial(6, "100"), "an order of 0 to 20"),
        (polynomial(1, "1000000000"), "an order of 0 to 20"),
        (polynomial(1, "-5"), "an order of 0 to 20, not 1 and -5"),
        (polynomial(3000, "0"), "1 to 10 dimensions"),
        (spline("500", 3000), "must be from 1 to 4, is 500"),
        (spline("-3", 4), "must be from 1 to 4, is -3"),
    ],
)
def test_numbers_that_would_take_for_ever_are_refused_with_their_line(tmp_path: Path, text: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        load_model(small.written(tmp_path, text), Notes())
    assert caught.value.line > 0


def test_models_of_too_many_values_are_refused_with_their_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(LIMITS, "values", LIMITS["values"]._replace(most=100))
    with pytest.raises(SceneError, match=r"small\.osim: \d+ values are more than 100") as caught:
        load_model(small.written(tmp_path, polynomial(1, "0")), Notes())
    assert caught.value.file is not None


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
