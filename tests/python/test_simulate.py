# SPDX-License-Identifier: Apache-2.0
"""Images: no copies, the pixels of the command, sequences, stages, noise, labels."""

import pickle
import tracemalloc
import warnings

import numpy as np
import pytest
from conftest import run_command

import mtfkit as mk
from mtfkit import _core


def address(array):
    return array.__array_interface__["data"][0]


def of_command(folder, tmp_path, sensor, scene, *words):
    out = tmp_path / "out.exr"
    run_command("simulate", folder / sensor, folder / scene, "-o", out, *words)
    return mk.read(out).plane()


def test_pixels_are_those_of_the_command(demo, tmp_path):
    said = of_command(demo, tmp_path, "sensor.toml", "scene.exr", "--tolerance", "1e-5")
    sensor = mk.Sensor.load(demo / "sensor.toml")
    for scene in (str(demo / "scene.exr"), demo / "scene.exr", mk.read(demo / "scene.exr")):
        run = sensor.simulate(scene, tolerance=1e-5)
        assert np.array_equal(run.image, said)
        assert run.promised <= 1e-5 == run.tolerance
    plane = mk.read(demo / "scene.exr").plane()
    assert np.array_equal(sensor.simulate(plane, tolerance=1e-5, sample="3.75 um").image, said)
    assert run.report["plan"]["predicted_error"] == run.promised
    assert "predicted" in run.explain() and run.seconds > 0
    run.save(tmp_path / "saved.exr")
    assert np.array_equal(mk.read(tmp_path / "saved.exr").plane(), said)


@pytest.mark.parametrize("stage", ["radiance", "electrons", "dn"])
def test_stages_of_the_chain_are_those_of_the_command(demo, tmp_path, stage):
    said = of_command(demo, tmp_path, "camera.toml", "thermal.exr", "--tap", stage)
    run = mk.Sensor.load(demo / "camera.toml").simulate(demo / "thermal.exr", stage=stage)
    assert np.array_equal(run.image, said)
    values = mk.read(demo / "thermal.exr")
    again = mk.Sensor.load(demo / "camera.toml").simulate(values.plane(), sample=values.sample,
                                                               quantity="temperature", stage=stage)
    assert np.array_equal(again.image, said)


def test_integer_files_are_those_of_the_command(demo, tmp_path):
    out = tmp_path / "command.png"
    run_command("simulate", demo / "camera.toml", demo / "thermal.exr", "-o", out)
    mk.Sensor.load(demo / "camera.toml").simulate(demo / "thermal.exr").save(tmp_path / "python.png")
    assert np.array_equal(mk.read(out).plane(), mk.read(tmp_path / "python.png").plane())


def test_sequences_are_those_of_the_command(demo, tmp_path):
    (tmp_path / "s.csv").write_text("frame,parameter,value\n2,jitter.rms,60 urad\n")
    run_command("simulate", demo / "sensor.toml", demo / "scene.exr", "-o", tmp_path / "f.%04d.exr", "--schedule",
                tmp_path / "s.csv", "--frames", "1:3")
    run = mk.Sensor.load(demo / "sensor.toml").simulate(demo / "scene.exr", frames=range(1, 4),
                                                        schedule=[(2, "jitter.rms", (60, "urad"))])
    assert run.frames == [1, 2, 3]
    for frame, image in zip(run.frames, run.images):
        assert np.array_equal(image, mk.read(tmp_path / f"f.{frame:04d}.exr").plane())
    assert np.array_equal(run.images[1], run.images[2]) and not np.array_equal(run.images[0], run.images[1])


def test_noise_is_chosen_by_seed_and_frame(demo):
    camera = mk.Sensor.load(demo / "camera.toml").replace({"noise.seed": 3})
    def image(**how):
        return camera.simulate(demo / "thermal.exr", stage="electrons", **how).image
    assert np.array_equal(image(frame=7), image(frame=7, threads=1))
    assert not np.array_equal(image(frame=7), image(frame=8))
    assert not np.array_equal(image(seed=4), image())
    assert np.array_equal(image(seed=3), image())


