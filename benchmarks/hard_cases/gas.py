"""Gas dynamics that cases are measured against: ideal gas, steady or plane."""
import math


def shock_ratio(mach, gamma):
    """Density and pressure ratio across a normal shock."""
    m2 = mach * mach
    return ((gamma + 1) * m2 / ((gamma - 1) * m2 + 2),
            1 + 2 * gamma / (gamma + 1) * (m2 - 1))


def pitot_ratio(mach, gamma):
    """Stagnation pressure behind a normal shock over the free stream's
    pressure (Rayleigh)."""
    g, m2 = gamma, mach * mach
    return ((g + 1) / 2 * m2)**(g / (g - 1)) * (
        (2 * g * m2 - (g - 1)) / (g + 1))**(-1 / (g - 1))


def oblique_shock(mach, angle, gamma):
    """Weak shock of a wedge: (shock angle, density ratio, pressure ratio).

    angle: of the wedge, radians. ValueError: the shock is detached.
    """
    def deflection(beta):
        m2 = mach * mach
        return math.atan(2 / math.tan(beta) * (m2 * math.sin(beta)**2 - 1) /
                         (m2 * (gamma + math.cos(2 * beta)) + 2))

    low = math.asin(1 / mach)
    steps = [low + (math.pi / 2 - low) * k / 2000 for k in range(2001)]
    high = max(steps, key=deflection)
    if deflection(high) < angle:
        raise ValueError("the shock is detached")
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if deflection(middle) < angle else (
            low, middle)
    density, pressure = shock_ratio(mach * math.sin(low), gamma)
    return low, density, pressure


def _prandtl_meyer(mach, gamma):
    root = math.sqrt((gamma + 1) / (gamma - 1))
    m = math.sqrt(mach * mach - 1)
    return root * math.atan(m / root) - math.atan(m)


def expansion(mach, angle, gamma):
    """Around a corner: (Mach number, density ratio, pressure ratio).

    angle: of the turn, radians.
    """
    wanted = _prandtl_meyer(mach, gamma) + angle
    low, high = mach, 1e4
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _prandtl_meyer(
            middle, gamma) < wanted else (low, middle)
    ratio = (1 + (gamma - 1) / 2 * mach**2) / (1 + (gamma - 1) / 2 * low**2)
    return low, ratio**(1 / (gamma - 1)), ratio**(gamma / (gamma - 1))


def billig_sphere(mach):
    """Stand-off of a sphere's shock over its radius (Billig 1967), air."""
    return 0.143 * math.exp(3.24 / mach**2)


def riemann_speeds(left, right, gamma):
    """Slowest and fastest wave of a Riemann problem; vacuum may form.

    left, right: (density, velocity, pressure). Toro 2009, chapter 4.
    """
    g = gamma
    (rl, ul, pl), (rr, ur, pr) = left, right
    cl, cr = math.sqrt(g * pl / rl), math.sqrt(g * pr / rr)
    if ur - ul >= 2 * (cl + cr) / (g - 1):
        return ul - cl, ur + cr  # heads of two rarefactions

    def jump(p, rho, p0, c):
        if p > p0:
            return (p - p0) * math.sqrt(
                2 / ((g + 1) * rho) / (p + (g - 1) / (g + 1) * p0))
        return 2 * c / (g - 1) * ((p / p0)**((g - 1) / (2 * g)) - 1)

    def total(p):
        return jump(p, rl, pl, cl) + jump(p, rr, pr, cr) + ur - ul

    low, high = 1e-300, max(pl, pr)
    while total(high) < 0:
        high *= 10
    for _ in range(1200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if total(middle) < 0 else (low, middle)

    def head(p0, c):
        p = math.sqrt(low * high)
        return c * math.sqrt(max(
            1, (g + 1) / (2 * g) * p / p0 + (g - 1) / (2 * g)))

    return ul - head(pl, cl), ur + head(pr, cr)
