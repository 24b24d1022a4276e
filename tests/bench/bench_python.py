#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What Python costs: a frame beside its twin in C++, views of arrays, two Python threads, rows of a large study.

Usage: bench_python.py BUILD [SIDE]     SIDE squared designs, default 1000; with BUILD/python on PYTHONPATH; BUILD/tests/bench/bench_frame and BUILD/apps/mtf are run
Columns are minimum and median of rounds in turn: ten of frames, five of the others.
"""

import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import mtfkit as mk

FRAMES, ROUNDS = 30, 5
SENSOR = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um"), optics=dict(f_number=2.0, wavelength="4 um"),
                   presample=["diffraction", mk.Footprint(width="15 um"), mk.Jitter(rms="20 urad")])


def show(name, values, unit):
    print(f"{name:52} {min(values):9.3f} {statistics.median(values):9.3f} {unit}", flush=True)


def frame_of_python(plan, scene, out, threads=1):
    cpu = time.process_time()
    for _ in range(FRAMES):
        plan(scene, out=out, threads=threads)
    return 1e3 * (time.process_time() - cpu) / FRAMES


def frames(build):
    scene = (5 + np.random.default_rng(1).standard_normal((1024, 1280))).astype("float32")
    plan = SENSOR.compile(scene, sample="15 um", tolerance=1e-4)
    for fresh in (False, True):
        twin = subprocess.Popen([build / "tests/bench/bench_frame", "fresh" if fresh else ""], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True)
        out = None if fresh else plan(scene)
        python, cpp = [], []
        def ask():
            twin.stdin.write(f"{FRAMES} 1\n")
            twin.stdin.flush()
            return float(twin.stdout.readline().split()[0])
        ask()
        for turn in range(2 * ROUNDS):  # either one goes first as often as the other
            if turn % 2:
                cpp.append(ask())
            python.append(frame_of_python(plan, scene, out))
            if turn % 2 == 0:
                cpp.append(ask())
        twin.stdin.close()
        twin.wait()
        what = "result of its own" if fresh else "out="
        show(f"frame, {what}: Python", python, "ms cpu")
        show(f"frame, {what}: C++", cpp, "ms cpu")
        print(f"{'ratio of medians':52} {statistics.median(python) / statistics.median(cpp):9.3f}")
    one, two = [], []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(FRAMES):
            plan(scene, threads=2)
        one.append(1e3 * (time.perf_counter() - start) / FRAMES)
        start = time.perf_counter()
        workers = [threading.Thread(target=lambda: [plan(scene, threads=1) for _ in range(FRAMES // 2)]) for _ in range(2)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        two.append(1e3 * (time.perf_counter() - start) / FRAMES)
    show("frame, threads=2", one, "ms wall")
    show("frame, two Python threads", two, "ms wall")
    print(f"{'throughput of two threads / threads=2':52} {statistics.median(one) / statistics.median(two):9.3f}")


def views():
    small = mk.Sensor(frame=dict(focal_length="100 mm", pitch="15 um")).compile((1, 1), sample="15 um")
    pixel, out = np.zeros((1, 1), "float32"), np.zeros((1, 1), "float32")
    calls = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(20000):
            small(pixel, out=out, threads=1)
        calls.append(1e6 * (time.perf_counter() - start) / 20000)
    show("call with a view of 1 x 1 in and out", calls, "us")


def large_study(build, side):
    studies = Path(__file__).resolve().parents[2] / "notebooks-data" / "studies"
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "satellite.toml").write_text((studies / "satellite.toml").read_text())
        text = (studies / "aperture_against_pitch.toml").read_text()
        text = text.replace("count = 37", f"count = {side}").replace("count = 33", f"count = {side}")
        (Path(folder) / "large.toml").write_text(text)
        start = time.perf_counter()
        subprocess.run([build / "apps/mtf", "sweep", f"{folder}/large.toml", "-o", f"{folder}/out"], check=True,
                       capture_output=True)
        command = time.perf_counter() - start
        start = time.perf_counter()
        table = mk.Study.load(f"{folder}/large.toml").run()
        python = time.perf_counter() - start
        said = np.load(f"{folder}/out/designs.npy", mmap_mode="r")
        same = np.array_equal(said[:, :3], table.iloc[:, :3].to_numpy(), equal_nan=True)
        print(f"{len(table)} designs to a DataFrame: Python {python:.1f} s, mtf sweep {command:.1f} s, ratio "
              f"{python / command:.3f}, the same numbers {same}")


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    print(f"{'':52} {'min':>9} {'median':>9}")
    views()
    frames(folder)
    large_study(folder, int(sys.argv[2]) if len(sys.argv) > 2 else 1000)
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
