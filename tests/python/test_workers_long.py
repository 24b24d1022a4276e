# SPDX-License-Identifier: Apache-2.0
"""Workers that are killed lose nothing but their own piece: the table is the same, byte for byte."""

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import pytest

import mtfkit as mk


def piece(study, first, last, marker):
    """Rows of a piece. The first worker that comes to the marked piece is killed in the middle of its work."""
    if first == 400 and not os.path.exists(marker):
        with open(marker, "w", encoding="utf-8"):
            pass
        os.kill(os.getpid(), signal.SIGKILL)
    return first, study.rows(first, last).tobytes()


def pieces_of(study):
    return [(first, min(first + 100, study.designs)) for first in range(0, study.designs, 100)]


def test_a_killed_worker_of_a_process_pool(studies, tmp_path):
    study = mk.Study.load(studies / "aperture_against_pitch.toml")
    done, killed = {}, 0
    while len(done) < len(pieces_of(study)):
        with ProcessPoolExecutor(2) as pool:
            futures = [pool.submit(piece, study, first, last, str(tmp_path / "marker"))
                       for first, last in pieces_of(study) if first not in done]
            for future in futures:
                try:
                    first, rows = future.result()
                    done[first] = rows
                except BrokenProcessPool:
                    killed = 1
    assert killed
    assert b"".join(done[first] for first, _ in pieces_of(study)) == study.rows(threads=2).tobytes()


def test_a_killed_worker_of_dask(studies, tmp_path):
    distributed = pytest.importorskip("distributed")  # not among the packages of the suite
    study = mk.Study.load(studies / "aperture_against_pitch.toml")
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster, \
            distributed.Client(cluster) as client:
        futures = [client.submit(piece, study, first, last, str(tmp_path / "marker"), pure=False)
                   for first, last in pieces_of(study)]
        done = dict(client.gather(futures))
    assert b"".join(done[first] for first, _ in pieces_of(study)) == study.rows(threads=2).tobytes()
