#!/usr/bin/env python3
"""Poroelastic relaxation of a half-space under a frictionless indenter, from integral equations: where the numbers of
`profiles.rs` come from. Needs numpy and scipy.

Biot's equations with incompressible constituents, shear modulus G = 1, diffusivity D = 1, contact radius 1. In Hankel (xi) and
Laplace (s) space let q^2 = xi^2 + s/D, M = lambda + 2 G, Delta = M/(2 G) - xi (q - xi) D/s. A pressure P of the indenter and a
pore pressure p0 of the surface, both 0 beside the contact, give

    deflection  u = P M / (4 G^2 xi Delta) - p0 (q - xi) D / (2 G s Delta)
    outflow     f = p0 (xi + (q - xi) M / (2 G Delta)) - P (q - xi) M / (2 G Delta)

Within the contact u is the indenter's, and f = 0 (sealed) or p0 = 0 (drained). Galerkin with functions whose transforms are
spherical Bessel functions, j_2n for P and j_(2n+1) / xi for p0; inversion in time by Stehfest's formula. The contact radius of the sphere is
kept at sqrt(R d), where both limits have it.
"""

from math import factorial, log

import numpy as np
from scipy.special import spherical_jn

TERMS = 10  # 6 and 14 give the same five digits
TIMES = [0.03, 0.1, 0.3, 1.0, 3.0]


def quadrature(end, panels, order=8):
    x, w = np.polynomial.legendre.leggauss(order)
    half = end / panels / 2
    centres = (2 * np.arange(panels) + 1) * half
    return (centres[:, None] + half * x).ravel(), np.tile(half * w, panels)


XI, WEIGHTS = quadrature(600.0, 600)
EVEN = np.array([(-1) ** n * spherical_jn(2 * n, XI) for n in range(TERMS)])
ODD = np.array([spherical_jn(2 * n + 1, XI) / XI for n in range(TERMS)])


def galerkin(kernel, left, right):
    return (left * (WEIGHTS * XI * kernel)) @ right.T


def force(s, nu, profile, sealed):
    """Laplace transform of the force after a step of depth 1 (flat) or of a sphere with R d = 1."""
    m = 2 * (1 - nu) / (1 - 2 * nu)
    dq = s / (np.sqrt(XI**2 + s) + XI)
    delta = m / 2 - XI * dq / s
    # What the kernels tend to for large xi is integrated exactly: the functions are orthogonal there.
    orthogonal = lambda first: np.diag([np.pi / (2 * (4 * n + first)) for n in range(TERMS)])
    system = galerkin(m / (4 * XI * delta) - (1 - nu) / XI, EVEN, EVEN) + (1 - nu) * orthogonal(1)
    if sealed:
        coupling = galerkin(-dq / (2 * s * delta), EVEN, ODD)
        flow = (galerkin(dq * m / (2 * delta), ODD, ODD) + orthogonal(3)) / (m * s)
        system = np.block([[system, coupling], [coupling.T, flow]])
    right = np.zeros(len(system))
    right[0] = 1.0
    if profile == "sphere":  # deflection 1 - r^2 / 2
        right[:2] -= [1 / 3, 2 / 15]
    return 2 * np.pi * np.linalg.solve(system, right / s)[0]


def stehfest(transform, time, terms=12):
    half = terms // 2
    total = 0.0
    for i in range(1, terms + 1):
        weight = sum(
            k**half * factorial(2 * k)
            / (factorial(half - k) * factorial(k) * factorial(k - 1) * factorial(i - k) * factorial(2 * k - i))
            for k in range((i + 1) // 2, min(i, half) + 1)
        )
        total += (-1) ** (half + i) * weight * transform(i * log(2) / time)
    return total * log(2) / time


if __name__ == "__main__":
    nu = 0.2
    print("(F - F_inf) / (F_0 - F_inf) at D t / a^2 =", TIMES)
    for profile, first in (("flat", 8.0), ("sphere", 16.0 / 3.0)):
        last = first / (2 * (1 - nu))
        for sealed in (True, False):
            curve = [stehfest(lambda s: force(s, nu, profile, sealed), t) for t in TIMES]
            values = [f"{(f - last) / (first - last):.4f}" for f in curve]
            print(f"{profile:7} {'sealed' if sealed else 'drained':8}", *values)