def test_views_are_where_the_array_is(scene):
    plan_of = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um")).compile
    identity = plan_of((192, 256), sample="15 um")
    out = np.empty((192, 256), "float32")
    assert identity(scene, out=out) is out
    assert np.array_equal(out, scene)
    # A slice, read-only memory and a mapped file are read where they are: the result tells, and so does the memory.
    large = np.arange(400 * 500, dtype="float32").reshape(400, 500)
    part = large[100:292, 64:320]
    assert np.array_equal(identity(part), part)
    fixed = scene.copy()
    fixed.setflags(write=False)
    assert np.array_equal(identity(fixed), scene)


def allocated(work):
    """The most bytes that numpy held at a time for this work."""
    tracemalloc.start()
    work()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def test_nothing_is_copied_of_an_array_in_order(sensor, scene, tmp_path):
    large = np.tile(scene, (4, 4))
    plan = sensor.compile(large.shape, sample="3.75 um")
    out = plan(large)
    large.tofile(tmp_path / "raw")
    mapped = np.memmap(tmp_path / "raw", "float32", "r", shape=large.shape)
    fixed = large.view()
    fixed.setflags(write=False)
    wide = np.empty((large.shape[0] + 3, large.shape[1] + 5), "float32")
    wide[2:-1, 3:-2] = large
    for view in (large, mapped, fixed, wide[2:-1, 3:-2]):
        assert allocated(lambda view=view: plan(view, out=out)) < 4096
        assert np.array_equal(plan(view), out)
    for other in (large.astype("f8"), large.astype(">f4"), np.asfortranarray(large), wide[::-1][1:-2, 3:-2]):
        assert large.nbytes <= allocated(lambda other=other: plan(other, out=out)) < large.nbytes + 4096


def test_what_is_closed_or_no_file_has_words(sensor, tmp_path, demo):
    with open(demo / "scene.exr", "rb") as file:
        pass
    with pytest.raises(mk.UsageError, match="path: .* is no name of a file"):
        mk.read(file)
    with pytest.raises(mk.UsageError, match="no array|dtype|type|dimensions"):
        sensor.simulate(file, sample="3.75 um")
    with pytest.raises(mk.DataError, match="is a directory|directory|not"):
        mk.read(tmp_path)
    with pytest.raises((mk.DataError, ValueError)):
        mk.read("a\0b.exr")


def test_the_file_s_plane_is_a_view(demo):
    image = mk.read(demo / "scene.exr")
    assert address(image.plane()) == address(image.plane("Y"))
    assert not image.plane().flags.writeable
    plane = mk.read(demo / "scene.exr").plane()  # lives on without its Image
    assert np.isfinite(plane).all()


def test_other_types_are_converted_once(sensor, scene):
    plan = sensor.compile(scene.shape, sample="3.75 um")
    image = plan(scene)
    assert image.dtype == np.float32 and image.shape == plan.shape == (48, 64)
    for other in (scene.astype("float64"), scene.astype(">f4"), np.asfortranarray(scene), np.repeat(scene, 2, 1)[:, ::2],
                  scene[::-1][::-1], scene.tolist()):
        assert np.array_equal(plan(other), image)
    counts = (100 * scene).astype("int16")
    assert np.array_equal(plan(counts), plan(counts.astype("float32")))
    assert np.array_equal(plan(scene.astype("float16")), plan(scene.astype("float16").astype("float32")))


def test_a_plan_without_memory_of_its_own(sensor, scene):
    plan = sensor.compile(scene, sample="3.75 um", tolerance=1e-4)
    image = plan(scene)
    out = np.empty_like(image)
    assert plan(scene, out=out, threads=1) is out and np.array_equal(out, image)
    wide = np.empty((48, 100), "float32")
    plan(scene, out=wide[:, 10:74])
    assert np.array_equal(wide[:, 10:74], image)
    assert plan.promised <= 1e-4
    steady = plan.replace(sensor.replace({"jitter.rms": "60 urad"}))
    assert not np.array_equal(steady(scene), image) and np.array_equal(plan(scene), image)
    fresh = sensor.replace({"jitter.rms": "60 urad"}).compile(scene, sample="3.75 um", tolerance=1e-4)
    assert np.abs(steady(scene) - fresh(scene)).max() < 2e-4 * scene.std() * 8
    again = pickle.loads(pickle.dumps(plan))
    assert np.array_equal(again(scene), image) and again.promised == plan.promised


def test_the_promise_is_kept(sensor, scene):
    exact = sensor.simulate(scene, sample="3.75 um", tolerance=1e-6).image
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5):
        run = sensor.simulate(scene, sample="3.75 um", tolerance=tolerance)
        assert run.promised <= tolerance
        error = np.sqrt(np.mean((run.image.astype("f8") - exact) ** 2)) / scene.std()
        assert error <= run.promised + 1e-6


