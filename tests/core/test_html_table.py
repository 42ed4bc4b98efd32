"""Tables for notebooks, and short texts of records."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.html_table import Tabulated, html_table


def test_texts_stay_text():
    table = html_table(("<b>",), [("<script>alert(1)</script>",), ("a & b",)])
    assert "<script>" not in table
    assert "<b>" not in table
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in table
    assert "a &amp; b" in table
    assert table.count("<tr>") == 3


@dataclass(frozen=True, repr=False)
class Forces(Tabulated):
    names: tuple[str, ...]
    values: Any
    note: str = ""
    limit: float = 0.0
    known: Any = None


def test_a_record_of_many_numbers_says_how_many_and_not_all():
    values = np.linspace(-1.0, 2.0, 100_000).reshape(1000, 100)
    values[0, 0] = np.nan
    found = Forces(tuple(f"<m{k}>" for k in range(100)), values, "", 1.0 / 3.0, {"a": np.zeros(5000)})
    assert len(repr(found)) < 250
    assert repr(found).startswith("Forces(names: <m0>, <m1>, <m2>, <m3>, <m4>, <m5>, ... (100 in all), ")
    assert "values: 1000 x 100 from -1 to 2" in repr(found)
    assert "limit: 0.3333" in repr(found)
    table = found._repr_html_()
    assert len(table) < 1000
    assert "&lt;m0&gt;" in table
    assert "<m0>" not in table
    empty = Forces((), np.zeros((0, 3)), known=[np.full(3, np.nan), object()])
    assert repr(empty).startswith("Forces(names: none, values: 0 x 3")


def test_what_the_inverse_problems_find_is_short_in_a_notebook():
    from warpmuscle.inverse.dynamics import Moments

    found = Moments(("knee",), ("N m",), np.arange(5000.0), np.ones((5000, 1)))
    assert repr(found) == (
        "Moments(names: knee, units: N m, times: 5000 from 0 to 4999, values: 5000 x 1 from 1 to 1, residuals: 0)"
    )
    assert found._repr_html_().count("<tr>") == 6
