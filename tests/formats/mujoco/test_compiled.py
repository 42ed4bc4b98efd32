"""Files are looked at before MuJoCo compiles them: what they name, include and bring; errors are one line."""

import sys
from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.mujoco.compiled import compiled

BODY = '<worldbody><body><joint/><geom size="1"/></body></worldbody>'


def refused(path: Path, text: str) -> str:
    path.write_text(text)
    with pytest.raises(SceneError) as error:
        compiled(path)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("<robot/>", 1, "a model of MuJoCo begins with <mujoco>, not <robot>"),
        ("<mujoco>\n<extension><plugin plugin='a'/></extension></mujoco>", 2, "brings plugins, which are not run"),
        ("<mujoco>\n<asset><mesh file='/etc/passwd'/></asset></mujoco>", 2, "is not a path from the model's folder"),
        ("<mujoco>\n<include file='C:\\x.xml'/></mujoco>", 2, "is not a path from the model's folder"),
        ("<mujoco><compiler meshdir='https://a.b/c'/></mujoco>", 1, "is not a path from the model's folder"),
        ("<!DOCTYPE a><mujoco/>", 1, "a model has no document type"),
        ("<mujoco>\n<a", 2, "not sound XML"),
        ("<mujoco>" + "<a>" * 60 + "</a>" * 60 + "</mujoco>", 1, "the limit `nesting`"),
    ],
)
def test_what_no_model_says_is_refused_with_its_line(tmp_path: Path, text: str, line: int, message: str):
    said = refused(tmp_path / "model.xml", text)
    assert f"model.xml:{line}: " in said
    assert message in said


def test_what_only_mujocos_parser_takes_is_taken_and_looked_at(tmp_path: Path):
    """Two hyphens within a comment, and attributes that no blank parts: published models have them."""
    pytest.importorskip("mujoco")
    head, path = "<mujoco>\n<!-- yaw -- see <a> & the log -->\n", tmp_path / "model.xml"
    path.write_text(head + '<worldbody><body name="b"pos="0 0 1"><joint/><geom size="1"/></body></worldbody></mujoco>')
    assert compiled(path).nv == 1
    for asset in ("<mesh name=\"a\"file='/etc/passwd'/>", "<mesh name='a'file=\"/etc/passwd\"/>"):
        assert "model.xml:3: file '/etc/passwd' is not a path" in refused(
            path, f"{head}<asset>{asset}</asset></mujoco>"
        )
    assert "brings plugins" in refused(path, f"{head}<extension><plugin plugin='a'name='b'/></extension></mujoco>")


def test_what_is_included_is_looked_at_too(tmp_path: Path):
    (tmp_path / "part.xml").write_text("<mujocoinclude>\n<include file='more.xml'/></mujocoinclude>")
    (tmp_path / "more.xml").write_text("<mujocoinclude>\n\n<texture fileup='/a.png'/></mujocoinclude>")
    assert "more.xml:3: fileup '/a.png'" in refused(
        tmp_path / "model.xml", "<mujoco><include file='part.xml'/></mujoco>"
    )


ATTACHING = (
    '<asset><model name="a" file="{0}"/></asset><worldbody><frame><attach model="a" prefix="x"/></frame></worldbody>'
)


def attaching(file: str) -> str:
    return f"<mujoco>{ATTACHING.format(file)}</mujoco>"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "<mujoco>\n<asset><mesh file='/etc/passwd'/></asset></mujoco>",
            "part.xml:2: file '/etc/passwd' is not a path",
        ),
        ("<mujoco>\n<extension><plugin plugin='a'/></extension></mujoco>", "part.xml:2: <extension> brings plugins"),
        ("<robot/>", "part.xml:1: a model of MuJoCo begins with <mujoco>"),
        (attaching("model.xml"), "it attaches itself, or a model that attaches it"),
        (attaching("part.xml"), "it attaches itself, or a model that attaches it"),
    ],
)
def test_what_is_attached_is_looked_at_too(tmp_path: Path, text: str, message: str):
    """MuJoCo's compiler itself crashes where a model attaches itself."""
    (tmp_path / "part.xml").write_text(text)
    assert message in refused(tmp_path / "model.xml", attaching("part.xml"))


@pytest.mark.parametrize("part", ["part.xml", "parts/part.xml"])
def test_what_is_attached_is_looked_at_wherever_it_is_named_and_found(tmp_path: Path, part: str):
    (tmp_path / "parts").mkdir()
    (tmp_path / part).write_text("<mujoco>\n<asset><mesh file='/etc/a'/></asset></mujoco>")
    asset = "<asset><model name='a' file='part.xml'/></asset>"
    (tmp_path / "list.xml").write_text(f"<mujocoinclude>{asset}</mujocoinclude>")
    for of in ("<include file='list.xml'/>", asset):
        said = refused(tmp_path / "model.xml", f"<mujoco><compiler assetdir='parts'/>{of}</mujoco>")
        assert "part.xml:2: file '/etc/a' is not a path" in said


