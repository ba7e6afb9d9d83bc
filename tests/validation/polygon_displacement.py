"""Equation 5.4 and figure 5.3 of chapter 5: is the displacement of polygons that of the theory, and do eqs. 5.7 and 5.8 follow?

    python tests/validation/polygon_displacement.py RUNS [FIGURE]

RUNS is the output of polygon_dynamics.py: all shapes at 0.68 and pentagons at all densities, or what is there of them. Three forms are
fitted to the logarithm of the mean squared displacement, from the first frame to half of the run, in the units of the run:

* eq. 5.4 as printed (ξ, γ; B3 = ⟨v²⟩ of the run, or free);
* its repaired reading: with h(t) = exp(-ξt)(exp(-ξt) + t/(ξ²e²) + 2/ξ²) and b = 2ξ + 2/ξ - 1/(ξ²e²) = -h'(0),
  M(t) = ({√2 B3 γ²/ξ² + √2 ξ/b (h(t) - h(0))}² - 2 B3² γ⁴/ξ⁴)/(4γ²) + B3 t/ξ, for which M(0) = M'(0) = 0;
* the plain Langevin equation, 2 B3/ξ² (ξt - 1 + exp(-ξt)), with B3 = ⟨v²⟩.

The last columns are the ratio of eqs. 5.7 and 5.8 with the ξ and γ of the printed form and that of the page.
"""

import sys
from pathlib import Path

import numpy as np
from polygon_relaxation import coefficients, measured, times
from scipy.optimize import minimize

from protomer.dynamics import Seeds, local_slope

NOTHING = 50.0


def shape_of_decay(t: np.ndarray, xi: float) -> np.ndarray:
    return np.exp(-xi * t) * (np.exp(-xi * t) + t / (xi**2 * np.e**2) + 2.0 / xi**2)


def printed(t: np.ndarray, xi: float, gamma: float, b3: float) -> np.ndarray:
    b1, b2 = coefficients(np.float64(xi), np.float64(gamma), b3)
    return (b1 + b2 * shape_of_decay(t, xi)) ** 2 / (4.0 * gamma**2) + b3 / xi * t + 0.5 * b3**2 * gamma**2 / xi**4


def repaired(t: np.ndarray, xi: float, gamma: float, b3: float) -> np.ndarray:
    start = 1.0 + 2.0 / xi**2
    bracket = 2.0 * xi + 2.0 / xi - 1.0 / (xi**2 * np.e**2)
    first = np.sqrt(2.0) * b3 * gamma**2 / xi**2
    inner = first + np.sqrt(2.0) * xi / bracket * (shape_of_decay(t, xi) - start)
    return (inner**2 - first**2) / (4.0 * gamma**2) + b3 / xi * t


def langevin(t: np.ndarray, xi: float, b3: float) -> np.ndarray:
    return 2.0 * b3 / xi**2 * (xi * t - 1.0 + np.exp(-xi * t))


def misfit(logarithms: np.ndarray, form: object, t: np.ndarray, squares: np.ndarray, fixed: tuple) -> float:
    with np.errstate(all="ignore"):
        theory = form(t, *np.exp(logarithms), *fixed)
        difference = np.where(np.isfinite(theory) & (theory > 0.0), np.log(theory / squares), NOTHING)
    return float(np.sqrt(np.mean(np.minimum(np.abs(difference), NOTHING) ** 2)))


def fit(form: object, t: np.ndarray, squares: np.ndarray, constants: int, *fixed: float) -> tuple[np.ndarray, float]:
    """The constants, all positive, of the least root mean square of the logarithm's difference, from many starts."""
    rng = np.random.default_rng(3)
    starts = rng.uniform(-4.0, 6.0, size=(4000, constants))
    values = np.array([misfit(start, form, t, squares, fixed) for start in starts])
    best = (starts[0], np.inf)
    for start in starts[np.argsort(values)[:20]]:
        found = minimize(misfit, start, (form, t, squares, fixed), method="Nelder-Mead", options={"maxiter": 4000, "fatol": 1e-10})
        if found.fun < best[1]:
            best = (found.x, float(found.fun))
    return np.exp(best[0]), best[1]


