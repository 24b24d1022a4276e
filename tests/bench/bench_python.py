#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What Python costs: a frame beside its twin in C++, views of arrays, two Python threads, rows of a large study.

Usage: bench_python.py BUILD          frames and views; BUILD/tests/bench/bench_frame is run
       bench_python.py BUILD SIDE     a study of SIDE x SIDE designs (1000: a million), beside BUILD/apps/mtf sweep
With BUILD/python on PYTHONPATH. Columns are minimum and median of rounds in turn: ten of frames, five of the others, two of
studies.
"""

import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import mtfkit as mk

FRAMES, ROUNDS, STUDY_ROUNDS = 30, 5, 2
METRICS = '["snr", "target_snr", "q", "mtf_nyquist", "well_fill"]'
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


#: Loads the study, makes the DataFrame, and holds it to the table of the command where that is there.
TO_DATAFRAME = """
import sys, time
start = time.perf_counter()
import numpy as np, pandas
import mtfkit as mk
imported, cpu = time.perf_counter(), time.process_time()
study = mk.Study.load(sys.argv[1])
table = study.run()
print(time.perf_counter() - imported, time.process_time() - cpu, imported - start)
said = np.load(sys.argv[2], mmap_mode="r")
print(all(np.array_equal(said[:, i], table.iloc[:, i].to_numpy(dtype="f8"), equal_nan=True) for i in range(table.shape[1])))
"""


def measured(*words):
    """Seconds of a process, of its cpu time, its most memory in MiB, and its output."""
    start = time.perf_counter()
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    output = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, words
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, output


def large_study(build, side):
    """side x side designs with metrics of some microseconds each, as a table of the command and as a DataFrame, in turn."""
    studies = Path(__file__).resolve().parents[2] / "notebooks-data" / "studies"
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "satellite.toml").write_text((studies / "satellite.toml").read_text())
        text = (studies / "aperture_against_pitch.toml").read_text()
        text = text.replace("count = 37", f"count = {side}").replace("count = 33", f"count = {side}")
        text = re.sub(r"(?m)^list = .*", f"list = {METRICS}", text).replace("niirs_giqe5", "snr")
        text = text.replace("snr > 5", "snr > 50")
        (Path(folder) / "large.toml").write_text(text)
        command, python, command_cpu, python_cpu = [], [], [], []
        for turn in range(STUDY_ROUNDS):
            out = Path(folder) / f"out{turn}"
            seconds, cpu, memory, _ = measured(build / "apps/mtf", "sweep", f"{folder}/large.toml", "-o", out)
            command.append(seconds)
            command_cpu.append(cpu)
            _, _, memory_of_python, said = measured(sys.executable, "-c", TO_DATAFRAME, f"{folder}/large.toml", out / "designs.npy")
            (made, made_cpu, imported), same = (float(v) for v in said.split()[:3]), said.split()[3]
            python.append(made)
            python_cpu.append(made_cpu)
            print(f"{side * side} designs: mtf sweep {seconds:.1f} s, cpu {cpu:.1f} s, {memory:.0f} MiB; DataFrame {made:.1f} s, "
                  f"cpu {made_cpu:.1f} s, after {imported:.2f} s of imports, {memory_of_python:.0f} MiB; the same numbers {same}",
                  flush=True)
            shutil.rmtree(out)
        show(f"{side * side} designs, mtf sweep", command, "s")
        show(f"{side * side} designs to a DataFrame", python, "s")
        show(f"{side * side} designs, mtf sweep", command_cpu, "s cpu")
        show(f"{side * side} designs to a DataFrame", python_cpu, "s cpu")
        for what, ours, theirs in (("wall", python, command), ("cpu", python_cpu, command_cpu)):
            print(f"{f'ratio of medians, {what}':52} {statistics.median(ours) / statistics.median(theirs):9.3f}")


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    print(f"{'':52} {'min':>9} {'median':>9}")
    if len(sys.argv) > 2:
        large_study(folder, int(sys.argv[2]))
    else:
        views()
        frames(folder)
        print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
