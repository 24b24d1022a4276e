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
    # Two designs have none: the bright target fills their wells.
    assert table.niirs_giqe5.isna().sum() == 2
    assert np.array_equal(data["niirs_giqe5"].values.ravel(), table.niirs_giqe5.to_numpy(), equal_nan=True)
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


SATELLITE = dict(
    name="satellite: aperture against pitch at 0.5 m",
    constraints=["niirs_giqe5 > 5", "focal_length <= 8 m", "well_fill <= 0.25"],
    objectives=["maximize niirs_giqe5", "minimize aperture"],
    axes={"optics.aperture": {"from": "300 mm", "to": "1200 mm", "count": 4}, "frame.pitch": ([4, 8, 12.0], "um")},
    links={"focal_length": "pitch * (500 km) / (0.5 m)", "tdi.slip": "pitch / 100",
           "full_well": "200 ke- * (pitch / (8 um)) ^ 2"},
    metrics=["niirs_giqe5", "niirs_giqe4", "target_snr", "rer_x", "rer_y", "mtf_nyquist", "q", "well_fill"],
    conditions=dict(temperature="5800 K", range=(500, "km"), signal_contrast=0.53))


def test_studies_of_keywords_are_those_of_files(studies, study, table, tmp_path):
    made = mk.Study(mk.Sensor.load(studies / "satellite.toml"), **SATELLITE)
    assert made.designs == 12 and made.columns == study.columns
    assert (made.constraints, made.objectives, made.warnings) == (study.constraints, study.objectives, study.warnings)
    rows, axes = made.rows(), study.run()[["optics.aperture", "frame.pitch"]].to_numpy()
    for design, row in enumerate(rows):  # the same design of the file has the same bytes
        same = np.flatnonzero((axes == [made.axes(design)[name] for name in ("optics.aperture", "frame.pitch")]).all(axis=1))
        assert row.tobytes() == study.rows(int(same[0]), int(same[0]) + 1).tobytes()
    made.save(tmp_path / "new" / "study.toml")
    run_command("sweep", tmp_path / "new" / "study.toml", "-o", tmp_path / "swept")
    said = np.load(tmp_path / "swept" / "designs.npy")
    assert np.ascontiguousarray(said[:, :-1]).tobytes() == rows.tobytes()
    assert made.sensor(5) == mk.Study.load(tmp_path / "new" / "study.toml").sensor(5)


def test_saved_studies_hold_all_their_files(tmp_path):
    (tmp_path / "a").mkdir()
    for name, end in (("one.csv", 0.5), ("two.csv", 0.2)):
        (tmp_path / "a" / name).write_text(f"frequency_cy_mm,mtf\n0,1\n30,{end}\n60,0\n")
    blur = mk.custom(lambda fx, fy: np.exp(-(fx ** 2 + fy ** 2) / 2500), cutoff="400 cy/mm", label="coating")
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[
        mk.Jitter(rms="20 urad"), mk.Curve(label="lens", file=tmp_path / "a" / "one.csv", axis="radial"), blur])
    study = mk.Study(sensor, axes={"lens.file": [tmp_path / "a" / "one.csv", tmp_path / "a" / "two.csv"],
                                   "jitter.rms": ["10 urad", "30 urad"]}, metrics=["mtf_nyquist"])
    rows = study.rows()
    assert len(np.unique(rows[:, 2])) == 4
    study.save(tmp_path / "b" / "mine.toml")
    shutil.rmtree(tmp_path / "a")
    shutil.move(tmp_path / "b", tmp_path / "c")
    loaded = mk.Study.load(tmp_path / "c" / "mine.toml")
    assert loaded.rows().tobytes() == rows.tobytes()
    loaded.save(tmp_path / "d" / "again.toml")
    run_command("sweep", tmp_path / "d" / "again.toml", "-o", tmp_path / "swept")
    assert np.load(tmp_path / "swept" / "designs.npy")[:, 2].tobytes() == rows[:, 2].tobytes()


