"""The text of SCONE's files: what it says, with lines, and what no reader may be led to."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import LIMITS
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.scone.numbers import FreeNumber, as_scene_number, read_number
from warpmuscle.formats.scone.zml import Node, parse
from warpmuscle.scene.number import Free


def read(folder: Path, text: str, name: str = "top.scone") -> Node:
    (folder / name).write_text(text)
    return parse(folder / name, Notes())


@pytest.fixture
def few_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    """A small limit, which takes less time to reach."""
    monkeypatch.setitem(LIMITS, "elements", LIMITS["elements"]._replace(most=500))


def refused(folder: Path, text: str) -> str:
    with pytest.raises(SceneError) as caught:
        read(folder, text)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_keys_values_blocks_and_lists_are_read_with_their_lines(tmp_path: Path):
    text = (
        '# first\nOuter {\n a = 1 b = "two words" /* not\n read */\n Inner { c = -90..90 }\n list [ 1 { d = 2 } 3 ]\n}'
    )
    outer = read(tmp_path, text).need("Outer")
    assert [(node.key, node.line) for node in outer.children] == [("a", 3), ("b", 3), ("Inner", 5), ("list", 6)]
    assert outer.need("a").number() == 1.0
    assert outer.string_of("b") == "two words"
    assert outer.need("Inner").string_of("c") == "-90..90"
    first, second, third = outer.need("list").every("")
    assert (first.number(), second.need("d").number(), third.number()) == (1.0, 2.0, 3.0)


def test_vectors_are_x_y_z_or_three_numbers(tmp_path: Path):
    top = read(tmp_path, "a { x = 1 z = 3 } b = [ 4 5 6 ] c { x = 1 w = 2 }")
    assert top.vector_of("a") == (1.0, 0.0, 3.0)
    assert top.vector_of("b") == (4.0, 5.0, 6.0)
    assert top.vector_of("d", (7.0, 8.0, 9.0)) == (7.0, 8.0, 9.0)
    with pytest.raises(SceneError, match="w: not known in `c`"):
        top.vector_of("c")


def test_included_files_stand_where_they_are_named_and_keep_their_lines(tmp_path: Path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "inner.scone").write_text("\nb = 2\n<< deeper.scone >>")
    (tmp_path / "data" / "deeper.scone").write_text("c = 3")
    outer = read(tmp_path, "Outer { a = 1 << data/inner.scone >> d = 4 }").need("Outer")
    assert [(node.key, node.file.name, node.line) for node in outer.children] == [
        ("a", "top.scone", 1), ("b", "inner.scone", 2), ("c", "deeper.scone", 1), ("d", "top.scone", 1),
    ]  # fmt: skip


def test_an_included_file_is_also_found_without_its_folder_which_is_noted(tmp_path: Path):
    (tmp_path / "inner.scone").write_text("b = 2")
    (tmp_path / "top.scone").write_text("<< data/inner.scone >>")
    notes = Notes()
    assert parse(tmp_path / "top.scone", notes).need("b").number() == 2.0
    assert [(note.line, note.reason) for note in notes.ignored] == [(1, "not there; took inner.scone")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a {\n b = 1", "top.scone:1: a: `{` is not closed: the file ends before `}`"),
        ("a = 1\n}", "top.scone:2: `}` does not belong here"),
        ("a [ 1 }", "top.scone:1: `}` does not belong here"),
        ("a = = 1", "top.scone:1: a: a key is followed by = and a value, or by braces"),
        ("a", "top.scone:1: a: a key is followed by = and a value, or by braces"),
        ('\na = "open', "top.scone:2: cannot be read from '\"open' on"),
        ("/* open", "cannot be read from"),
        ("<< ../up.scone >>", "top.scone:1: '../up.scone' leads out of the folder; name a file in it or below"),
        ("<< /etc/passwd >>", "leads out of the folder"),
        ("<< C:\\windows\\x.scone >>", "leads out of the folder"),
        ("<< link.scone >>", "leads out of the folder, to"),
        ("<< gone.scone >>", "top.scone:1: there is no file 'gone.scone' here"),
        ("<< top.scone >>", "top.scone:1: 'top.scone' includes itself"),
        ("<<  >>", "'' is not the name of a file"),
        ("a { " * 60 + "}" * 60, "the limit `nesting`"),
        ("a { b = 1 } " * 300, "the limit `elements`"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(tmp_path: Path, few_elements: None, text: str, said: str):
    outside = tmp_path / "outside.scone"
    outside.write_text("a = 1")
    folder = tmp_path / "inside"
    folder.mkdir()
    (folder / "link.scone").symlink_to(outside)
    assert said in refused(folder, text)


def test_files_that_double_each_other_are_not_read_for_ever(tmp_path: Path, few_elements: None):
    for level in range(30):
        (tmp_path / f"f{level}.scone").write_text(f"<< f{level + 1}.scone >>\n" * 2)
    (tmp_path / "f30.scone").write_text("a = 1")
    assert "the limit `elements`" in refused(tmp_path, "<< f0.scone >>")


def number(text: str, factor: float = 0.1) -> float | FreeNumber:
    return read_number(Node("KL", Path("x.scone"), 7, text), factor)


def test_free_numbers_have_a_mean_a_spread_and_bounds():
    assert number("-0.105") == -0.105
    assert number("1.0~0.01<0,2>") == FreeNumber(1.0, 0.01, 0.0, 2.0)
    assert number("~-2<-10,10>", 0.05) == FreeNumber(-2.0, 0.1, -10.0, 10.0)
    assert number("~0<-1,1>") == FreeNumber(0.0, 0.01, -1.0, 1.0)  # the least spread
    assert number("3~0.5") == FreeNumber(3.0, 0.5, -2.0, 8.0)
    assert as_scene_number(number("~1<0,2>"), 1.5) == Free(1.5, min=0.0, max=2.0)
    assert as_scene_number(number("~1<0,2>"), 9.0) == Free(2.0, min=0.0, max=2.0)
    assert as_scene_number(0.3) == 0.3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("one", "'one' is not a number"), ("nan", "'nan' is not a number"), ("1e400", "is beyond"),
        ("~1<2,0>", "its bounds run down from 2 to 0"), ("~5<0,2>", "5 is outside of its bounds from 0 to 2"),
        ("1~0<0,2>", "its spread must be greater than 0"), ("~1<0>", "is not a free number"),
        ("~<0,1>", "'' is not a number"), ("1~x<0,2>", "'x' is not a number"),
    ],
)  # fmt: skip
def test_what_is_no_number_is_refused_with_its_line(text: str, said: str):
    with pytest.raises(SceneError, match=r"x.scone:7: KL: ") as caught:
        number(text)
    assert said in str(caught.value)


def test_a_name_with_a_dollar_stands_for_a_value_a_list_or_a_block_that_it_was_given(tmp_path: Path):
    (tmp_path / "part.zml").write_text("inner = $gain\n$gain = 3\nlast = $gain\n")
    (tmp_path / "top.zml").write_text(
        "$gain = ~1.5<0,2>\n$way = [ 1 0 2 ]\n$limits = { min = 1 }\nfirst { offset = $way gain = $gain }\n"
        "second { offset = $way to = $limits list [ $gain 4 ] }\n<< part.zml >>\n"
    )
    top = parse(tmp_path / "top.zml", Notes())
    first, second = top.need("first"), top.need("second")
    assert first.vector_of("offset") == second.vector_of("offset") == (1.0, 0.0, 2.0)
    assert first.string_of("gain") == top.string_of("inner") == "~1.5<0,2>"
    assert second.need("to").number_of("min", 0.0) == 1.0
    assert [one.text() for one in second.need("list").children] == ["~1.5<0,2>", "4"]
    assert top.number_of("last", 0.0) == 3.0
    assert {node.key for node in top.children} == {"first", "second", "inner", "last"}
    (tmp_path / "bad.zml").write_text("one = 1\ntwo = $three\n$three = 3\n")
    with pytest.raises(SceneError, match=r"bad.zml:2: two: \$three has no value here"):
        parse(tmp_path / "bad.zml", Notes())


def test_values_of_names_that_grow_without_end_are_refused(tmp_path: Path):
    lines = ["$a0 = [ 1 2 3 4 5 6 7 8 9 10 ]"]
    lines += [f"$a{k + 1} = {{ " + " ".join(f"x{j} = $a{k}" for j in range(10)) + " }" for k in range(12)]
    (tmp_path / "bomb.zml").write_text("\n".join(lines) + "\n")
    with pytest.raises(SceneError, match=r"bomb.zml:\d+: "):
        parse(tmp_path / "bomb.zml", Notes())


def test_a_name_counts_to_the_end_of_its_braces_and_of_its_file(tmp_path: Path):
    # xo/serialization/prop_node_serializer_zml.cpp of SCONE: macros are limited by scope
    (tmp_path / "part.zml").write_text("$delay = 0.005\ninner = $delay\n")
    (tmp_path / "a.zml").write_text(
        "$delay = 0.1\nfirst { $delay = 0.02 x = $delay }\n<< part.zml >>\nlast = $delay\n"
        "said = \"a${delay}b ${delay}\" quoted = 'two words'\n"
    )
    top = parse(tmp_path / "a.zml", Notes())
    assert top.need("first").number_of("x", 0.0) == 0.02
    assert (top.number_of("inner", 0.0), top.number_of("last", 0.0)) == (0.005, 0.1)
    assert top.string_of("said") == "a0.1b 0.1"
    assert top.string_of("quoted") == "two words"
    (tmp_path / "b.zml").write_text('first { $delay = 1 }\nlast = "${delay}"\n')
    with pytest.raises(SceneError, match=r"b.zml:2: last: \$delay has no value here"):
        parse(tmp_path / "b.zml", Notes())


def test_files_of_older_versions_say_types_include_and_comment_in_their_way(tmp_path: Path):
    (tmp_path / "part.zml").write_text("; what is measured\nMeasure { type = GaitMeasure weight = 3 }\n")
    (tmp_path / "a.zml").write_text(
        'Optimizer = {\n  type = CmaOptimizer ; as of 2017\n  #include "part.zml"\n  // more\n'
        "  INCLUDE = { file = part.zml }\n}\n"
    )
    optimizer = parse(tmp_path / "a.zml", Notes()).need("CmaOptimizer")
    assert [one.number_of("weight", 0.0) for one in optimizer.every("GaitMeasure")] == [3.0, 3.0]
    optimizer.tell_unused()
