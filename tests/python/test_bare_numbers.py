# SPDX-License-Identifier: Apache-2.0
"""ENVI, FITS, PGM, PPM and BMP against what numpy reads of the same bytes, bit for bit. Files are written by numpy."""

import json
import shutil
import subprocess
import struct

import numpy as np
import pytest

import mtfkit as mk
from conftest import COMMAND, run_command, run_json

TYPES = {1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8"}
ROWS, COLUMNS, BANDS = 5, 7, 3


def cube(kind, order):
    """Bands x rows x columns of any bytes that are numbers: both signs, the extremes, what float32 has to round."""
    rng = np.random.default_rng(1)
    if kind[0] == "f":
        values = rng.standard_normal((BANDS, ROWS, COLUMNS)) * 10.0 ** rng.integers(-30, 30, (BANDS, ROWS, COLUMNS))
    else:
        limits = np.iinfo(kind)
        values = rng.integers(limits.min, limits.max, (BANDS, ROWS, COLUMNS), dtype=kind, endpoint=True)
        values.flat[:2] = limits.min, limits.max
    return values.astype(kind).astype(order + kind)


def same_bits(read, numbers):
    return np.asarray(read).tobytes() == numbers.astype(np.float32).tobytes()


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("interleave, axes", [("bsq", (0, 1, 2)), ("bil", (1, 0, 2)), ("BIP", (1, 2, 0))])
def test_envi_is_what_numpy_reads(tmp_path, interleave, axes, order):
    for number, kind in TYPES.items():
        numbers, offset = cube(kind, order), 11
        path = tmp_path / f"two words {kind}.dat"
        path.write_bytes(b"x" * offset + np.ascontiguousarray(numbers.transpose(axes)).tobytes())
        header = path.with_suffix(".hdr") if number % 2 else path.with_name(path.name + ".hdr")
        header.write_text(f"ENVI\r\n; a comment\r\nSamples = {COLUMNS}\r\nLINES={ROWS}\r\nbands = {BANDS}\r\nheader offset = {offset}\r\n"
                          f"data type = {number}\r\ninterleave = {interleave}\r\nbyte order = {int(order == '>')}\r\n"
                          "band names = {\r\n first,\r\n second, third}\r\ndescription = {a = b}\r\n", newline="")
        shape = [numbers.shape[a] for a in axes]
        read = np.fromfile(path, order + kind, offset=offset).reshape(shape).transpose(np.argsort(axes))
        assert np.array_equal(read, numbers)
        for file in (path, header):
            for band, name in enumerate(("first", "second", "third")):
                image = mk.read(file, channel=name)
                assert same_bits(image.plane(name), read[band])
                assert image.integer == (kind[0] != "f")
        assert image.attributes == {"description": "a = b"}


def test_envi_by_gdal_is_read(tmp_path):
    if shutil.which("gdal_translate") is None:
        pytest.skip("gdal_translate is not there (package gdal-bin)")
    numbers = np.arange(70, dtype="u1").reshape(7, 10) * 3  # GDAL 3.6 turns the bytes of 16 bits round
    (tmp_path / "in.pgm").write_bytes(b"P5 10 7 255\n" + numbers.tobytes())
    subprocess.run(["gdal_translate", "-q", "-of", "ENVI", "-ot", "Int32", tmp_path / "in.pgm", tmp_path / "out.img"], check=True)
    assert same_bits(mk.read(tmp_path / "out.img").plane("Band 1"), numbers)


def test_what_envi_numbers_mean(tmp_path):
    numbers = np.array([[[1, 2], [-999, 4]], [[10, -999], [30, 40]]], "<i2")
    numbers.tofile(tmp_path / "a.img")
    (tmp_path / "a.hdr").write_text("ENVI\nsamples = 2\nlines = 2\nbands = 2\ndata type = 2\ninterleave = bsq\nbyte order = 0\n"
                                    "data gain values = {0.5,\n 2}\ndata offset values = {0, 1}\ndata ignore value = -999\n"
                                    "wavelength units = Nanometers\nwavelength = {600, 550}\nmap info = {UTM, 1, 1, 0, 0, 30, 15}\n")
    image = mk.read(tmp_path / "a.hdr")
    assert image.names == ["0.55 um", "0.6 um"] and not image.integer  # a spectrum, by rising wavelength
    nan = np.nan
    assert np.array_equal(image.plane("0.6 um"), [[0.5, 1], [nan, 2]], equal_nan=True)
    assert np.array_equal(image.plane("0.55 um"), [[21, nan], [61, 81]], equal_nan=True)


def card(key, value):
    return f"{key:8}= {value:>20}".ljust(80)


def unit(cards, data, primary=True):
    first = card("SIMPLE", "T") if primary else "XTENSION= 'IMAGE   '".ljust(80)
    header = first + "".join(card(*c) for c in cards) + "END".ljust(80)
    return header.ljust(-(-len(header) // 2880) * 2880).encode() + data.ljust(-(-len(data) // 2880) * 2880, b"\0")


def sizes(bits, *axes):
    return [("BITPIX", bits), ("NAXIS", len(axes)), *((f"NAXIS{i + 1}", n) for i, n in enumerate(axes))]


@pytest.mark.parametrize("bits, kind", [(8, "u1"), (16, "i2"), (32, "i4"), (64, "i8"), (-32, "f4"), (-64, "f8")])
def test_fits_is_what_numpy_reads(tmp_path, bits, kind):
    numbers = cube(kind, ">")
    for order, turned in (("BOTTOM-UP", slice(None, None, -1)), ("TOP-DOWN", slice(None))):
        (tmp_path / "a.fits").write_bytes(unit([*sizes(bits, COLUMNS, ROWS, BANDS), ("ROWORDER", f"'{order}'")], numbers.tobytes()))
        for band in range(BANDS):
            image = mk.read(tmp_path / "a.fits", channel=f"plane {band + 1}")
            assert same_bits(image.plane(f"plane {band + 1}"), numbers[band, turned])
            assert image.integer == (bits > 0)


def test_what_fits_numbers_mean(tmp_path):
    stored = np.array([[-32768, 0], [7, 32767]], ">i2")
    (tmp_path / "a.fits").write_bytes(unit([*sizes(16), ("EXTEND", "T")], b"")
                                      + unit([*sizes(16, 2, 2), ("BZERO", "32768.0"), ("EXTNAME", "'RAW'")], stored.tobytes(), False)
                                      + unit([*sizes(16, 2, 2), ("BZERO", "1D1"), ("BSCALE", "5.E-1"), ("BLANK", 7), ("EXTNAME", "'IT''S'")],
                                             stored.tobytes(), False))
    raw = mk.read(tmp_path / "a.fits", layer="RAW")
    assert raw.integer and np.array_equal(raw.plane("Y"), [[32775, 65535], [0, 32768]])  # the last row of the file on top
    scaled = mk.read(tmp_path / "a.fits", part=2)
    assert not scaled.integer and np.array_equal(scaled.plane("Y"), [[np.nan, 16393.5], [-16374, 10]], equal_nan=True)
    assert scaled.attributes["EXTNAME"] == "IT'S"


SENSOR = """schema = 2
[frame]
focal_length = "1 m"
pitch = "10 um"
format = [400, 300]
[optics]
f_number = 8.0
wavelength = "2 um"
"""


def bell(size, centre, sigma=1.5):
    x = np.arange(size) - centre
    return np.exp(-0.5 * (x[:, None] ** 2 + 1.3 * x ** 2) / sigma ** 2)


def transform(rows_up, step, fx, fy):
    """At frequencies in cycles a pixel, +y down, of samples whose last row is the top one and whose middle is the origin."""
    rows = rows_up[::-1].astype(float)
    y, x = ((np.arange(n) - (n - 1) / 2) * step for n in rows.shape)
    return np.exp(-2j * np.pi * fy * y) @ rows @ np.exp(-2j * np.pi * fx * x) / rows.sum()


def sensor_of(tmp_path, table):
    """With the block that stands in the comments of the table."""
    keys = [line[2:] for line in (tmp_path / table).read_text().splitlines() if line.startswith(("# kind", "# step", "# positions"))]
    (tmp_path / "s.toml").write_text(SENSOR + "[[presample]]\n" + "\n".join(keys) + "\n")
    return mk.Sensor.load(tmp_path / "s.toml")


def test_psfex_is_its_polynomials(tmp_path):
    base, size = bell(17, 8.0), 17
    odd = np.gradient(base, axis=1), np.gradient(base, axis=0), np.gradient(np.gradient(base, axis=0), axis=1)
    planes = np.array([base, 0.5 * odd[0], 0.2 * odd[1], 0.3 * odd[1], -0.4 * odd[2], 0.25 * odd[0]], ">f4")  # 1, u, u2, v, uv, v2
    cards = [("BITPIX", 8), ("NAXIS", 2), ("NAXIS1", planes.nbytes), ("NAXIS2", 1), ("PCOUNT", 0), ("GCOUNT", 1), ("TFIELDS", 1),
             ("EXTNAME", "'PSF_DATA'"), ("TTYPE1", "'PSF_MASK'"), ("TFORM1", f"'{planes.size}E'"), ("POLNAXIS", 2), ("POLGRP1", 1),
             ("POLNAME1", "'X_IMAGE'"), ("POLZERO1", 200.0), ("POLSCAL1", 380.0), ("POLGRP2", 1), ("POLNAME2", "'Y_IMAGE'"),
             ("POLZERO2", 160.0), ("POLSCAL2", 270.0), ("POLNGRP", 1), ("POLDEG1", 2), ("PSF_SAMP", 0.5), ("PSFNAXIS", 3),
             ("PSFAXIS1", size), ("PSFAXIS2", size), ("PSFAXIS3", 6)]
    table = unit(cards, planes.tobytes(), False).replace(b"'IMAGE   '", b"'BINTABLE'")
    (tmp_path / "a.psf").write_bytes(unit([*sizes(8), ("EXTEND", "T")], b"") + table)
    assert same_bits(mk.read(tmp_path / "a.psf", channel="plane 5").plane("plane 5"), planes[4, ::-1])
    run_command("config", "import", tmp_path / "a.psf", "--detector", "400,300", "-o", tmp_path / "p.csv")
    sensor = sensor_of(tmp_path, "p.csv")
    for x, y in ((0.0, 0.0), (400.0, 300.0), (113.0, 79.0)):  # from the upper left corner
        u, v = (x + 0.5 - 200.0) / 380.0, (300.0 - y + 0.5 - 160.0) / 270.0
        here = sum(p * w for p, w in zip(planes.astype(float), (1, u, u * u, v, u * v, v * v)))
        for fx, fy in ((0.1, 0.0), (0.0, 0.2), (0.15, -0.1)):
            field = ((x - 200.0) / 250.0, (y - 150.0) / 250.0)  # in half diagonals
            # Samples are single, and the interpolation is exact for polynomials.
            assert abs(sensor.otf(fx, fy, unit="cy/px", field=field) - transform(here, 0.5, fx, fy)) < 2e-6


def test_stpsf_grids_and_cubes(tmp_path):
    psfs = [bell(16, 7.5 + 0.3 * k) for k in range(4)]  # an even number, the centre between the middle ones
    places = ((0, 0), (0, 399), (299, 0), (299, 399))  # y, x, from 0
    cube = np.array(psfs, ">f8")
    cards = [*sizes(-64, 16, 16, 4), ("OVERSAMP", 4), *((f"DET_YX{k}", f"'({y}.0, {x}.0)'") for k, (y, x) in enumerate(places))]
    (tmp_path / "grid.fits").write_bytes(unit(cards, cube.tobytes()))
    run_command("config", "import", tmp_path / "grid.fits", "--detector", "400,300", "-o", tmp_path / "g.csv")
    sensor = sensor_of(tmp_path, "g.csv")
    for psf, (y, x) in zip(psfs, places):
        for fx, fy in ((0.2, 0.0), (0.3, -0.4)):
            shift = np.exp(2j * np.pi * (fx + fy) / 8)  # half a step of a quarter of a pixel, towards the first row and column
            field = ((x + 0.5 - 200.0) / 250.0, (300.0 - y - 0.5 - 150.0) / 250.0)
            assert abs(sensor.otf(fx, fy, unit="cy/px", field=field) - shift * transform(psf, 0.25, fx, fy)) < 2e-6
    pair = np.array([bell(17, 8.0), bell(17, 8.0, 2.0)], ">f8")
    waves = [*sizes(-64, 17, 17, 2), ("PIXELSCL", 0.5), ("WAVELN00", "1.0E-06"), ("WAVELN01", "2.0E-06"), ("EXTNAME", "'OVERDIST'")]
    (tmp_path / "waves.fits").write_bytes(unit(sizes(-64, 17, 17), pair[0].tobytes()) + unit(waves, pair.tobytes(), False))
    block = run_command("config", "import", tmp_path / "waves.fits", "--field", "2", "--quiet")
    assert "2 um" in block  # of OVERDIST
    step = np.tan(np.radians(0.5 / 3600)) * 1e5  # of 1 m, in pixels
    assert abs(mk.Sensor.parse(SENSOR + block).otf(0.1, 0.0, unit="cy/px") - transform(pair[1], step, 0.1, 0)) < 2e-6


def test_pgm_and_ppm_are_what_numpy_reads(tmp_path):
    for planes, digits, binary in ((1, "P2", "P5"), (3, "P3", "P6")):
        for most, kind in ((200, "u1"), (4095, ">u2")):
            numbers = np.random.default_rng(2).integers(0, most, (ROWS, COLUMNS, planes), endpoint=True).astype(kind)
            start = f"# a camera\n{COLUMNS} {ROWS}\n# bits\n{most}\n"
            (tmp_path / "binary").write_bytes(f"{binary}\n{start}".encode() + numbers.tobytes())
            (tmp_path / "digits").write_text(f"{digits} {start}" + " ".join(map(str, numbers.ravel())))
            for name in ("binary", "digits"):
                image = mk.read(tmp_path / name)
                assert image.integer and image.names == list("RGB" if planes == 3 else "Y")
                assert all(same_bits(image.plane(n), numbers[..., i]) for i, n in enumerate(image.names))


@pytest.mark.parametrize("bits", [8, 24, 32])
@pytest.mark.parametrize("upwards", [True, False])
def test_bmp_is_what_numpy_reads(tmp_path, bits, upwards):
    numbers = np.random.default_rng(3).integers(0, 255, (ROWS, COLUMNS, bits // 8), endpoint=True).astype("u1")
    palette = b"".join(bytes((i, i, i, 0)) for i in range(256)) if bits == 8 else b""
    rows = [row.tobytes().ljust(-(-row.size // 4) * 4, b"\0") for row in (numbers[::-1] if upwards else numbers)]
    begin = 54 + len(palette)
    (tmp_path / "a.bmp").write_bytes(struct.pack("<2sIII", b"BM", begin + sum(map(len, rows)), 0, begin)
                                     + struct.pack("<IiiHHIIiiII", 40, COLUMNS, ROWS if upwards else -ROWS, 1, bits, 0, 0, 0, 0, 0, 0)
                                     + palette + b"".join(rows))
    image = mk.read(tmp_path / "a.bmp")
    places = {"Y": 0} if bits == 8 else {"R": 2, "G": 1, "B": 0}
    assert image.names == list(places)
    assert all(same_bits(image.plane(name), numbers[..., i]) for name, i in places.items())


def test_envi_is_written_for_numpy(tmp_path):
    planes = {"a": np.arange(12, dtype=np.float32).reshape(3, 4), "b": np.full((3, 4), np.pi, np.float32)}
    mk.write(tmp_path / "x.hdr", planes, sample="5 um", quantity="radiance", attributes={"note": "two\nlines {"})
    assert np.array_equal(np.fromfile(tmp_path / "x.img", "<f4").reshape(3, 2, 4).transpose(1, 0, 2), list(planes.values()))
    back = mk.read(tmp_path / "x.img", channel="b")
    assert np.array_equal(back.plane("b"), planes["b"]) and back.plane("b").sample is not None
    assert back.attributes["mtf:quantity"] == "radiance" and back.attributes["note"] == "two\nlines ("


def test_wavelengths_and_the_ground_are_kept(tmp_path):
    """A pixel is two samples of the scene; gdalinfo reads where they lie."""
    np.ones((2, 8, 12), "<f4").tofile(tmp_path / "scene.img")
    (tmp_path / "scene.hdr").write_text("ENVI\nsamples = 12\nlines = 8\nbands = 2\ndata type = 4\ninterleave = bsq\nbyte order = 0\n"
                                        "wavelength units = Nanometers\nwavelength = {1000, 2000}\nmtf:units = W.m^-2.sr^-1.um^-1\n"
                                        "map info = {UTM, 1.5, 3, 500000, 5400000, 30, 30, 32, North, WGS-84, units=Meters}\n")
    text = SENSOR.replace("[400, 300]", "[6, 4]") + '[scene]\nsample = "5 um"\nquantity = "spectral_radiance"\ngain = 1\noffset = 0\n'
    (tmp_path / "s.toml").write_text(text + '[[presample]]\nkind = "gaussian"\nsigma = "3 um"\n')
    for options, first in (((), (0, 0)), (("--roi", "2,1,3,2"), (2, 1))):
        run_command("simulate", tmp_path / "s.toml", tmp_path / "scene.hdr", "-o", tmp_path / "out.hdr", *options)
        assert "wavelength = {1, 2}" in (tmp_path / "out.hdr").read_text()
        if shutil.which("gdalinfo") is None:
            pytest.skip("gdalinfo is not there (package gdal-bin)")
        info = json.loads(subprocess.run(["gdalinfo", "-json", tmp_path / "out.img"], check=True, capture_output=True).stdout)
        corner = 500000 - 0.5 * 30, 5400000 + 2 * 30  # of the first pixel: its outer corner is at 1, 1
        assert info["geoTransform"] == [corner[0] + 60 * first[0], 60, 0, corner[1] - 60 * first[1], 0, -60]
        assert "UTM zone 32N" in info["coordinateSystem"]["wkt"]


def test_frames_of_doubles_say_what_float32_takes(tmp_path):
    """Between 2^21 and 2^22 floats are 1/4 apart: numpy's own rounding says by how much values change."""
    random = np.random.default_rng(3)

    def characterized(contrast):
        text, shares = "[camera]\nbits = 22\n", []
        for level, light in enumerate(["light = false", "relative = 1", "relative = 2", "relative = 3"]):
            frames = 3e6 + contrast * (20.0 * level + np.sqrt(20.0 * level + 1.0) * random.standard_normal((4, 24, 32)))
            np.save(tmp_path / f"{level}.npy", frames)
            text += f'[[stack]]\nframes = "{level}.npy"\n{light}\n'
            changed = frames - frames.astype("f4").astype("f8")
            shares.append(np.sqrt(np.mean(changed[0] ** 2)) / np.std(frames[0]))
        (tmp_path / "stacks.toml").write_text(text)
        done = subprocess.run([COMMAND, "characterize", tmp_path / "stacks.toml", "--allow-misfit"], capture_output=True, text=True, check=False)
        return done, shares

    done, shares = characterized(20.0)
    assert 1e-5 < shares[0] < 0.01
    assert f"0.npy frame 1: float32 changes its values by {100 * shares[0]:.2g} % (rms)" in done.stdout + done.stderr
    done, shares = characterized(1.0)
    assert shares[0] > 0.01
    assert done.returncode == 1 and "cannot read" in done.stderr and f"{100 * shares[0]:.2g} % (rms)" in done.stderr


@pytest.mark.parametrize("ending", ["hdr", "tif"])
def test_info_shows_the_header_of_values_that_are_refused(tmp_path, ending):
    """Of double precision about 1e9, where floats are 64 apart."""
    numbers = 1e9 + np.random.default_rng(2).standard_normal((4, 6))
    path = tmp_path / f"a.{ending}"
    (tmp_path / "a.hdr").write_text("ENVI\nsamples = 6\nlines = 4\nbands = 1\ndata type = 5\nbyte order = 0\ninterleave = bsq\n")
    (tmp_path / "a.dat").write_bytes(numbers.tobytes())
    if ending == "tif":
        if shutil.which("gdal_translate") is None:
            pytest.skip("gdal_translate is not there (package gdal-bin)")
        subprocess.run(["gdal_translate", "-q", "-of", "GTiff", tmp_path / "a.dat", path], check=True)
    with pytest.raises(mk.DataError, match="subtract a constant"):
        mk.read(path)
    facts = run_json("info", path)
    assert (facts["width"], facts["height"]) == (6, 4) and facts["channels"][0]["type"] == "double"
    assert facts["channels"][0]["mean"] is None and facts["next"] == ""
    assert any("float32 changes its values by" in note and "subtract a constant" in note for note in facts["notes"])
    assert "6 x 4 px" in run_command("info", path)


def test_each_point_spread_of_a_table_is_checked(tmp_path):
    """Also those beyond the first; the sensor that reads the table would refuse the same."""
    places = ((0, 0), (0, 399), (299, 0), (299, 399))

    def imported(third):
        planes = np.array([bell(17, 8.0), bell(17, 8.0), third, bell(17, 8.0)], ">f8")
        cards = [*sizes(-64, 17, 17, 4), ("OVERSAMP", 4), *((f"DET_YX{k}", f"'({y}.0, {x}.0)'") for k, (y, x) in enumerate(places))]
        (tmp_path / "grid.fits").write_bytes(unit(cards, planes.tobytes()))
        words = [COMMAND, "config", "import", tmp_path / "grid.fits", "--detector", "400,300", "--force", "-o", tmp_path / "g.csv"]
        return subprocess.run(words, capture_output=True, text=True, check=False)

    done = imported(bell(17, 8.0))
    assert done.returncode == 0 and "end before" not in (tmp_path / "g.csv").read_text()
    done = imported(np.ones((17, 17)))  # a point spread that goes on beyond its samples
    assert done.returncode == 2 and "(0.5, 0.5) px: samples: they end before" in done.stderr
    done = imported(bell(17, 8.0) + 2e-4 * np.max(bell(17, 8.0)))
    assert done.returncode == 0 and "so it is with 1 place of 4" in (tmp_path / "g.csv").read_text()


def test_of_many_images_one_is_opened(tmp_path):
    """Each that is open has the headers of all, so that more than 64 are listed by their number alone."""
    if shutil.which("gdal_translate") is None:
        pytest.skip("gdal_translate is not there (package gdal-bin)")
    numbers = np.arange(70 * 4 * 6, dtype="<u2").reshape(70, 4, 6)
    (tmp_path / "a.hdr").write_text("ENVI\nsamples = 6\nlines = 4\nbands = 70\ndata type = 12\nbyte order = 0\ninterleave = bsq\n")
    (tmp_path / "a.dat").write_bytes(numbers.tobytes())

    def written(bands, name):
        options = [word for band in range(1, bands + 1) for word in ("-b", str(band))]
        subprocess.run(["gdal_translate", "-q", "-of", "netCDF", "-co", "FORMAT=NC4", *options, tmp_path / "a.dat", tmp_path / "a.nc"], check=True)
        (tmp_path / "a.nc").rename(tmp_path / name)
        return tmp_path / name

    def part_of(bands, part):
        """The images of HDF5 come by their names, Band1, Band10, ...; netCDF begins with the bottom row."""
        return numbers[sorted(range(1, bands + 1), key=str)[part] - 1, ::-1]

    try:
        few = mk.read(written(64, "few.h5"), part=63)
    except mk.DataError as error:
        pytest.skip(str(error))  # built without the module of GDAL
    assert np.array_equal(few.plane(), part_of(64, 63))
    with pytest.raises(mk.UsageError, match="several parts"):
        mk.read(tmp_path / "few.h5")
    many = written(70, "many.h5")
    for part in (0, 69):
        assert np.array_equal(mk.read(many, part=part).plane(), part_of(70, part))
    with pytest.raises(mk.UsageError, match=r"70 images, at most 64 .* N from 0 \(.*\) to 69"):
        mk.read(many)
    with pytest.raises(mk.UsageError, match="part 70 is none of its 70 images"):
        mk.read(many, part=70)
    assert [channel["part"] for channel in run_json("info", many, "--part", "69")["channels"]] == [69]