def test_models_that_are_attached_ever_again_are_too_many(tmp_path: Path):
    """Nine files, each with ten of the next one: a billion bodies."""
    (tmp_path / "0.xml").write_text(f"<mujoco>{BODY}</mujoco>")
    for k in range(1, 10):
        frames = '<frame><attach model="a" prefix="x"/></frame>' * 10
        asset = f'<asset><model name="a" file="{k - 1}.xml"/></asset>'
        (tmp_path / f"{k}.xml").write_text(f"<mujoco>{asset}<worldbody>{frames}</worldbody></mujoco>")
    assert "the limit `elements`" in refused(tmp_path / "model.xml", attaching("9.xml"))


@pytest.mark.parametrize(
    ("text", "limit"),
    [
        (f'<replicate count="1000000">{BODY}</replicate>', "elements"),
        ('<replicate count="1000">' * 3 + "<geom/>" + "</replicate>" * 3, "elements"),
        ('<flexcomp type="grid" count="2000 2000 100"/>', "elements"),
        ('<size nkey="200000000"/>', "elements"),
        ('<replicate count="1e9"><include file="part.xml"/></replicate>', "elements"),
        ('<hfield nrow="100000" ncol="100000"/>', "asked"),
        ('<replicate count="nan"><geom/></replicate>', "elements"),
        ('<texture builtin="flat" width="100000" height="100000"/>', "asked"),
        ('<numeric size="2000000000"/>', "asked"),
        ('<size nuser_body="1000000000"/>', "asked"),
        ('<general dyntype="user" actdim="1000000000"/>', "asked"),
        ('<user dim="1000000000"/>', "asked"),
    ],
)
def test_a_short_text_that_asks_for_much_memory_is_refused(tmp_path: Path, text: str, limit: str):
    (tmp_path / "part.xml").write_text("<mujocoinclude><geom/></mujocoinclude>")
    said = refused(tmp_path / "model.xml", f"<mujoco>\n{text}</mujoco>")
    assert f"the limit `{limit}`" in said


def test_what_is_large_in_space_and_little_in_memory_is_taken(tmp_path: Path):
    pytest.importorskip("mujoco")
    grid = '<asset><hfield name="h" nrow="50" ncol="60" size="1 1 1 1"/></asset>'
    plane, bodies = '<geom type="plane" size="10000 10000 1"/>', '<body><joint/><geom size="1"/></body>'
    text = (
        f'<mujoco>{grid}<worldbody>{plane}<replicate count="3" offset="9 0 0">{bodies}</replicate></worldbody></mujoco>'
    )
    (tmp_path / "model.xml").write_text(text)
    assert compiled(tmp_path / "model.xml").nv == 3
    (tmp_path / "part.xml").write_text(f"<mujoco>{BODY}</mujoco>")
    (tmp_path / "model.xml").write_text(attaching("part.xml"))
    assert compiled(tmp_path / "model.xml").nv == 1


def test_files_that_include_each_other_are_named(tmp_path: Path):
    (tmp_path / "part.xml").write_text("<mujocoinclude><include file='part.xml'/></mujocoinclude>")
    said = refused(tmp_path / "model.xml", "<mujoco><include file='part.xml'/></mujoco>")
    assert said.endswith("part.xml: files include each other: 'part.xml' includes 'part.xml'")
    (tmp_path / "part.xml").write_text("<mujocoinclude><include file='more.xml'/></mujocoinclude>")
    (tmp_path / "more.xml").write_text("<mujocoinclude><include file='./part.xml'/></mujocoinclude>")
    said = refused(tmp_path / "model.xml", "<mujoco><include file='part.xml'/></mujoco>")
    assert "more.xml: files include each other: 'part.xml' includes 'more.xml' includes 'part.xml'" in said


def test_files_that_two_include_are_no_ring(tmp_path: Path):
    pytest.importorskip("mujoco")
    for name, text in (("a", "<include file='c.xml'/>"), ("b", "<option gravity='0 0 -1'/>"), ("c", BODY)):
        (tmp_path / f"{name}.xml").write_text(f"<mujocoinclude>{text}</mujocoinclude>")
    path = tmp_path / "model.xml"
    path.write_text("<mujoco><include file='a.xml'/><include file='b.xml'/></mujoco>")
    assert compiled(path).nv == 1


def test_errors_of_the_compiler_have_their_line(tmp_path: Path):
    pytest.importorskip("mujoco")
    said = refused(tmp_path / "model.xml", "<mujoco>\n<worldbody>\n<body><joint/></body></worldbody></mujoco>")
    assert "MuJoCo cannot compile it: " in said
    said = refused(tmp_path / "model.xml", "<mujoco>\n<worldbody>\n<nobody/></worldbody></mujoco>")
    assert "model.xml:3: MuJoCo cannot compile it: " in said


def test_without_the_package_the_extra_is_named(tmp_path: Path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    said = refused(tmp_path / "model.xml", f"<mujoco>{BODY}</mujoco>")
    assert "needs the mujoco package: pip install 'warpmuscle[mujoco]'" in said


def test_a_file_that_is_not_there(tmp_path: Path):
    with pytest.raises(SceneError, match="no such file"):
        compiled(tmp_path / "none.xml")


def test_what_mujoco_warns_of_is_written_nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """By itself it puts a MUJOCO_LOG.TXT into the working folder."""
    path = tmp_path / "model.xml"
    path.write_text('<mujoco><worldbody><body><geom size="1" euler="1 2"/></body></worldbody></mujoco>')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match="does not have enough data"):
        compiled(path)
    assert list(tmp_path.iterdir()) == [path]