def test_studies_of_keywords_go_to_processes(sensor):
    study = mk.Study(sensor, axes=[{"name": "share", "from": 0.5, "to": 1, "count": 5}, {"parameter": "jitter.rms", "values": ["1 urad"]}],
                     links={"footprint.width": "share * pitch"}, metrics=["mtf_nyquist"], objectives=["maximize share * mtf_nyquist"],
                     as_built={"jitter.rms": {"sd": "2 %"}}, draws=10, seed=3, sampling=dict(method="sobol", points=8), tolerance=1e-3)
    copy = pickle.loads(pickle.dumps(study))
    assert copy == study and hash(copy) == hash(study) and copy.tolerance == 1e-3
    assert copy.rows().tobytes() == study.rows().tobytes() and study.rows().shape[0] == 8
    assert study != mk.Study(sensor, axes={"jitter.rms": ["1 urad"]}, metrics=["mtf_nyquist"])
    with ProcessPoolExecutor(2) as pool:
        pieces = list(pool.map(study.rows, [0, 3], [3, 8]))
    assert np.concatenate(pieces).tobytes() == study.rows().tobytes()


def test_sensors_as_an_axis(sensor):
    sensors = [sensor.replace({"jitter.rms": f"{rms} urad"}) for rms in (10, 40)]
    study = mk.Study(sensor, axes={"sensor": sensors}, metrics=["mtf_nyquist_x"])
    said = [mk.metrics(each, ["mtf_nyquist_x"])["mtf_nyquist_x"].value for each in sensors]
    assert study.run().mtf_nyquist_x.tolist() == pytest.approx(said, abs=2e-4)
    assert study.sensor(1)._file.stated("jitter.rms") == sensors[1]._file.stated("jitter.rms")


@pytest.mark.parametrize("wrong,words", [
    (dict(sensor="a.toml"), "sensor: 'a.toml' is no Sensor.*Study.load"), (dict(axes={}), "axes: is empty"), (dict(axes=3), "axes: 3 is no"),
    (dict(axes={"optics.apertur": ["1 mm"]}), r'^axes\["optics.apertur"\].parameter: .*did you mean optics.aperture'),
    (dict(axes={"jitter.rms": ("1 urad", "9 urad")}), r'axes\["jitter.rms"\]: .* is no list of values; .*a range'),
    (dict(axes={"jitter.rms": [10]}), r'^axes\["jitter.rms"\].values: 10 has no unit'),
    (dict(axes={"jitter.rms": {"values": ["1 urad"], "step": 3}}), "key 'step'; it may have parameter"),
    (dict(metrics="q"), r'metrics: \'q\' is no list of texts'), (dict(metrics=()), "neither metrics nor objectives are given; write metrics="),
    (dict(links={"footprint.width": "pich"}), "^links.footprint.width: .*did you mean pitch"), (dict(links=[1]), "links: .* no dictionary"),
    (dict(as_built={"jitter.rms": 3}), r'as_built\["jitter.rms"\]: 3'), (dict(as_built={"jitter.rms": {"ds": 3}}), r'^as_built\["jitter.rms"\].sd'),
    (dict(draws=0), "^draws: 0 is outside"), (dict(sampling="sobol"), "sampling: 'sobol' is no dictionary"), (dict(tolerance=5), "^tolerance: 5"),
    (dict(conditions={"rnge": "3 m"}), "^conditions.rnge: unknown key"), (dict(objectives=["max q"]), r"^objectives\[0\]: begins with"),
])
def test_mistakes_in_keywords_say_their_argument(sensor, wrong, words):
    with pytest.raises(mk.UsageError, match=words) as refused:
        mk.Study(**{"sensor": sensor, "axes": {"jitter.rms": ["10 urad"]}, "metrics": ["q"], **wrong})
    assert "toml" not in str(refused.value) or "a.toml" in str(refused.value)
    assert "/tmp" not in str(refused.value)


def test_metrics_that_no_design_has_are_warned_of(sensor):
    study = mk.Study(sensor, axes={"jitter.rms": ["10 urad", "20 urad"]}, metrics=["netd", "q"])
    assert [text for text in study.warnings if text.startswith("netd: ") and "[detector]" in text]
    assert not any(text.startswith("q: ") for text in study.warnings)
