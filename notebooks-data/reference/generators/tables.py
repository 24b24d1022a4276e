# SPDX-License-Identifier: Apache-2.0
"""What the generators of the reference tables share: exact doubles, digits, files, quadrature."""

import math
from functools import lru_cache
from pathlib import Path

from mpmath import mp, mpf

FOLDER = Path(__file__).resolve().parent.parent


def hex_of(x):
    """The double in the notation of C's %a, which strtod reads back exactly."""
    return float(x).hex()


def digits(x, count=30):
    """`count` significant digits; exact zeros as 0."""
    return "0" if x == 0 else mp.nstr(x, count, strip_zeros=True, min_fixed=-5, max_fixed=5)


def neighbours(x):
    """The double nearest to x and the ones on both sides."""
    x = float(x)
    return [math.nextafter(x, -math.inf), x, math.nextafter(x, math.inf)]


def write_table(name, header, rows, folder=None):
    """Rows of strings as CSV; `folder` instead of the reference folder when the tables are only compared."""
    lines = [",".join(header)] + [",".join(row) for row in rows]
    (Path(folder or FOLDER) / name).write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


@lru_cache(maxsize=None)
def gauss_legendre(n, digits_kept):
    """Nodes and weights on [-1, 1] by Newton's method on P_n."""
    with mp.workdps(digits_kept + 10):
        rule = []
        for k in range(1, n + 1):
            x = mp.cos(mp.pi * (k - mpf(1) / 4) / (n + mpf(1) / 2))
            for _ in range(100):
                p0, p1 = mpf(1), x
                for j in range(2, n + 1):
                    p0, p1 = p1, ((2 * j - 1) * x * p1 - (j - 1) * p0) / j
                slope = n * (x * p1 - p0) / (x * x - 1)
                step = p1 / slope
                x -= step
                if abs(step) < mpf(10) ** (-digits_kept):
                    break
            rule.append((x, 2 / ((1 - x * x) * slope * slope)))
        return rule


def integrate(functions, lo, hi, phase):
    """Integrals of an entire vector-valued function over [lo, hi] where its phase runs through about `phase` radians.

    48 nodes on panels of at most 16 rad leave J_96(8) of the oscillation, below 1e-90.
    """
    if hi == lo:
        return None
    panels = int(mp.ceil(phase / 16)) + 1
    width = (hi - lo) / panels
    total = None
    for panel in range(panels):
        middle = lo + (panel + mpf(1) / 2) * width
        for x, weight in gauss_legendre(48, mp.dps):
            values = functions(middle + x * width / 2)
            scaled = [weight * v for v in values]
            total = scaled if total is None else [t + s for t, s in zip(total, scaled)]
    return [t * width / 2 for t in total]
