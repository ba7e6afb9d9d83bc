"""Equations 5.6 to 5.8 and figure 5.4b of chapter 5: are the ratios of relaxation times those of the theory?

    python tests/validation/polygon_relaxation.py [FIGURE]

The measured ratios are those of the table in docs/validation/polygon-dynamics.md. With ξ_p = ξ + η (α/I)^(-1/4) and
γ = γ_c (α/I)^(-1/2), I the moment of inertia of a polygon of unit area and mass, the theory says for each density

    τ_trans = W(A/(γ B2² B3 ξ_p^-2))/ξ_p,   τ_rot = W(A/((e^-2 - 2 ξ_p)(2/ξ_p - B1/B2) ξ_p^-3))/ξ_p,
    A = B1/B2 - 1 + (1/ξ_p - 1/ξ_p²)(e^-2 + 2)

with B1 and B2 of eq. 5.4, B3 = ⟨v²⟩ = 2 kT/m, and three constants ξ, η α^(-1/4) and γ_c α^(-1/2) for all polygons. They are fitted
to the logarithms of the seven ratios of a density, from many starts. The table compares the fit with one ratio for all shapes
(one constant) and with a power of I (two constants).
"""

import re
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.special import lambertw

PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation" / "polygon-dynamics.md"
SQUARE_SPEED = 2.0
CORNERS = np.arange(3, 10)
# Ratios of the logarithm that stand for "no real W".
NOTHING = 50.0


def moments(corners: np.ndarray) -> np.ndarray:
    """Moments of inertia of regular polygons of unit area and unit mass."""
    half = np.pi / corners
    square_edge = 4.0 * np.tan(half) / corners
    return square_edge / 24.0 * (1.0 + 3.0 / np.tan(half) ** 2)


def measured() -> dict[float, dict[int, float]]:
    """The ratios of the page, by density and number of corners."""
    found: dict[float, dict[int, float]] = {}
    for corners, density, ratio in re.findall(r"^\| polygon:(\d) \| ([\d.]+) \|.*\| ([\d.]+) \|$", PAGE.read_text(), re.MULTILINE):
        found.setdefault(float(density), {})[int(corners)] = float(ratio)
    return found


def coefficients(xi: np.ndarray, gamma: np.ndarray, b3: float) -> tuple[np.ndarray, np.ndarray]:
    """B1 and B2 of eq. 5.4, as printed."""
    b2 = -0.5 * xi**7 / (b3**3 * gamma**6) / (2.0 * xi + 2.0 / xi - np.exp(-2.0) / xi**2)
    return 4.0 * (b3**2 * gamma**4 / xi**4) ** 2 + b2 * (1.0 + 2.0 / gamma**2), b2


def real_w(values: np.ndarray) -> np.ndarray:
    """The principal branch of W where it is real, and not a number elsewhere."""
    values = np.where(np.abs(values) < 1e300, values, np.nan)
    return np.where(values >= -np.exp(-1.0), lambertw(values).real, np.nan)


def times(xi: np.ndarray, gamma: np.ndarray, b3: float = SQUARE_SPEED) -> tuple[np.ndarray, np.ndarray]:
    """τ_trans and τ_rot of eqs. 5.7 and 5.8; not numbers where W is not real."""
    with np.errstate(all="ignore"):
        b1, b2 = coefficients(xi, gamma, b3)
        top = b1 / b2 - 1.0 + (1.0 / xi - 1.0 / xi**2) * (np.exp(-2.0) + 2.0)
        trans = top / (gamma * b2**2 * b3 / xi**2)
        rot = top / ((np.exp(-2.0) - 2.0 * xi) * (2.0 / xi - b1 / b2) / xi**3)
        return real_w(trans) / xi, real_w(rot) / xi


def ratios(constants: np.ndarray, moment: np.ndarray) -> np.ndarray:
    xi, eta, gamma_c = constants
    trans, rot = times(xi + eta * moment**0.25, gamma_c * np.sqrt(moment))
    with np.errstate(all="ignore"):
        return np.where((trans > 0.0) & (rot > 0.0), trans / rot, np.nan)


def misfit(logarithms: np.ndarray, moment: np.ndarray, ratio: np.ndarray) -> float:
    constants = np.array([np.exp(logarithms[0]), logarithms[1], np.exp(logarithms[2])])
    theory = ratios(constants, moment)
    missing = ~np.isfinite(theory) | (theory <= 0.0)
    difference = np.where(missing, NOTHING, np.log(np.where(missing, 1.0, theory) / ratio))
    return float(np.sqrt(np.mean(difference**2)))


def fit(moment: np.ndarray, ratio: np.ndarray) -> tuple[np.ndarray, float]:
    rng = np.random.default_rng(5)
    starts = np.column_stack([rng.uniform(-3, 4, 4000), rng.uniform(-10, 10, 4000), rng.uniform(-4, 5, 4000)])
    values = np.array([misfit(start, moment, ratio) for start in starts])
    best = (starts[0], np.inf)
    for start in starts[np.argsort(values)[:40]]:
        found = minimize(misfit, start, (moment, ratio), method="Nelder-Mead", options={"maxiter": 4000, "xatol": 1e-8, "fatol": 1e-10})
        if found.fun < best[1]:
            best = (found.x, float(found.fun))
    logarithms, rms = best
    return np.array([np.exp(logarithms[0]), logarithms[1], np.exp(logarithms[2])]), rms


def main() -> None:
    curves = {}
    print("| packing | shapes | spread of the ratios (rms of ln) | power of I: exponent | rms of ln | eqs. 5.6 to 5.8: rms of ln | ξ | η α^(-1/4) | γ_c α^(-1/2) |")
    print("|---|---|---|---|---|---|---|---|---|")
    for density, by_corners in sorted(measured().items()):
        corners = np.array(sorted(by_corners))
        moment, ratio = moments(corners), np.array([by_corners[n] for n in corners])
        line = np.polyfit(np.log(moment), np.log(ratio), 1)
        of_line = np.sqrt(np.mean((np.log(ratio) - np.polyval(line, np.log(moment))) ** 2))
        constants, rms = fit(moment, ratio)
        curves[density] = (corners, ratio, ratios(constants, moment))
        words = " | ".join(f"{value:.4g}" for value in constants)
        print(f"| {density} | {len(corners)} | {np.std(np.log(ratio)):.3f} | {line[0]:.1f} | {of_line:.3f} | {rms:.3f} | {words} |", flush=True)
    if len(sys.argv) > 1:
        draw(curves, Path(sys.argv[1]))


def draw(curves: dict, path: Path) -> None:
    """Figure 5.4b: ratios against the density, theory as lines."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6, 4.4), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(CORNERS)))
    for colour, n in zip(colours, CORNERS, strict=True):
        kept = [(density, ratio[corners == n][0], theory[corners == n][0]) for density, (corners, ratio, theory) in curves.items() if n in corners]
        density, ratio, theory = np.array(kept).T
        ax.semilogy(density, ratio, "o", color=colour, markersize=4, label=f"n = {n}")
        ax.semilogy(density, theory, color=colour)
    ax.set_xlabel("packing fraction, layer counted")
    ax.set_ylabel("τ of velocities / τ of orientations")
    ax.legend(fontsize="small")
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    main()