def test_a_chain_plan_is_the_chain(demo):
    camera = mk.Sensor.load(demo / "camera.toml")
    thermal = mk.read(demo / "thermal.exr").plane()
    plan = camera.compile(thermal, sample=mk.read(demo / "thermal.exr").sample, quantity="temperature", stage="dn")
    counts = plan(thermal, frame=2)
    assert np.array_equal(plan(thermal, frame=2, out=np.empty_like(counts)), counts)
    assert plan.shape == counts.shape
    assert np.array_equal(pickle.loads(pickle.dumps(plan))(thermal, frame=2), counts)
    hotter = plan.replace(camera.replace({"frame.integration_time": "1 ms"}))
    assert hotter(thermal).mean() < counts.mean()


def test_a_changed_file_is_read_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    def camera(efficiency):
        (tmp_path / "qe.csv").write_text(f"wavelength_um,value\n3,{efficiency}\n5.5,{efficiency}\n")
        return mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um", integration_time="2 ms"), optics=dict(f_number=2.0),
                         scene=dict(quantity="temperature"), band=dict(wavelength=["3.4 um", "4.8 um"]),
                         presample=["diffraction"], detector=dict(quantum_efficiency="qe.csv"))
    scene = np.full((32, 32), 300.0, "f4")
    plan = camera("0.8").compile(scene, sample="3.75 um", stage="electrons")
    first = plan(scene).mean()
    second = camera("0.4125")
    assert plan.replace(second)(scene).mean() == second.compile(scene, sample="3.75 um", stage="electrons")(scene).mean() < 0.6 * first


def test_temperatures_that_are_all_cold_cause_a_warning_with_their_unit():
    camera = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um", integration_time="2 ms"), optics=dict(f_number=2.0),
                       scene=dict(quantity="temperature"), band=dict(wavelength=["3.4 um", "4.8 um"]),
                       presample=["diffraction"], detector=dict(quantum_efficiency=0.8))
    differences = np.full((32, 32), 2.0, "f4")
    differences[8:24, 8:24] = 8.0
    how = dict(sample="3.75 um", stage="radiance")
    for cold in (differences, differences.tolist(), {"Y": differences}, mk.targets.edge(size=(32, 32))):
        with pytest.warns(UserWarning, match="'Y' was taken for temperatures in K, of [78].* K at most; .* 273.15") as caught:
            camera.simulate(cold, **how)
        assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        camera.simulate(differences + 292.0, **how)
        camera.simulate(np.where(differences > 5.0, 300.0, differences), **how)  # a cold sky around something warm
        camera.simulate(differences, quantity="radiance", **how)


def test_labels_follow_the_image():
    # A bright sample lies where map_points says, for any ratio of the steps; a blur of a pixel aliases nothing.
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[mk.Gaussian(sigma="15 um")])
    for sample in ("3.75 um", "4.1 um"):
        target = np.zeros((240, 240), "float32")
        target[121, 87] = 1000.0
        run = sensor.simulate(target, sample=sample, tolerance=2e-5)
        rows, columns = np.indices(run.image.shape)
        weight = run.image / run.image.sum()
        seen = np.array([(weight * columns).sum(), (weight * rows).sum()])
        assert np.abs(run.map_points([[87, 121]])[0] - seen).max() < 1e-3
    step = 4.1 / 15
    assert run.map_points([[-0.5, -0.5]])[0] == pytest.approx([-0.5, -0.5])
    assert run.map_points([[0, 0]])[0] == pytest.approx([0.5 * step - 0.5] * 2)


