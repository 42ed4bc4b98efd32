"""Tables for notebooks."""

from warpmuscle.core.html_table import html_table


def test_texts_stay_text():
    table = html_table(("<b>",), [("<script>alert(1)</script>",), ("a & b",)])
    assert "<script>" not in table
    assert "<b>" not in table
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in table
    assert "a &amp; b" in table
    assert table.count("<tr>") == 3
