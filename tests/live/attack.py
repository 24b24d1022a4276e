#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Attacks on the server of `mtf live`: each is refused by name or served, and after all of them the server answers as
before, has opened no file and has not grown. Usage: attack.py MTF"""

import http.client
import json
import os
import re
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

MTF = sys.argv[1]
BAD = []


def expect(what, value, wanted):
    if value not in (wanted if isinstance(wanted, tuple) else (wanted,)):
        BAD.append(f"{what}: {value!r} instead of {wanted!r}")


class Server:
    def __init__(self, *options):
        self.process = subprocess.Popen([MTF, "live", "--no-browser", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#([0-9a-f]{32})\n", line)
        if not found:
            raise SystemExit(f"no address but {line!r}: {self.process.stderr.read()}")
        self.port, self.token = int(found[1]), found[2]

    def ask(self, method, path, body=None, headers=None, token=True):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        head = {"X-Mtf-Token": self.token} if token else {}
        connection.request(method, path, body, {**head, **(headers or {})})
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        # What cannot be done with an allowed request says so in an ordinary answer.
        refused = json.loads(data).get("status") if data.startswith(b'{"error"') else None
        return refused or answer.status, data, answer

    def raw(self, data, wait=3.0):
        """The first answer to these bytes; b"" where none comes in time."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as peer:
            got = b""
            try:
                peer.sendall(data)
                while True:
                    piece = peer.recv(65536)
                    got += piece
                    length = re.search(rb"Content-Length: (\d+)", got)
                    whole = length and len(got.partition(b"\r\n\r\n")[2]) >= int(length[1])
                    if not piece or whole:
                        break
            except OSError:
                pass
            return got

    def memory_mib(self):
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1024

    def threads(self):
        return len(os.listdir(f"/proc/{self.process.pid}/task"))

    def end(self, how=signal.SIGINT):
        self.process.send_signal(how)
        return self.process.wait(timeout=15)


def tokens_hosts_origins(server):
    frame = json.dumps({"edits": []})
    expect("token", server.ask("POST", "/frame", frame)[0], 200)
    expect("no token", server.ask("POST", "/frame", frame, token=False)[0], 403)
    expect("wrong token", server.ask("POST", "/frame", frame, {"X-Mtf-Token": "0" * 32}, token=False)[0], 403)
    expect("a part of the token", server.ask("POST", "/frame", frame, {"X-Mtf-Token": server.token[:31]}, token=False)[0], 403)
    expect("token in the address", server.ask("POST", f"/frame?token={server.token}", frame, token=False)[0], 403)
    for host in ("example.com", f"evil.test:{server.port}", "127.0.0.1.evil.test", "localhost.evil.test:80", "", "127.0.0.2"):
        expect(f"Host {host!r}", server.ask("POST", "/frame", frame, {"Host": host})[0], (421, 400))
        expect(f"page for Host {host!r}", server.ask("GET", "/", None, {"Host": host})[0], (421, 400))
    expect("tunnel", server.ask("POST", "/start", "{}", {"Host": "localhost:8080"})[0], 200)
    own = f"http://127.0.0.1:{server.port}"
    expect("own origin", server.ask("POST", "/start", "{}", {"Origin": own})[0], 200)
    for origin in ("http://example.com", "null", "https://127.0.0.1", own + ".evil.test", own[:-1]):
        status, _, answer = server.ask("POST", "/frame", frame, {"Origin": origin})
        expect(f"Origin {origin}", status, 403)
        expect("no permission for other origins", answer.getheader("Access-Control-Allow-Origin"), None)
    for method in ("PUT", "DELETE", "OPTIONS", "PATCH"):
        expect(method, server.ask(method, "/frame", frame)[0], (405, 400))
    _, page, answer = server.ask("GET", "/", token=False)
    policy = answer.getheader("Content-Security-Policy")
    expect("policy", "default-src 'none'" in policy and "unsafe" not in policy, True)
    expect("page without inline code", re.search(rb"<script>|<style>| on\w+=|style=", page), None)
    expect("the token is in no file", server.token.encode() in page, False)


