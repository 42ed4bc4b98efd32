"""What is typed first of inverse problems: names of files, names of coordinates, tables."""

import numpy as np
import pytest

from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import load
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.dynamics import Moments, inverse_dynamics, trials_of
from warpmuscle.inverse.files import angle_names
from warpmuscle.inverse.trial import Coordinates

MOTION = "reach\nnRows=2\nnColumns=2\ninDegrees=yes\nendheader\ntime\t{name}\n0.0\t0.0\n0.1\t90.0\n"
FOUND = Moments(("hip", "knee"), ("N m", "N m"), np.array([0.0, 0.1]), np.array([[1.0, 2.0], [3.0, 4.0]]))


def test_a_trial_may_be_the_name_of_its_file(tmp_path):
    arm = load("arm18")
    name = sorted(angle_names(arm))[0]
    (tmp_path / "reach.mot").write_text(MOTION.format(name=name))
    path = tmp_path / "reach.mot"
    for given in (path, str(path), [path], (str(path),)):
        (trial,) = trials_of(given, arm)
        assert trial[name].tolist() == pytest.approx([0.0, np.pi / 2])
    known = Coordinates((name,), np.array([0.0, 0.1]), np.zeros((2, 1)))
    assert trials_of([known, path], arm)[0] is known
    with pytest.raises(ArgumentError, match=r"Coordinates of each trial or the name of its \.mot file"):
        trials_of({name: [0.0]}, arm)


def test_moments_go_by_name_and_become_a_table():
    pytest.importorskip("pandas")
    assert FOUND["knee"].tolist() == [2.0, 4.0]
    table = FOUND.to_dataframe()
    assert list(table.columns) == ["hip", "knee"]
    assert table.index.name == "time"
    assert table["hip"].loc[0.1] == 3.0


def test_activations_go_by_muscle():
    pytest.importorskip("pandas")
    rows = np.array([[0.1], [0.2]])
    found = Activations(("soleus",), FOUND.times, *(rows,) * 5, FOUND, FOUND.values, frozenset(), np.ones(2, dtype=int))
    assert found["soleus"].tolist() == [0.1, 0.2]
    assert found.to_dataframe()["soleus"].tolist() == [0.1, 0.2]
    with pytest.raises(ArgumentError, match="no muscle 'rSOL'; there are soleus"):
        found["rSOL"]


@pytest.mark.parametrize(("name", "hint"), [
    ("plot", r"Moments has no 'plot'; to_dataframe\(\)\.plot\(\) draws it"),
    ("save", r"to_dataframe\(\)\.to_csv\('table.csv'\) writes it"),
    ("time", "did you mean 'times'"),
    ("torque", "it has names, units, times, values, residuals"),
])  # fmt: skip
def test_a_wrong_name_says_what_to_type(name, hint):
    with pytest.raises(AttributeError, match=hint):
        getattr(FOUND, name)


def test_a_wrong_argument_says_which_is_meant():
    for name, hint in {"cutoff": "filter=6.0", "motion": "coordinates='walk.mot'", "grf": "read_loads"}.items():
        with pytest.raises(TypeError, match=f"inverse_dynamics has no argument '{name}'; .*{hint}"):
            inverse_dynamics("arm18", "reach.mot", **{name: 6})
