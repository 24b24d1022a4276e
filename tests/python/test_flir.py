# SPDX-License-Identifier: Apache-2.0
"""FLIR's images against ExifTool, bit for bit. Files are written here from the public tables of tags, pictures by PIL."""

import ctypes
import io
import shutil
import struct
import subprocess
import zlib

import numpy as np
import pytest
from PIL import Image

import mtfkit as mk
from conftest import COMMAND

ROWS, COLUMNS = 6, 9
CAMERA = {0x20: 0.95, 0x24: 12.0, 0x28: 293.15, 0x2c: 288.15, 0x30: 300.0, 0x34: 0.9, 0x3c: 0.6, 0x58: 14985.93, 0x5c: 1398.1, 0x60: 1.0,
          0x70: 0.006569, 0x74: 0.01262, 0x78: -0.002276, 0x7c: -0.00667, 0x80: 1.9, 0x1b4: 25.0, 0x30c: 0.0112832}


def counts(frame=0):
    """A scene of neighbours that differ little, with the extremes of 16 bits at one place."""
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    numbers = (12000 + 300 * frame + 41 * rows + 17 * columns).astype("u2")
    numbers[2, 3:5] = 0, 65535
    return numbers


def png(numbers):
    """16 bits grey, the least byte first, as FLIR has it."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    lines = b"".join(b"\0" + row.astype("<u2").tobytes() for row in numbers)
    header = struct.pack(">IIBBBBB", numbers.shape[1], numbers.shape[0], 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")


def jpeg_ls(numbers):
    """By CharLS's encoder."""
    try:
        charls = ctypes.CDLL("libcharls.so.2")
    except OSError:
        pytest.skip("CharLS is not there (package libcharls-dev)")
    charls.charls_jpegls_encoder_create.restype = ctypes.c_void_p
    encoder = ctypes.c_void_p(charls.charls_jpegls_encoder_create())
    frame = struct.pack("=IIii", numbers.shape[1], numbers.shape[0], 16, 1)
    out, size, pixels = ctypes.create_string_buffer(4096), ctypes.c_size_t(), numbers.astype("=u2").tobytes()
    assert charls.charls_jpegls_encoder_set_frame_info(encoder, frame) == 0
    assert charls.charls_jpegls_encoder_set_destination_buffer(encoder, out, ctypes.c_size_t(4096)) == 0
    assert charls.charls_jpegls_encoder_encode_from_buffer(encoder, pixels, ctypes.c_size_t(len(pixels)), 0) == 0
    assert charls.charls_jpegls_encoder_get_bytes_written(encoder, ctypes.byref(size)) == 0
    return out.raw[:size.value]


def fff(numbers, order="<", as_png=False, camera=CAMERA, data=None):
    rows, columns = numbers.shape
    data = data or (png(numbers) if as_png else numbers.astype(order + "u2").tobytes())
    raw = struct.pack(order + "3H", 2, columns, rows).ljust(32, b"\0") + data
    info = bytearray(0x500)
    struct.pack_into(order + "H", info, 0, 2)
    for at, value in camera.items():
        struct.pack_into(order + "f", info, at, value)
    struct.pack_into(order + "i", info, 0x308, -6233)
    info[0xd4:0xdc], info[0x170:0x174] = b"FLIR E60", b"FOL7"
    struct.pack_into(order + "IIh", info, 0x384, 1328966228, 253, -60)
    start = 64 + 3 * 32
    rows_of = struct.pack(order + "HHIIIIIII", 1, 3 if as_png else 2, 100, 1, start, len(raw), 0, 0, 0)
    rows_of += struct.pack(order + "HHIIIIIII", 0x20, 1, 100, 2, start + len(raw), len(info), 0, 0, 0) + bytes(32)
    return struct.pack(order + "4s16s4I", b"FFF", b"test", 101, 64, 3, 3).ljust(64, b"\0") + rows_of + raw + bytes(info)


def jpeg(flir, stretch=1000):
    """A picture of 16 x 8, the FFF in segments of APP1."""
    file = io.BytesIO()
    Image.new("L", (16, 8), 90).save(file, "JPEG")
    stretches = [flir[i:i + stretch] for i in range(0, len(flir), stretch)]
    segments = b"".join(b"\xff\xe1" + struct.pack(">H", 10 + len(s)) + b"FLIR\0\1" + bytes([i, len(stretches) - 1]) + s
                        for i, s in enumerate(stretches))
    return file.getvalue()[:2] + segments + file.getvalue()[2:]


