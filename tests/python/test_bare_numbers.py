# SPDX-License-Identifier: Apache-2.0
"""ENVI, FITS, PGM, PPM and BMP against what numpy reads of the same bytes, bit for bit. Files are written by numpy."""

import shutil
import subprocess
import struct

import numpy as np
import pytest

import mtfkit as mk

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
