"""Comparison of results, whatever they consist of."""

import dataclasses

import numpy as np


def assert_same(a: object, b: object) -> None:
    """Compare dataclasses, tables, lists and tuples of arrays member by member, but for those that do not count."""
    if dataclasses.is_dataclass(a):
        for field in (field for field in dataclasses.fields(a) if field.compare):
            assert_same(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, dict):
        assert a.keys() == b.keys()
        for name in a:
            assert_same(a[name], b[name])
    elif isinstance(a, tuple | list) and a and not isinstance(a[0], str):
        assert isinstance(b, tuple | list)
        for one, other in zip(a, b, strict=True):
            assert_same(one, other)
    else:
        np.testing.assert_array_equal(a, b)