def by_exiftool(path):
    """Its raw counts: a PNG as the camera wrote it, or a TIFF."""
    if shutil.which("exiftool") is None:
        pytest.skip("exiftool is not there (package libimage-exiftool-perl)")
    raw = subprocess.run(["exiftool", "-b", "-RawThermalImage", path], check=True, capture_output=True).stdout
    numbers = np.asarray(Image.open(io.BytesIO(raw))).astype("u2")
    return numbers.byteswap() if raw.startswith(b"\x89PNG") else numbers


@pytest.mark.parametrize("as_png", [False, True])
@pytest.mark.parametrize("where", ["fff", "jpg"])
def test_counts_are_those_that_exiftool_reads(tmp_path, where, as_png):
    numbers, path = counts(), tmp_path / f"a.{where}"
    flir = fff(numbers, as_png=as_png)
    path.write_bytes(flir if where == "fff" else jpeg(flir))
    image = mk.read(path, channel="counts")
    assert np.array_equal(image.plane("counts"), numbers)
    assert np.array_equal(by_exiftool(path), numbers)
    names = {"PlanckR1": "camera_counts.R1", "PlanckB": "camera_counts.B", "PlanckF": "camera_counts.F", "PlanckO": "camera_counts.O",
             "PlanckR2": "camera_counts.R2", "Emissivity": "scene.emissivity", "ObjectDistance": "flir.distance",
             "IRWindowTransmission": "flir.window_transmission", "AtmosphericTransAlpha2": "flir.alpha2", "AtmosphericTransX": "flir.X"}
    tags = subprocess.run(["exiftool", "-n", "-s", *("-" + tag for tag in names), path], check=True, capture_output=True, text=True).stdout
    said = dict(line.replace(" ", "").split(":") for line in tags.splitlines())
    for tag, name in names.items():  # ExifTool prints 15 digits at most
        assert float(image.attributes[name].split()[0]) == pytest.approx(float(said[tag]), rel=1e-9)
    assert image.attributes["flir.camera"] == "FLIR E60"
    assert image.attributes["flir.time"] == "2012-02-11T13:17:08Z, local time 1 h later"


def test_both_orders_of_bytes_and_frames_of_a_sequence(tmp_path):
    path = tmp_path / "a.fff"
    path.write_bytes(fff(counts(), ">"))
    assert np.array_equal(mk.read(path).plane("counts"), counts())
    path.write_bytes(jpeg(fff(counts(), ">", as_png=True)))  # as most cameras have it
    assert np.array_equal(mk.read(path, channel="counts").plane("counts"), counts())
    assert mk.read(path).names == ["Y"] and mk.read(path).plane("Y").shape[0] == 8
    path.write_bytes(b"".join(fff(counts(frame), as_png=frame == 1) for frame in range(3)) + b"rest")
    for frame in range(3):
        assert np.array_equal(mk.read(path, part=frame).plane("counts"), counts(frame))
    with pytest.raises(mk.UsageError, match="part N"):
        mk.read(path)


def test_a_csq_is_read_by_frame(tmp_path):
    path = tmp_path / "a.csq"
    path.write_bytes(b"".join(fff(counts(frame), data=jpeg_ls(counts(frame))) for frame in range(3)))
    for frame in range(3):
        try:
            image = mk.read(path, part=frame)
        except mk.DataError as error:
            assert "libcharls-dev" in str(error)
            pytest.skip("built without CharLS")
        assert np.array_equal(image.plane("counts"), counts(frame)) and image.attributes["flir.camera"] == "FLIR E60"
    path.write_bytes(fff(counts()[:, :-1], data=jpeg_ls(counts())))
    with pytest.raises(mk.DataError, match="JPEG-LS"):
        mk.read(path)


def test_counts_at_an_end_of_the_scale_are_told(tmp_path):
    """What they saw is beyond the temperatures that they become: info and simulate say how many there are."""
    numbers = np.full((32, 32), 16000, "u2")
    for clipped in (0, 7):
        numbers[3, :clipped] = 65535
        (tmp_path / "a.fff").write_bytes(fff(numbers))
        (tmp_path / "s.toml").write_text(
            'schema = 2\n[frame]\nfocal_length = "18 mm"\npitch = "17 um"\nintegration_time = "10 ms"\n[scene]\nsample = "17 um"\n'
            'quantity = "counts"\n[optics]\nf_number = 1.0\n[band]\nwavelength = ["8 um", "14 um"]\n[[presample]]\nkind = "jitter"\n'
            'rms = "0.01 um"\n[detector]\nquantum_efficiency = 1.0\n')
        for words in (["info", "a.fff"], ["simulate", "s.toml", "a.fff", "-o", "out.exr"]):
            run = subprocess.run([COMMAND, *words], cwd=tmp_path, check=True, capture_output=True, text=True)
            text = run.stdout + run.stderr
            assert text.count("counts stand at an end of the scale (0 or 65535)") == (1 if clipped else 0), text
            assert not clipped or "7 of 1024 counts" in text
