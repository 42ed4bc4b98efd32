"""Tables of numbers are read as Python reads each of their cells, however it is written."""

import numpy as np
import pytest

from warpmuscle.synergy.tables import read_table

WRITTEN = [
    "1",
    "-0",
    "-0.0",
    "1e5",
    "+3",
    ".5",
    "7.",
    "007",
    "2.2250738585072014e-308",
    "0.12345678901234567890",
    "9" * 25,
]
CHOSEN = [8, 1, 10, 2]


def rows() -> list[list[str]]:
    random = np.random.default_rng(3)
    return [[f"{x:.17g}" for x in row] for row in random.normal(size=(20, len(WRITTEN)))]


@pytest.mark.parametrize("odd", [[], WRITTEN, ["-0", *WRITTEN[1:2] * 10], ["1e400", *["2"] * 10]])
@pytest.mark.parametrize("mark", ["\t", ",", ";", " "])
def test_numbers_of_every_writing_are_those_of_python(tmp_path, mark, odd):
    every = [*rows(), *([odd] if odd else [])]
    lines = [mark.join(f"c{k}" for k in range(len(WRITTEN))), *(mark.join(row) for row in every)]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    found = read_table(tmp_path / "a.csv").columns(CHOSEN)
    expected = np.array([[float(row[k]) for k in CHOSEN] for row in every])
    assert found.tobytes() == expected.tobytes()
