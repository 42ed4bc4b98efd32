"""SCONE's files of parameters: read, written, and refused with their line."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.scone.parameters import Parameter, read_parameters, write_parameters


def test_a_line_is_a_name_with_best_value_mean_and_spread(tmp_path: Path):
    path = tmp_path / "a.par"
    path.write_text("leg.KL   \t1.5\t1.25\t0.125\t\n\nhip.offset\t-2e-3 0 1\n")
    assert read_parameters(path) == {
        "leg.KL": Parameter("leg.KL", 1.5, 1.25, 0.125, 1),
        "hip.offset": Parameter("hip.offset", -0.002, 0.0, 1.0, 3),
    }


def test_what_is_written_is_read_again(tmp_path: Path):
    rows = [Parameter("a", 1.0, -2.5, 0.25), Parameter("S00111.soleus.KF", 1.4755581, 1.4719509, 0.037201097)]
    write_parameters(tmp_path / "b.par", rows)
    found = read_parameters(tmp_path / "b.par")
    assert [one[:4] for one in found.values()] == [one[:4] for one in rows]
    assert (tmp_path / "b.par").read_text().splitlines()[0] == "a               \t1\t-2.5\t0.25\t"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a 1 2\n", "a.par:1: a line has a name, its best value, mean and spread, not 3 words"),
        ("a 1 2 3\nb 1 x 3\n", "a.par:2: 'x' is not a finite number"),
        ("a 1 nan 3\n", "'nan' is not a finite number"), ("a 1 1e999 3\n", "'1e999' is not a finite number"),
        ("a 1 2 -3\n", "the spread of a is below 0"), ("a 1 2 3\na 1 2 3\n", "a.par:2: a stands in line 1 already"),
        ("\n# nothing\n", "there is no parameter in it"),
    ],
)  # fmt: skip
def test_a_line_that_is_no_parameter_is_refused(tmp_path: Path, text: str, said: str):
    (tmp_path / "a.par").write_text(text)
    with pytest.raises(SceneError) as caught:
        read_parameters(tmp_path / "a.par")
    assert said in str(caught.value)


@pytest.mark.parametrize("row", [("", 1, 1, 1), ("a b", 1, 1, 1), ("a", float("nan"), 1, 1), ("a", 1, 1, -1)])
def test_nothing_is_written_of_what_could_not_be_read_again(tmp_path: Path, row: tuple[str, float, float, float]):
    with pytest.raises(SceneError):
        write_parameters(tmp_path / "a.par", [Parameter(*row)])
    assert not (tmp_path / "a.par").exists()


def test_no_file_is_written_for_a_scene_without_a_number_that_scone_names(tmp_path: Path):
    with pytest.raises(SceneError, match="no parameter to write"):
        write_parameters(tmp_path / "a.par", [])
    assert not (tmp_path / "a.par").exists()