def test_labels_follow_distortion(demo):
    camera = mk.Sensor.parse(mk.Sensor.load(demo / "camera.toml").text + '[distortion]\nk1 = -0.08\n[optical_axis]\nx = "5 px"\n')
    thermal = np.full(mk.read(demo / "thermal.exr").plane().shape, 290.0, "float32")
    height, width = thermal.shape
    how = dict(sample=mk.read(demo / "thermal.exr").sample, quantity="temperature", stage="radiance")
    for x, y in [(width // 8, height // 5), (width // 2, height // 2), (width - 200, height - 150)]:
        spot = thermal.copy()
        spot[y - 4:y + 5, x - 4:x + 5] = 330.0
        run = camera.simulate(spot, **how)
        flat = camera.simulate(thermal, **how).image
        weight = run.image - flat
        weight[weight < 0.05 * weight.max()] = 0.0  # far tails and mirrored light are not the spot
        rows, columns = np.indices(weight.shape)
        seen = np.array([(weight * columns).sum(), (weight * rows).sum()]) / weight.sum()
        assert np.abs(run.map_points([[x, y]])[0] - seen).max() < 0.05


def test_bad_input_gives_exceptions_with_words(sensor, scene, tmp_path):
    simulate, how = sensor.simulate, dict(sample="3.75 um")
    plan = sensor.compile(scene.shape, sample="3.75 um")
    masked = np.ma.masked_array(scene, scene > 6)
    complex_scene = scene.astype("complex64")
    for bad, words in [(scene[0], "two dimensions"), (scene[None], "two dimensions"), (np.float32(3), "two dimensions"),
                       (np.empty((0, 5), "f4"), "no values"), (np.array([[object()]]), "type object"),
                       (np.array([["a"]]), "type <U1"), (complex_scene, "real part"), (masked, "masked"),
                       (None, "None"), (np.array([["2020-01-01"]], "M8[D]"), "type datetime64")]:
        with pytest.raises(mk.UsageError, match=words):
            plan(bad)
        with pytest.raises(mk.UsageError, match=words):
            simulate(bad, **how)
    holes = scene.copy()
    holes[3, 5] = np.nan
    with pytest.raises(mk.DataError, match="column 5, row 3"):
        simulate(holes, **how)
    with pytest.raises(mk.DataError, match=r"NaN"):
        plan(holes)
    assert np.isfinite(simulate(holes, nan="fill", **how).image).all()
    with pytest.raises(mk.DataError, match="NaN or infinite"):
        plan(np.full(scene.shape, 1e300))
    with pytest.raises(mk.UsageError, match="256"):
        plan(scene[:, :100])
    with pytest.raises(mk.UsageError, match="sample"):
        simulate(scene)
    with pytest.raises(mk.UsageError, match="unit"):
        simulate(scene, sample=3.75)
    with pytest.raises(mk.UsageError, match="not above zero"):
        simulate(scene, sample="-3 um")
    with pytest.raises(mk.ToleranceError) as refused:
        simulate(scene, tolerance=1e-12, **how)
    assert 1e-12 < refused.value.reachable < 1e-5
    simulate(scene, tolerance=refused.value.reachable, **how)
    for wrong in (dict(nan="ignore"), dict(stage="dn"), dict(rigor="fast"), dict(quantity="sound"), dict(frames=[]),
                  dict(frames=[1, 3, 4]), dict(roi=(0, 0, 0, 0)), dict(tolerance=2.0), dict(frame=-1)):
        with pytest.raises(mk.UsageError):
            simulate(scene, **how, **wrong)
    with pytest.raises(mk.DataError, match="nowhere.exr"):
        simulate("nowhere.exr")
    (tmp_path / "torn.exr").write_bytes(b"\x76\x2f\x31\x01 torn")
    with pytest.raises(mk.DataError, match="torn.exr"):
        mk.read(tmp_path / "torn.exr")
    with pytest.raises((mk.UsageError, MemoryError)):
        sensor.compile((1 << 40, 1 << 40), sample="3.75 um")


def test_bad_outputs_are_refused(sensor, scene):
    plan = sensor.compile(scene.shape, sample="3.75 um")
    good = np.zeros(plan.shape, "float32")
    fixed = np.empty_like(good)
    fixed.setflags(write=False)
    for out, words in [(good.astype("f8"), "float64"), (good[:-1], "shape"), (fixed, "read-only"),
                       (np.empty((64, 48), "f4").T, "row after row"), ([[1.0]], "no numpy array"),
                       (np.ma.masked_array(good), "no numpy array")]:
        with pytest.raises(mk.UsageError, match=words):
            plan(scene, out=out)
    shared = np.empty(scene.size + 10, "float32")
    inside = shared[10:].reshape(scene.shape)
    inside[...] = scene
    with pytest.raises(mk.UsageError, match="overlaps"):
        plan(inside, out=shared[64:64 + good.size].reshape(good.shape))
    image = plan(scene)
    inside[...] = scene
    assert np.array_equal(plan(inside, out=inside.ravel()[:good.size].reshape(good.shape)), image)


def test_errors_of_progress_and_threads(sensor, scene):
    class Stop(Exception):
        pass

    def stop(_share):
        raise Stop

    with pytest.raises(Stop):
        sensor.simulate(scene, sample="3.75 um", frames=range(3), progress=stop)


def test_results_are_the_same_for_any_threads(sensor, scene):
    images = [sensor.simulate(scene, sample="3.75 um", threads=threads).image for threads in (1, 2, 0)]
    assert np.array_equal(images[0], images[1]) and np.array_equal(images[0], images[2])


def test_images_in_and_out(tmp_path, scene):
    mk.write(tmp_path / "a.exr", scene, attributes={"mtf:quantity": "radiance", "mtf:pixelPitch": (3.75e-6, 3.75e-6)})
    read = mk.read(tmp_path / "a.exr")
    assert np.array_equal(read.plane(), scene) and read.attributes["mtf:quantity"] == "radiance"
    assert read.shape == scene.shape and np.array_equal(np.asarray(read), scene)
    mk.write(tmp_path / "rgb.exr", {"R": scene, "G": scene + 1, "B": scene + 2})
    rgb = mk.read(tmp_path / "rgb.exr")
    assert rgb.names == ["R", "G", "B"] and np.array_equal(rgb.plane("B"), scene + 2)
    with pytest.raises(mk.UsageError, match="name one of them"):
        rgb.plane()
    with pytest.raises(mk.UsageError, match="no plane 'A'"):
        rgb.plane("A")
    mk.write(tmp_path / "a.png", scene, range=(0, 10), bits=8)
    png = mk.read(tmp_path / "a.png")
    assert png.integer and np.array_equal(png.plane(), np.round(scene * 25.5).clip(0, 255))
    with pytest.raises(mk.UsageError, match="bits"):
        mk.write(tmp_path / "a.png", scene, bits=12)
    with pytest.raises(mk.UsageError, match="gif|extension"):
        mk.write(tmp_path / "a.gif", scene)
    with pytest.raises(mk.DataError):
        mk.write(tmp_path / "no" / "folder.exr", scene)


def test_noise_is_a_function_of_seed_frame_and_pixel():
    noise = mk.noise.gaussian((300, 400), sd=2.0, seed=1)
    assert abs(noise.std() - 2.0) < 0.02 and abs(noise.mean()) < 0.03
    assert np.array_equal(noise, mk.noise.gaussian((300, 400), sd=2.0, seed=1, threads=2))
    assert not np.array_equal(noise, mk.noise.gaussian((300, 400), sd=2.0, seed=1, frame=1))
    counts = mk.noise.shot(np.full((300, 400), 30.0), seed=2)
    assert abs(counts.mean() - 30) < 0.1 and abs(counts.var() - 30) < 0.6
    assert np.array_equal(counts, np.round(counts))
    with pytest.raises(mk.UsageError):
        mk.noise.gaussian((3, 3), sd=-1.0)
    with pytest.raises(mk.UsageError):
        mk.noise.gaussian((1 << 40, 1 << 40), sd=1.0)


def test_results_show_in_notebooks(sensor, scene):
    run = sensor.simulate(scene, sample="3.75 um")
    assert run._repr_html_().startswith("<pre>") and "Run" in repr(run)
    array = run.to_xarray()
    assert array.attrs["units"] == run.unit and array.coords["x"].attrs["units"] == "mm"
    assert np.array_equal(np.asarray(run), run.image)
    assert pickle.loads(pickle.dumps(run.image)).shape == run.image.shape


def test_one_image_is_asked_for_where_there_are_several(sensor, scene, demo):
    colours = sensor.simulate({"R": scene, "G": scene + 1}, sample="3.75 um")
    sequence = mk.Sensor.load(demo / "camera.toml").simulate(demo / "thermal.exr", stage="dn", frames=range(2, 7, 2))
    for run, words in ((colours, "planes R, G; take run.planes"), (sequence, r"frames 2, 4, 6; take run.images\[number\]")):
        for work in (lambda: run.image, lambda: np.asarray(run), run.to_xarray, lambda: mk.measure(run)):
            with pytest.raises(mk.UsageError, match=words):
                work()
    assert np.array_equal(colours.plane("G"), colours.planes["G"]) and list(colours.planes) == ["R", "G"]
    assert np.array_equal(sequence.plane("Y", 4), sequence.images[1]) and len(sequence.images) == 3
    for work, words in ((lambda: colours.images, "run.plane"), (lambda: sequence.planes, "run.plane"), (lambda: colours.plane("B"), "there are R, G"),
                        (lambda: sequence.plane("Y"), "name one of them"), (lambda: sequence.plane("Y", 3), "2, 4, 6")):
        with pytest.raises(mk.UsageError, match=words):
            work()


def test_the_compiled_part_refuses_nonsense():
    with pytest.raises(TypeError):
        _core.SensorFile(3, 4)
    with pytest.raises(TypeError):
        _core.LinearPlan(None, 1, 1, None, None, None, False, 1)


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.tif"])
def test_files_keep_what_they_say_when_they_are_written_anew(sensor, scene, tmp_path, name):
    mk.write(tmp_path / name, scene, sample=("3.75 um", (5, "um")), quantity="radiance",
             attributes={"note": "h\u00e4llo", "mtf:bandEdges": [3.4, 4.8], "corner": (1.5, 2.0)})
    first = mk.read(tmp_path / name)
    assert first.sample == ("3.75 um", "5.0 um") and first.attributes["mtf:quantity"] == "radiance"
    assert first.attributes["mtf:units"] == "W.m^-2.sr^-1" and first.attributes["note"] == "h\u00e4llo"
    for again in (f"b{name[1:]}", f"c{name[1:]}"):
        mk.write(tmp_path / again, mk.read(tmp_path / name))
        name = again
        assert mk.read(tmp_path / again) == first
    mk.write(tmp_path / f"d{name[1:]}", first, sample="7.5 um", attributes={"note": "other"})
    changed = mk.read(tmp_path / f"d{name[1:]}")
    assert changed.sample == ("7.5 um", "7.5 um") and changed.attributes["note"] == "other"
    assert np.array_equal(changed.plane("Y"), first.plane("Y"))


def test_written_arrays_are_scenes(sensor, scene, tmp_path):
    mk.write(tmp_path / "a.exr", scene, sample="3.75 um", quantity="radiance")
    right = sensor.simulate(scene, sample="3.75 um")
    assert np.array_equal(sensor.simulate(tmp_path / "a.exr").image, right.image)
    for wrong, words in ((dict(sample=3.75), "sample: 3.75 has no unit"), (dict(sample="1 px"), "sample: "), (dict(quantity="light"), "one of radiance")):
        with pytest.raises(mk.UsageError, match=words):
            mk.write(tmp_path / "b.exr", scene, **wrong)


def test_a_spacing_beside_a_file_is_refused_with_the_remedy(sensor, scene, tmp_path):
    mk.write(tmp_path / "q.png", scene)
    image = mk.read(tmp_path / "q.png")
    for given in (tmp_path / "q.png", image):
        with pytest.raises(mk.UsageError, match=r"^sample: .*plane\(\), sample=..., quantity=...\), or write a file"):
            sensor.simulate(given, sample="3.75 um")
    run = sensor.simulate(mk.read(tmp_path / "q.png").plane(), sample="3.75 um", quantity="counts")  # the remedies
    mk.write(tmp_path / "q.exr", image, sample="3.75 um", quantity="counts")
    assert np.array_equal(sensor.simulate(tmp_path / "q.exr").image, run.image)


def test_a_device_filters_where_it_is_named() -> None:
    scene = np.random.default_rng(3).random((96, 128)).astype(np.float32)
    sensor = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), presample=[mk.Gaussian(sigma="9 um")])
    with pytest.raises(mk.UsageError, match="there is no device voodoo"):
        sensor.simulate(scene, sample="15 um", device="voodoo")
    if all(device["cpu"] for device in mk.devices()):
        assert any("no device beside the processor" in warning for warning in sensor.simulate(scene, sample="15 um", device="auto").warnings)
    for device in mk.devices():
        assert device["admitted"], device["reason"]
        own, others = sensor.simulate(scene, sample="15 um").image, sensor.simulate(scene, sample="15 um", device=device["id"])
        assert np.sqrt(np.mean((own - others.image) ** 2)) <= 2e-4 * scene.std()
        plan = sensor.compile(scene.shape, sample="15 um", device=device["id"])
        assert np.sqrt(np.mean((own - plan(scene)) ** 2)) <= 2e-4 * scene.std()
