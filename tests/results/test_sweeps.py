"""The file of a sweep as a table of pandas and xarray, over its axes and by their names."""

from pathlib import Path

import h5py
import numpy as np
import pytest

import warpmuscle as wm
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.results.records import Result
from warpmuscle.results.sweeps import Sweep
from warpmuscle.results.table_files import is_table, write_table
from warpmuscle.sweep.run import sweep

SCALES = {"run", "candidate", "parameter", "term"}
GRID = """
scene = "fwalk"
[set]
duration = 0.05
[search]
strategy = "random"
population = 3
candidates = 6
[grid]
seed = [3, 1]
mass = { keys = ["character.bodies.torso.mass"], values = [20, 30, 25] }
"""
LIST = """
scene = "fwalk"
seed = 4
[set]
duration = 0.05
[search]
strategy = "random"
population = 3
candidates = 4
[[run]]
name = "plain"
[[run]]
name = "light <b>"
"character.bodies.torso.mass" = 15
[[grid]]
"objective.torque" = [1, 2]
[[grid]]
weak = { keys = ["character.bodies.head.mass"], factors = [0.5] }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sweeps")
    for name, text in {"grid": GRID, "list": LIST}.items():
        (folder / f"{name}.toml").write_text(text)
        sweep(folder / f"{name}.toml", folder / f"{name}.h5", device="cpu", command="test")
    return folder


def test_a_grid_has_its_axes_as_dimensions(folder: Path):
    xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    found = wm.read(folder / "grid.h5").to_xarray()
    assert isinstance(found, xarray.Dataset)
    assert found.best_cost.dims == ("seed", "mass")
    assert found.best_params.dims == ("seed", "mass", "parameter")
    assert found.mass.values.tolist() == [20.0, 30.0, 25.0]
    assert found.mass.attrs["units"] == "kg"
    for seed in (3, 1):
        for mass in (20, 30, 25):
            one, result = found.sel(seed=seed, mass=mass), wm.read(folder / "grid.h5", f"seed={seed},mass={mass}")
            assert one.run.item() == f"seed={seed},mass={mass}"
            assert float(one.best_cost) == result.best.cost
            np.testing.assert_array_equal(one.best_params, result.best.params)
            name = result.parameters.name[0]
            assert float(one.best_params.sel(parameter=name)) == result.best.params[0]
            assert one.parameter_unit.sel(parameter=name).item() == result.parameters.unit[0]
            assert float(one.best_terms.sel(term="torque")) == result.evaluations.terms[result.best.index, 0]


def test_runs_that_are_no_grid_are_along_their_names(folder: Path):
    pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    swept = wm.read(folder / "list.h5")
    found = swept.to_xarray()
    assert found.best_cost.dims == ("run",)
    assert found.run.values.tolist() == list(swept.runs)
    assert {"entry", "torque", "weak"} <= set(found.coords)
    assert found.weak.values.tolist() == [1.0, 1.0, 0.5, 1.0, 1.0, 0.5]
    assert np.isnan(found.torque.values[2])
    assert found.sel(run=swept.runs[1]).seed.item() == 4


def test_rows_of_a_data_frame_are_runs_or_candidates(folder: Path):
    pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[data]'")
    swept = wm.read(folder / "grid.h5")
    table, every = swept.to_dataframe(), swept.to_dataframe(candidates=True)
    assert (table.index.name, table.index.tolist()) == ("run", list(swept.runs))
    assert every.index.name == "candidate"
    assert len(every) == table["evaluated"].sum() == 36
    for name in swept.runs:
        result, rows = swept.run(name), every[every["run"] == name]
        np.testing.assert_array_equal(rows["cost"], result.evaluations.cost)
        assert tuple(rows["status"]) == result.evaluations.status_names()
        np.testing.assert_array_equal(rows["term.torque"], result.evaluations.terms[:, 0])
        np.testing.assert_array_equal(rows[list(result.parameters.name)], result.evaluations.params)
        assert rows["mass"].unique().tolist() == [table.loc[name, "mass"]]
        assert table.loc[name, result.parameters.name[1]] == result.best.params[1]
    np.testing.assert_array_equal(every.groupby("run", sort=False)["cost"].min(), table["best_cost"])
    assert list(table)[:2] == ["seed", "mass"]


def test_candidates_in_xarray_have_their_runs_and_axes_beside_them(folder: Path):
    pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    swept = wm.read(folder / "grid.h5")
    found = swept.to_xarray(candidates=True)
    assert found.params.dims == ("candidate", "parameter")
    assert found.end_time.attrs["units"] == "s"
    assert float(found.cost.where(found.mass == 25).min()) == swept.to_xarray().best_cost.sel(mass=25).min()


def test_plain_xarray_finds_names_on_every_axis(folder: Path):
    xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")
    pytest.importorskip("h5netcdf", reason="no h5netcdf: pip install 'warpmuscle[data]'")
    for name in ("grid", "list"):
        for group in (None, "table", "table/axes", "all"):
            with xarray.open_dataset(folder / f"{name}.h5", group=group, engine="h5netcdf") as found:
                assert set(found.sizes) <= SCALES, group
        with xarray.open_dataset(folder / f"{name}.h5", group="table", engine="h5netcdf") as found:
            np.testing.assert_array_equal(found.run.values, wm.read(folder / f"{name}.h5").runs)


def test_a_sweep_says_what_it_is_in_a_line_and_in_a_notebook(folder: Path):
    swept = wm.read(folder / "list.h5")
    assert isinstance(swept, Sweep)
    assert (len(swept), swept.name, swept.command) == (6, "list", "test")
    assert repr(swept).startswith(
        "Sweep('list', 6 runs, over weak (2), entry (2), torque (3), candidates 24, best cost"
    )
    assert "\n" not in repr(swept)
    page = swept._repr_html_()
    assert "light &lt;b&gt;" in page or "light _b_" in page
    assert "<b>" not in page
    assert {"began", "host", "warpmuscle_version"} <= set(swept.origin)
    assert swept.best in swept.runs


def test_other_files_are_read_as_before(folder: Path):
    result = wm.read(folder / "grid.sweep" / "seed=3,mass=20.h5")
    assert isinstance(result, Result)
    with pytest.raises(ResultError, match="no run is called 'x'"):
        wm.read(folder / "grid.h5", "x")


def old(path: Path, new: Path) -> Path:
    """A file of version 3, in which runs were groups and candidates virtual datasets, of the runs of a newer one."""
    with h5py.File(new) as source, h5py.File(path, "w", track_order=True) as file:
        file.attrs.update({"format": "warpmuscle sweep", "format_version": 3, "name": "old", "command": "test"})
        file["sweep"] = source["sweep"].asstr()[()]
        runs, table, whole = (file.create_group(name, track_order=True) for name in ("runs", "table", "all"))
        for name in source["runs"]:
            with h5py.File(new.with_suffix(".sweep") / f"{name}.h5") as run:
                run.copy(run["/"], runs, name=name)
        for name in ("run", "seed", "evaluated", "best_cost", "ended", "axes"):
            source.copy(source[f"table/{name}"], table, name=name)
        count = len(source["all/cost"])
        for name in ("cost", "status", "end_time", "search", "generation", "stage", "params"):
            first = runs[next(iter(runs))][f"evaluations/{name}"]
            layout = h5py.VirtualLayout((count, *first.shape[1:]), first.dtype)
            begin = 0
            for run in runs.values():
                part = run[f"evaluations/{name}"]
                layout[begin : begin + len(part)] = h5py.VirtualSource(part)
                begin += len(part)
            whole.create_virtual_dataset(name, layout)
        whole["run"] = source["all/run"][()]
    return path


def test_files_of_before_are_read_with_the_same_numbers(folder: Path):
    pandas = pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[data]'")
    new, before = wm.read(folder / "grid.h5"), wm.read(old(folder / "old.h5", folder / "grid.h5"))
    table = new.to_dataframe()
    pandas.testing.assert_frame_equal(before.to_dataframe()[[*table.columns[:5]]], table[[*table.columns[:5]]])
    name = new.run(new.runs[0]).parameters.name[0]
    np.testing.assert_array_equal(before.to_dataframe()[name], table[name])
    every = new.to_dataframe(candidates=True)
    found = before.to_dataframe(candidates=True)
    pandas.testing.assert_frame_equal(found[["run", "cost", "status", name]], every[["run", "cost", "status", name]])
    assert before.run(new.runs[1]).best.cost == new.run(new.runs[1]).best.cost


def damaged(folder: Path, change) -> Path:
    path = folder / "damaged.h5"
    path.write_bytes((folder / "grid.h5").read_bytes())
    with h5py.File(path, "a") as file:
        change(file)
    return path


def replaced(name: str, value):
    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = value

    return change


@pytest.mark.parametrize(
    "change",
    [
        replaced("table/best_cost", np.zeros(4)),
        replaced("table/best_params", np.zeros((6, 2))),
        replaced("table/run", np.zeros(6)),
        replaced("table/axes", h5py.ExternalLink("elsewhere.h5", "/")),
        replaced("table/seed", h5py.SoftLink("/all/run")),
        replaced("sweep", np.zeros(3)),
        lambda file: file.__delitem__("table"),
        lambda file: file.attrs.__delitem__("name"),
        lambda file: file.attrs.__setitem__("format_version", 99),
    ],
)
def test_damaged_files_are_an_error_of_one_line(change, folder: Path):
    with pytest.raises(ResultError) as caught:
        wm.read(damaged(folder, change)).to_dataframe()
    assert "\n" not in str(caught.value)
    assert "damaged.h5" in str(caught.value)


@pytest.mark.parametrize(
    "content", [np.zeros(5, np.uint8), np.zeros(5), np.zeros((2, 2), np.uint8), h5py.ExternalLink("x.h5", "/")]
)
def test_a_run_that_is_no_file_is_an_error_of_one_line(content, folder: Path):
    name = "seed=3,mass=20"
    with pytest.raises(ResultError, match=r"damaged.h5: ") as caught:
        wm.read(damaged(folder, replaced(f"runs/{name}", content)), name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_what_is_not_installed_is_named_with_its_extra(package: str, folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    swept = wm.read(folder / "grid.h5")
    with pytest.raises(Error, match=rf"needs {package}: pip install 'warpmuscle\[data\]'"):
        swept.to_xarray() if package == "xarray" else swept.to_dataframe()


def test_export_writes_runs_candidates_and_a_runs_motion_as_tables(folder: Path, tmp_path: Path):
    pandas = pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[tables]'")
    xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[tables]'")
    pytest.importorskip("pyarrow", reason="no pyarrow: pip install 'warpmuscle[tables]'")
    pytest.importorskip("h5netcdf", reason="no h5netcdf: pip install 'warpmuscle[tables]'")
    file, found = folder / "grid.h5", wm.read(folder / "grid.h5")
    for name, candidates in (("runs.parquet", False), ("candidates.parquet", True)):
        write_table(file, tmp_path / name, None, 0, candidates)
        pandas.testing.assert_frame_equal(pandas.read_parquet(tmp_path / name), found.to_dataframe(candidates))
    write_table(file, tmp_path / "runs.nc", None, 0, False)
    with xarray.open_dataset(tmp_path / "runs.nc", engine="h5netcdf") as table:
        xarray.testing.assert_equal(table.load(), found.to_xarray())
        assert table.best_cost.attrs == found.to_xarray().best_cost.attrs
    write_table(file, tmp_path / "motion.nc", found.runs[0], 0, False)
    with xarray.open_dataset(tmp_path / "motion.nc", engine="h5netcdf") as motion:
        np.testing.assert_array_equal(motion.com.values, found.run(found.runs[0]).replays[0].com)


def test_export_takes_comma_separated_values_of_a_sweep_as_a_table_and_of_a_motion_as_columns(folder: Path):
    file, run = folder / "grid.h5", wm.read(folder / "grid.h5").runs[0]
    assert is_table(file, Path("a.csv"), None, False)
    assert is_table(file, Path("a.csv"), run, True)
    assert not is_table(file, Path("a.csv"), run, False)
    with pytest.raises(Error, match="candidates are written as"):
        is_table(file, Path("a.mot"), None, True)
