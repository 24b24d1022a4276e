#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Layers as a renderer such as Blender writes them, of a scene that is known in closed form: a warm ball on a plane.

  make_layers.py OUT.exr [--width 640] [--height 512] [--step 1.6e-4] [--position 0,-40,6] [--look-at 0,0,1]

Channels of the view layer `ViewLayer`: Depth.Z (distance along the optical axis, m), IndexMA.X (material index: 1 plane, 2 ball,
0 nothing), Normal.X|Y|Z (axes of the scene), and temperature.X (K; 0 where only the material says it: the plane). The ball has a
radius of 1 m, stands at the origin, and is warm above and cold below. Needs nothing beside Python.
"""

import argparse
import math
import struct

RADIUS, PLANE = 1.0, 20.0  # m; the plane reaches so far from the origin along x and y
SKY_INDEX, PLANE_INDEX, BALL_INDEX = 0.0, 1.0, 2.0
BLENDER_FAR = 1e10  # depth of what is not there


def unit(v):
    size = math.sqrt(sum(x * x for x in v))
    return [x / size for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def surface(origin, d):
    """Length along d, index, normal and temperature of the first surface; d has the length 1 along the optical axis."""
    centre = (0.0, 0.0, RADIUS)
    o = [a - b for a, b in zip(origin, centre)]
    dd, od, oo = sum(x * x for x in d), sum(a * b for a, b in zip(o, d)), sum(x * x for x in o)
    root = od * od - dd * (oo - RADIUS * RADIUS)
    if root > 0.0:
        t = (-od - math.sqrt(root)) / dd
        normal = [(a + t * b) / RADIUS for a, b in zip(o, d)]
        return t, BALL_INDEX, normal, 300.0 + 15.0 * normal[2]
    if d[2] < 0.0:
        t = -origin[2] / d[2]
        if max(abs(origin[0] + t * d[0]), abs(origin[1] + t * d[1])) < PLANE:
            return t, PLANE_INDEX, [0.0, 0.0, 1.0], 0.0
    return BLENDER_FAR, SKY_INDEX, [0.0, 0.0, 0.0], 0.0


def layers(width, height, step, position, look_at):
    ahead = unit([a - b for a, b in zip(look_at, position)])
    right = unit(cross(ahead, [0.0, 0.0, 1.0]))
    down = cross(ahead, right)
    names = ["Depth.Z", "IndexMA.X", "Normal.X", "Normal.Y", "Normal.Z", "temperature.X"]
    rows = []
    for y in range(height):
        v = (y + 0.5 - 0.5 * height) * step
        row = {name: [] for name in names}
        for x in range(width):
            u = (x + 0.5 - 0.5 * width) * step
            d = [a + u * r + v * w for a, r, w in zip(ahead, right, down)]
            depth, index, normal, kelvin = surface(position, d)
            for name, value in zip(names, [depth, index, *normal, kelvin]):
                row[name].append(value)
        rows.append({"ViewLayer." + name: values for name, values in row.items()})
    return rows


def write_exr(path, rows):
    """OpenEXR 2, scanlines, float, not compressed (openexr.com, "OpenEXR File Layout")."""
    height, names = len(rows), sorted(rows[0])
    width = len(rows[0][names[0]])

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(n.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = (b"\x76\x2f\x31\x01" + struct.pack("<i", 2) + attribute("channels", "chlist", channels)
              + attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", box)
              + attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0")
              + attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
              + attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0))
              + attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0")
    block = 8 + 4 * width * len(names)
    first = len(header) + 8 * height
    with open(path, "wb") as file:
        file.write(header)
        file.write(struct.pack(f"<{height}Q", *(first + y * block for y in range(height))))
        for y, row in enumerate(rows):
            file.write(struct.pack("<ii", y, 4 * width * len(names)))
            for name in names:
                file.write(struct.pack(f"<{width}f", *row[name]))


def point(text):
    return [float(number) for number in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--width", type=int, default=640)
    parser.add_argument("--height", type=int, default=512)
    parser.add_argument("--step", type=float, default=1.6e-4, help="tangent between neighbours")
    parser.add_argument("--position", type=point, default=[0.0, -40.0, 6.0])
    parser.add_argument("--look-at", type=point, default=[0.0, 0.0, 1.0])
    a = parser.parse_args()
    write_exr(a.out, layers(a.width, a.height, a.step, a.position, a.look_at))


if __name__ == "__main__":
    main()
