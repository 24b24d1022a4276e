#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The band law tau = exp(-(C W (P/P0)^n (T0/T)^m)^a) fitted to tables of transmittance, for atmosphere.py.

With y = ln(-ln tau) the law is linear: y = a ln W + a n ln(P/P0) + a m ln(T0/T) + c, where c = a ln C belongs to one
wavenumber and (a, a n, a m) to a band of many. Each value has the weight of its rounding: dy = dtau / |tau ln tau|. c is
eliminated from the normal equations of a wavenumber; what is left, (H, g, s), sums over the wavenumbers of a band, whose
least chi^2 is s - g H^-1 g. Borders of bands are those of the least chi^2 + PENALTY x bands (dynamic programming); bands
whose union costs less than PENALTY more are made one, next to each other or not.
"""

import numpy as np

ROUNDING = 3e-7   # standard deviation of a printed transmittance: six decimals
PENALTY = 80.0    # chi^2 that another band has to save
P0_HPA, T0_K = 1013.25, 296.0
COLUMN = 1e20     # molecules per cm^2: the unit of W


def design(conditions):
    """ln W, ln(P/P0), ln(T0/T) of each condition: (pressure in hPa, temperature in K, column in cm^-2)."""
    p, t, w = np.array(conditions).T
    return np.stack([np.log(w / COLUMN), np.log(p / P0_HPA), np.log(T0_K / t)], 1)


def weights(tau):
    used = (tau > 2e-6) & (tau < 1 - 2e-6)
    inside = np.where(used, tau, 0.5)
    return np.where(used, np.abs(inside * np.log(inside)) / ROUNDING, 0.0) ** 2, np.log(-np.log(inside))


def normal_equations(x, tau):
    """H, g, s of every row of tau, the constant eliminated."""
    w, y = weights(tau)
    total = np.maximum(w.sum(1), 1e-30)
    mean_x, mean_y = w @ x / total[:, None], (w * y).sum(1) / total
    dx = x[None] - mean_x[:, None]
    dy = y - mean_y[:, None]
    h = np.einsum("ik,ikp,ikq->ipq", w, dx, dx)
    g = np.einsum("ik,ikp,ik->ip", w, dx, dy)
    return h, g, (w * dy * dy).sum(1)


def solve(h, g):
    """Least squares with a weak prior, a = an = 0.6 and am = 0 with a standard deviation of 1e3."""
    prior = np.array([0.6, 0.6, 0.0])
    ridge = 1e-6 * np.eye(3)
    return np.linalg.solve(h + ridge, (g + 1e-6 * prior)[..., None])[..., 0]


def cost(h, g, s):
    p = solve(h, g)
    return s - 2 * (p * g).sum(-1) + np.einsum("...p,...pq,...q->...", p, h, p)


def borders(h, g, s):
    """First rows of the runs with the least chi^2 + PENALTY x runs."""
    n = len(s)
    sums = [np.concatenate([np.zeros((1,) + v.shape[1:]), np.cumsum(v, 0)]) for v in (h, g, s)]
    best, start = np.zeros(n + 1), np.zeros(n + 1, int)
    for end in range(1, n + 1):
        total = best[:end] + PENALTY + cost(*(v[end] - v[:end] for v in sums))
        start[end] = int(np.argmin(total))
        best[end] = total[start[end]]
    firsts, end = [], n
    while end > 0:
        end = start[end]
        firsts.append(end)
    return firsts[::-1]


def bands(x, tau):
    """Number of the band of each row."""
    h, g, s = normal_equations(x, tau)
    firsts = borders(h, g, s)
    runs = [np.arange(a, b) for a, b in zip(firsts, firsts[1:] + [len(s)])]
    while len(runs) > 1:
        sums = [[v[r].sum(0) for v in (h, g, s)] for r in runs]
        alone = [cost(*v) for v in sums]
        more = {(i, j): cost(*(a + b for a, b in zip(sums[i], sums[j]))) - alone[i] - alone[j]
                for i in range(len(runs)) for j in range(i)}
        i, j = min(more, key=more.get)
        if more[i, j] > PENALTY:
            break
        runs[j] = np.sort(np.concatenate([runs[j], runs[i]]))
        del runs[i]
    runs.sort(key=lambda r: r[0])
    band = np.empty(len(s), int)
    for k, run in enumerate(runs):
        band[run] = k
    return band


def fit(conditions, tau, fixed=None):
    """Band of each row; a, n, m of each band, rounded to five decimals; ln C of each row (C per 1e20 molecules/cm^2).
    With `fixed` = (a, n, m) there is one band of these."""
    x = design(conditions)
    if fixed:
        band, laws = np.zeros(len(tau), int), np.array([fixed], float)
    else:
        band = bands(x, tau)
        h, g, _ = normal_equations(x, tau)
        p = np.array([solve(h[band == k].sum(0), g[band == k].sum(0)) for k in range(band.max() + 1)])
        laws = np.round(np.stack([p[:, 0], p[:, 1] / p[:, 0], p[:, 2] / p[:, 0]], 1), 5)
    a, n, m = laws[band].T
    slope = np.stack([a, a * n, a * m], 1)
    w, y = weights(tau)
    total = w.sum(1)
    c = (w * (y - slope @ x.T)).sum(1) / np.maximum(total, 1e-30)
    return band, laws, np.where(total > 0, c / a, np.nan)


def transmittance(law, log_c, conditions):
    """The law at the conditions, a row per wavenumber."""
    x = design(conditions)
    a, n, m = law.T
    return np.exp(-np.exp(a[:, None] * log_c[:, None] + np.stack([a, a * n, a * m], 1) @ x.T))
