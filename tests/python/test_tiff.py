# SPDX-License-Identifier: Apache-2.0
"""TIFF by GDAL: signed numbers, 12 bits, pixels without data; and pages by PIL. Values are those that were given to the writers."""

import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

import mtfkit as mk

ROWS, COLUMNS = 5, 7


def by_gdal(tmp_path, numbers, *options):
    """Numbers from -2000 up, as GDAL writes them from an ENVI image."""
    if shutil.which("gdal_translate") is None:
        pytest.skip("gdal_translate is not there (package gdal-bin)")
    numbers.astype("<i2").tofile(tmp_path / "a.img")
    (tmp_path / "a.hdr").write_text(f"ENVI\nsamples = {COLUMNS}\nlines = {ROWS}\nbands = 1\ndata type = 2\nbyte order = 0\n")
    subprocess.run(["gdal_translate", "-q", "-of", "GTiff", *options, tmp_path / "a.img", tmp_path / "a.tif"], check=True)
    return mk.read(tmp_path / "a.tif")


def test_signed_numbers_and_pixels_without_data(tmp_path):
    numbers = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS) * 1900 - 32768
    numbers[1, 2] = -9999
    image = by_gdal(tmp_path, numbers, "-a_nodata", "-9999", "-co", "COMPRESS=DEFLATE")
    assert image.integer and np.isnan(image.plane("Y")[1, 2])
    there = numbers != -9999
    assert np.array_equal(image.plane("Y")[there], numbers[there])


@pytest.mark.parametrize("tiled", ["NO", "YES"])
def test_12_bits(tmp_path, tiled):
    numbers = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS) * 119  # an odd number a row; the last is 4046
    numbers[0, 0], numbers[4, 6] = 4095, 1
    image = by_gdal(tmp_path, numbers, "-ot", "UInt16", "-co", "NBITS=12", "-co", f"TILED={tiled}")
    assert np.array_equal(image.plane("Y"), numbers)


def test_pages_of_a_file(tmp_path):
    pages = [Image.fromarray(np.full((ROWS, COLUMNS + page), 100 * page, "uint16")) for page in range(3)]
    pages[0].save(tmp_path / "a.tif", save_all=True, append_images=pages[1:])
    for page in range(3):
        image = mk.read(tmp_path / "a.tif", part=page)
        assert image.plane("Y").shape == (ROWS, COLUMNS + page) and np.all(image.plane("Y") == 100 * page)
    with pytest.raises(mk.DataError, match="page 4 of a TIFF of 3 pages"):
        mk.read(tmp_path / "a.tif", part=3)