def row(shape: str, density: float, runs: list[Path], ratio: float) -> dict:
    seeds = Seeds(runs)
    t, squares, _ = seeds.curve("displacement")
    kept = np.unique(np.geomspace(1, len(t) // 2, 40).astype(int))
    speed = float(np.mean([np.mean(np.sum(motion.velocities[..., :2] ** 2, axis=-1)) for motion in seeds.motions]))
    t, squares = t[kept], squares[kept]
    of_printed, rms = fit(printed, t, squares, 2, speed)
    free, rms_free = fit(printed, t, squares, 3)
    _, rms_repaired = fit(repaired, t, squares, 2, speed)
    free_repaired, rms_free_repaired = fit(repaired, t, squares, 3)
    _, rms_langevin = fit(langevin, t, squares, 1, speed)
    trans, rot = times(*of_printed, speed)
    fine = np.geomspace(t[0], t[-1], 400)
    least = [np.min(local_slope(fine, values)[1]) for values in (printed(fine, *free), repaired(fine, *free_repaired))]
    words = " | ".join([
        f"{rms_langevin:.3f}", f"{rms:.3f}", f"{rms_free:.3f}", f"{rms_repaired:.3f}", f"{rms_free_repaired:.3f}",
        f"{printed(np.zeros(1), *free)[0] / squares[0]:.2f}", f"{np.min(seeds.curve('slope')[1]):.2f}", f"{least[0]:.2f}", f"{least[1]:.2f}",
        "{:.3g}, {:.3g}, {:.3g}".format(free_repaired[0], free_repaired[1], free_repaired[2] / speed),
        f"{of_printed[0]:.3g}, {of_printed[1]:.3g}", f"{float(trans):.3g}", f"{float(rot):.3g}", f"{float(trans / rot):.3g}", f"{ratio:.3f}",
    ])
    print(f"| {shape} | {density} | {words} |", flush=True)
    return {"shape": shape, "density": density, "t": t, "squares": squares, "printed": printed(t, *free), "repaired": repaired(t, *free_repaired)}


def main() -> None:
    runs, of_page = Path(sys.argv[1]), measured()
    print("| shape | packing | Langevin: rms of ln | eq. 5.4 | B3 free | repaired | B3 free | M(0)/M(first frame) | least slope, measured | eq. 5.4 | repaired | ξ, γ, B3/⟨v²⟩ of the repaired form | ξ, γ of eq. 5.4 | τ_trans | τ_rot | ratio | measured |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    panels = [[(f"polygon{n}", 0.68) for n in range(3, 10)], [("polygon5", density) for density in sorted(of_page)]]
    drawn = []
    for panel in panels:
        found = []
        for shape, density in panel:
            here = sorted(runs.glob(f"{shape}_{density}_*"))
            if here and not any(shape == of["shape"] and density == of["density"] for of in found):
                found.append(row(shape, density, here, of_page[density].get(int(shape[-1]), np.nan)))
        drawn.append(found)
    if len(sys.argv) > 2:
        draw(drawn, Path(sys.argv[2]))


def draw(panels: list, path: Path) -> None:
    """Figure 5.3: measured displacements as points, both forms as lines, each curve a factor of three above the one before."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    for ax, panel, title in zip(axes, panels, ("packing fraction 0.68", "pentagons"), strict=True):
        colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(panel)))
        for number, (colour, found) in enumerate(zip(colours, panel, strict=True)):
            shift = 3.0**number
            label = f"n = {found['shape'][-1]}" if title != "pentagons" else f"{found['density']}"
            ax.loglog(found["t"], shift * found["squares"], "o", markersize=3, color=colour, label=label)
            ax.loglog(found["t"], shift * found["printed"], "--", linewidth=1, color=colour)
            ax.loglog(found["t"], shift * found["repaired"], "-", linewidth=0.8, color=colour)
        ax.set_title(title)
        ax.set_xlabel("time")
        ax.set_ylabel("mean squared displacement, shifted")
        ax.legend(fontsize="small")
    figure.savefig(path, dpi=100)


if __name__ == "__main__":
    main()
