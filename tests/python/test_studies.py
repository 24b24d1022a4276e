# SPDX-License-Identifier: Apache-2.0
"""Trade studies: the rows of `mtf sweep` byte for byte, in any pieces and processes."""

import json
import pickle
import shutil
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from conftest import run_command

import mtfkit as mk


@pytest.fixture(scope="module")
def study(studies):
    return mk.Study.load(studies / "aperture_against_pitch.toml")


@pytest.fixture(scope="module")
def table(study):
    return study.run()


@pytest.fixture(scope="module")
def swept(studies, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep") / "satellite"
    run_command("sweep", studies / "aperture_against_pitch.toml", "-o", folder)
    return folder


def test_rows_are_those_of_the_command(study, table, swept):
    said = np.load(swept / "designs.npy")
    rows = study.rows(threads=0)
    assert rows.shape == (1221, len(study.columns))
    assert rows.tobytes() == np.ascontiguousarray(said[:, :-1]).tobytes()
    front = np.flatnonzero(said[:, -1] == 1.0)
    assert study.pareto(table).index.tolist() == front.tolist()
    assert study.pareto(table[table.feasible]).index.tolist() == front.tolist()


def test_rows_do_not_depend_on_pieces_or_threads(study):
    whole = study.rows(100, 300)
    pieces = [study.rows((100, 117), threads=2), study.rows(117, 300)]
    assert whole.tobytes() == np.concatenate(pieces).tobytes()
    assert study.rows(5, 5).shape == (0, len(study.columns))
    for wrong in ((-1, 3), (3, 2), (0, 5000)):
        with pytest.raises(mk.UsageError, match="not among"):
            study.rows(*wrong)


def test_tables(study, table):
    assert table.attrs["units"]["optics.aperture"] == "mm" and table.index.name == "design"
    assert table.feasible.dtype == bool and table.feasible.sum() == 399
    data = study.to_xarray(table)
    assert data["niirs_giqe5"].dims == ("optics.aperture", "frame.pitch") and data["niirs_giqe5"].shape == (37, 33)
    assert data["niirs_giqe5"].values.ravel().tolist() == table.niirs_giqe5.tolist()
    assert data.coords["frame.pitch"].attrs["units"] == "um"
    assert study.frame([study.rows(0, 600), study.rows(600, 1221)]).equals(table)
    with pytest.raises(mk.UsageError, match="10 of 1221"):
        study.to_xarray(table[:10])
    with pytest.raises(mk.UsageError, match="columns"):
        study.frame(np.zeros((3, 2)))


def test_sensor_of_a_design_is_the_chosen_one(study, table, swept):
    best = table.niirs_giqe5[table.feasible].idxmax()
    assert best == 1204
    assert study.sensor(best) == mk.Sensor.load(swept / "chosen" / "design_1204.toml")
    assert study.axes(best) == {"optics.aperture": 1200.0, "frame.pitch": 8.0}


def test_gradient_is_that_of_differences(study, table):
    design = 600
    gradient = study.gradient(design)
    frame = gradient.to_pandas()
    pitch = study.axes(design)["frame.pitch"]
    values, step = study._values(design), 1e-4 * pitch
    rows = [study._study.evaluate_at([values[0], pitch + s]) for s in (-step, step)]
    names = [column.name for column in study.columns]
    for metric in ("niirs_giqe5", "mtf_nyquist_x" if "mtf_nyquist_x" in names else "mtf_nyquist", "q"):
        slope = (rows[1] - rows[0])[names.index(metric)] / (2 * step)
        assert frame.loc[metric, "frame.pitch"] == pytest.approx(slope, rel=2e-3)


def test_optimum_is_that_of_the_command(studies, study):
    said = json.loads(run_command("optimize", studies / "stabilisation.toml", "--objective", "1", "--format", "json"))
    steady = mk.Study.load(studies / "stabilisation.toml")
    best = steady.optimum(objective=0)
    assert best.status == "optimal" and best.sensor.check()
    entry = said["goals"][0] if "goals" in said else said
    assert {k: v for k, v in best.report.items() if k not in ("file",)} == {
        k: v for k, v in entry.items() if k not in ("file",)}
    assert "limits" in best.explain()
    with pytest.raises(mk.UsageError, match="2 objectives"):
        study.optimum()
    with pytest.raises(mk.UsageError, match="exclude"):
        study.optimum(objective=0, weights=[1, 1])
    with pytest.raises(mk.UsageError, match="not among"):
        study.optimum(objective=7)


def test_process_pools(study, table):
    with ProcessPoolExecutor(2) as pool:
        pieces = list(pool.map(study.rows, [0, 600], [600, 1221]))
    assert study.frame(pieces).equals(table)


def test_studies_pickle_with_their_files(studies, tmp_path, study):
    for name in ("aperture_against_pitch.toml", "satellite.toml"):
        shutil.copy(studies / name, tmp_path / name)
    packed = pickle.dumps(mk.Study.load(tmp_path / "aperture_against_pitch.toml"))
    shutil.rmtree(tmp_path)
    moved = pickle.loads(packed)
    assert moved == study and moved.rows(0, 20).tobytes() == study.rows(0, 20).tobytes()
    assert mk.Study.load(studies / "aperture_against_pitch.toml", tolerance=1e-3) != study


def test_wrong_studies_say_where(tmp_path):
    (tmp_path / "s.toml").write_text("schema = 1\nsensor = \"none.toml\"\n[[axis]]\nparameter = \"optics.apertur\"\n")
    with pytest.raises(mk.UsageError, match="s.toml:"):
        mk.Study.load(tmp_path / "s.toml")
    with pytest.raises(mk.DataError, match="nowhere"):
        mk.Study.load(tmp_path / "nowhere.toml")


def test_progress_is_told_and_its_errors_are_kept(study):
    shares = []
    study.rows(0, 200, progress=shares.append)
    assert shares[-1] == 1.0 and shares == sorted(shares)

    def fail(_share):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        study.rows(0, 200, progress=fail, threads=2)