def paths(server):
    for path in ("/../../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/page.html",
                 "/style.css/../../../etc/passwd", "/frame", "/\\..\\..\\etc\\passwd", "/%00", "/a" * 4000, "/etc/passwd"):
        got = server.raw(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n".encode())
        expect(f"GET {path[:40]}", got.split(b" ")[1:2] in ([b"404"], [b"400"], [b"414"]), True)
        expect("no file of the system", b"root:" in got, False)
    expect("POST to a page", server.ask("POST", "/style.css", "{}")[0], 404)
    expect("POST to an unknown place", server.ask("POST", "/passwd", "{}")[0], 404)


def ranges(server):
    """No part of a file or an answer is given, and nothing of the memory beyond it."""
    post = f"POST /start HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Mtf-Token: {server.token}\r\nContent-Length: 2\r\n".encode()
    for start, body in ((b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n", b""), (post, b"{}")):
        for part in (b"0-99999999", b"5000000-5004095", b"9223372036854775000-9223372036854775807", b"-5", b"0-1,90000-99999"):
            got = server.raw(start + b"Range: bytes=" + part + b"\r\nConnection: close\r\n\r\n" + body)
            expect(f"{start[:4]} range {part}", got.split(b" ")[1:2], ([b"416"], [b"400"]))
            expect("no more than the words", len(got) < 1200, True)


def files_by_edits(server, folder):
    """No edit makes the server open a file: not as a curve, a map, a table or an encoding."""
    trap = folder / "trap.csv"
    trap.write_text("wavelength_um,value\n3,0.1\n5,0.1\n")
    before = trap.stat().st_atime_ns
    os.utime(trap, ns=(1, trap.stat().st_mtime_ns))
    for name in ("detector.quantum_efficiency", "optics.transmission", "path.transmission", "path.table", "scene.encoding",
                 "scene.aperture_file", "nonuniformity.responsivity", "nonuniformity.offset", "scene.emissivity"):
        for value in (str(trap), "../" + str(trap), f'"{trap}"', f'{{ 1 = 0.3, "t\\u0061ble" = "{trap}" }}'):
            status, data, _ = server.ask("POST", "/model", json.dumps({"edits": [["set", name, value]]}))
            expect(f"{name} = {value}", status, 422)
            expect("what is in it is not told", b"wavelength_um" in data, False)
    status, data, _ = server.ask("POST", "/model", json.dumps({"edits": [["add", "presample", "curve"]]}))
    expect("a component that needs a file", status, 422)
    expect("the file was not read", trap.stat().st_atime_ns, (1, before) if before == 1 else 1)
    for edit in (["set", "jitter.rms", '2 um"\n[path]\ntable = "' + str(trap)], ["set", "jitter.rms", "2 um\x00"]):
        expect("line breaks in a value", server.ask("POST", "/model", json.dumps({"edits": [edit]}))[0], 422)
    expect("a name with a path", server.ask("POST", "/model", json.dumps({"edits": [["add", "../presample", "jitter"]]}))[0], 422)


def bodies(server):
    wrong = (b"", b"{", b"[]", b"null", b"\xff\xfe", b'{"edits": 3}', b'{"edits": [[1, 2]]}', b'{"edits": [["set", "jitter.rms"]]}',
             b'{"edits": [["burn", "x", "y"]]}', b'{"edits": [["set", "no.such", "1"]]}', b'{"number": -1}', b'{"number": 1e99}',
             b'{"every": 0}', b'{"tolerance": 7}', b'{"tolerance": "x"}', b'{"stage": "nowhere"}', b'{"tab": 3}',
             b"[" * 30000, b'{"a":' * 10000, b'{"edits": [' + b'["set","jitter.rms","2 um"],' * 2000)
    for body in wrong:
        for place in ("frame", "model"):
            expect(f"{place}: {body[:30]!r}", server.ask("POST", "/" + place, body)[0], (200, 400, 422))
    for place in ("frame", "figures", "value", "file", "scene"):
        expect(f"{place} of a list", server.ask("POST", "/" + place, b"[]")[0], 400)
    expect("65537 bytes", server.ask("POST", "/frame", b" " * 65537)[0], 413)
    start = f"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Mtf-Token: {server.token}\r\n".encode()
    status = lambda got: got.split(b" ")[1:2]
    expect("a length beyond all", status(server.raw(start + b"Content-Length: 99999999999999999999\r\n\r\n")), [b"413"])
    expect("a length that is none", status(server.raw(start + b"Content-Length: -5\r\n\r\n")), ([b"411"], [b"400"]))
    expect("two lengths", status(server.raw(start + b"Content-Length: 2\r\nContent-Length: 9\r\n\r\n{}")), ([b"411"], [b"400"]))
    expect("chunks", status(server.raw(start + b"Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n")), [b"411"])
    expect("no length", status(server.raw(start + b"\r\n")), [b"411"])
    for junk in (b"\x00" * 2000, b"GET\r\n\r\n", b"POST / HTTP/9.9\r\n\r\n", b"\r\n" * 5000, os.urandom(3000), b"A" * 70000):
        got = server.raw(junk, 1.0)
        expect(f"junk {junk[:12]!r}", got == b"" or got.split(b" ")[1:2] in ([b"400"], [b"414"], [b"421"], [b"404"]), True)


SCENE = """schema = 1
[place]
latitude = "40 deg"
longitude = "0 deg"
altitude = "0 m"
[time]
start = 2026-06-21T12:00:00Z
end = 2026-06-21T14:00:00Z
step = "1 h"
[weather]
air_temperature = "288 K"
wind_speed = "2 m/s"
direct_normal = "700 W/m2"
diffuse_horizontal = "80 W/m2"
longwave_down = "320 W/m2"
vapour_pressure = "10 hPa"
[[mesh]]
name = "plate"
file = "plate.obj"
[[region]]
mesh = "plate"
temperature = "300 K"
[camera]
position = ["0 m", "-30 m", "9 m"]
look_at = ["0 m", "0 m", "0 m"]
"""
CAMERA = """schema = 1
[frame]
focal_length = "20 mm"
pitch = "12 um"
format = [64, 48]
[optics]
f_number = 1.2
stop_temperature = "293 K"
[band]
wavelength = ["8 um", "12 um"]
[[presample]]
kind = "diffraction"
[detector]
kind = "thermal"
absorptance = 0.8
responsivity = 1e5
shutter_temperature = "293 K"
nep = "5 pW"
"""


def places(folder):
    """Camera and time of a 3-D scene: what is no number, or none of this world, is refused by name; none of it names a file."""
    for name, text in (("scene.toml", SCENE), ("camera.toml", CAMERA), ("plate.obj", "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n")):
        (folder / name).write_text(text)
    server = Server("--stay", str(folder / "scene.toml"), str(folder / "camera.toml"))
    try:
        expect("the camera of the start", server.ask("POST", "/frame", "{}")[0], 200)  # waits for the scene, as start does not
        begin = json.loads(server.ask("POST", "/start", "{}")[1])["space"]["begin_s"]
        good = '{"position": [3, -30, 9], "look_at": [0, 0, 0], "utc_s": %r, "may_lag": true, "preview": true, "before": true, "side": "left"}' % begin
        expect("another camera", server.ask("POST", "/frame", good)[0], 200)
        points = ("[NaN, 0, 0]", "[1e999, 0, 0]", "[1e308, 0, 0]", "[-1e7, 0, 0]", "[0, 0]", "[0, 0, 0, 0]", "[]", "3", "true", '"../x"', '["1", "2", "3"]',
                  "[null, 0, 0]", '{"x": 1}', "[[1], 2, 3]", "[" * 9000)
        for key in ("position", "look_at"):
            for point in points:
                status, data, _ = server.ask("POST", "/frame", '{"%s": %s}' % (key, point))
                expect(f"{key} {point[:20]}", status, (400, 422))
                expect(f"{key} {point[:20]} is named", status == 400 or key.encode() in data, True)
        for time_s in ("NaN", "1e308", "-1e308", '"2026-06-21"', "[]", "true", str(begin - 10), str(begin + 8000)):
            expect(f"utc_s {time_s}", server.ask("POST", "/frame", '{"utc_s": %s}' % time_s)[0], (400, 422))
        shown = server.ask("POST", "/frame", good)[1]
        preview = json.loads(shown[4:4 + int.from_bytes(shown[:4], "little")])
        expect("a file of a preview", server.ask("POST", "/file", json.dumps({"id": preview["id"], "format": "exr"}))[0], 422)
        for key in ("preview", "may_lag", "before"):
            expect(f"{key} as a number", server.ask("POST", "/frame", '{"%s": 1}' % key)[0], 422)
        expect("a side that is none", server.ask("POST", "/frame", '{"side": 3}')[0], 422)
        expect("its own position", server.ask("POST", "/frame", '{"position": [0, 0, 0]}')[0], 422)
        expect("below the ground", server.ask("POST", "/frame", '{"position": [0, 3, -5]}')[0], 422)
        expect("nothing to see", server.ask("POST", "/frame", '{"look_at": [0, -60, 90]}')[0], 422)
        expect("the scene's file", b"[camera]" in server.ask("POST", "/scenefile", good)[1], True)
        expect("the scene's file there", server.ask("POST", "/scenefile", '{"position": ["\\"]\\n[x]", 0, 0]}')[0], 422)
        expect("the scene of a 3-D scene", server.ask("POST", "/scene", "{}")[0], 422)
        expect("still a frame", server.ask("POST", "/frame", good)[0], 200)
    finally:
        expect("Ctrl-C of a 3-D scene", server.end(), 0)


def many_connections(server):
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    peers = []
    for i in range(1000):
        try:
            peer = socket.create_connection(("127.0.0.1", server.port), timeout=5)
        except OSError:
            break
        if i % 2:
            peer.sendall(b"POST /frame HTTP/1.1\r\nHost: 127.0.0.1\r\n")  # and no more
        peers.append(peer)
    expect("connections", len(peers) >= 990, True)
    begin = time.monotonic()
    # Descriptors may have run out for a moment: the server then takes the next one once others have timed out.
    expect("a page among 1000 connections", server.ask("POST", "/start", "{}")[0], 200)
    waited = time.monotonic() - begin
    expect("within its patience", waited < 12.0, True)
    for peer in peers:
        peer.close()
    return waited


class Dripping(threading.Thread):
    """A client that stays connected and sends a byte every half second: `seconds` until it is shown the door."""

    def __init__(self, server):
        super().__init__(daemon=True)
        self.peer = socket.create_connection(("127.0.0.1", server.port), timeout=5)
        self.seconds = None
        self.start()

    def run(self):
        begin, text = time.monotonic(), b"POST /start HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Note: " + b"x" * 200
        try:
            for i in range(len(text)):
                self.peer.sendall(text[i:i + 1])
                self.peer.settimeout(0.5)
                try:
                    if not self.peer.recv(1):
                        break
                except TimeoutError:
                    pass
        except OSError:
            pass
        self.seconds = time.monotonic() - begin


def threads_end(server, usual):
    for _ in range(100):
        if server.threads() <= usual + 8:  # those of pictures
            break
        time.sleep(0.1)
    expect("threads that went with their connections", server.threads() <= usual + 8, True)


def slow_readers(server):
    body = b'{"edits": []}'
    head = (f"POST /scene HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Mtf-Token: {server.token}\r\nContent-Length: {len(body)}\r\n\r\n").encode()
    peers = []
    for _ in range(12):
        peer = socket.socket()
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        peer.connect(("127.0.0.1", server.port))
        peer.sendall(head + body)
        peers.append(peer)
    begin = time.monotonic()
    expect("a frame beside slow readers", server.ask("POST", "/frame", body)[0], 200)
    expect("without waiting for them", time.monotonic() - begin < 6.0, True)
    for peer in peers:
        peer.close()


def main():
    server = Server("--stay")
    try:
        tokens_hosts_origins(server)
        expect("a frame", server.ask("POST", "/frame", '{"edits": []}')[0], 200)
        usual, dripping = server.threads(), Dripping(server)
        first = server.memory_mib()
        paths(server)
        ranges(server)
        with tempfile.TemporaryDirectory() as folder:
            files_by_edits(server, Path(folder))
        bodies(server)
        waited = many_connections(server)
        threads_end(server, usual)
        slow_readers(server)
        dripping.join(60.0)  # its text takes 100 s
        expect("a request in drops ends", dripping.seconds is not None and 8.0 < dripping.seconds, True)
        expect("still the same frame", server.ask("POST", "/frame", '{"edits": []}')[0], 200)
        grown = server.memory_mib() - first
        expect("memory", grown < 150.0, True)
        print(f"1000 connections: another one was answered after {waited:.2f} s; memory grew by {grown:.0f} MiB")
        expect("the port is taken", subprocess.run([MTF, "live", "--no-browser", "--port", str(server.port)],
                                                   capture_output=True).returncode, 1)
        Dripping(server)
        time.sleep(1.0)
    finally:
        begin = time.monotonic()
        expect("Ctrl-C", server.end(), 0)
        expect("an end that waits for no client", time.monotonic() - begin < 8.0, True)  # a client has ten seconds
    with tempfile.TemporaryDirectory() as folder:
        places(Path(folder))
    server = Server("--linger", "1")
    begin = time.monotonic()
    expect("without a page it ends", server.process.wait(timeout=20), 0)
    expect("after the time given", 0.5 < time.monotonic() - begin, True)
    print("\n".join(BAD))
    return 1 if BAD else 0


if __name__ == "__main__":
    sys.exit(main())
