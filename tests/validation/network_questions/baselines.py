"""Regressions on numbers that need no network."""

import math

import numpy as np
import zarr
from plan import FOLDS
from scipy.optimize import minimize


def softmax(z):
    shifted = np.exp(z - z.max(axis=1, keepdims=True))
    return shifted / shifted.sum(axis=1, keepdims=True)


def logistic(x, y, classes, new):
    """Probabilities of the classes at `new`, by a logistic regression on standardised features with a unit penalty."""
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-12
    x, new = ((part - middle) / spread for part in (x, new))
    truth = np.eye(classes)[y]

    def loss(w):
        w = w.reshape(-1, classes)
        p = softmax(x @ w[1:] + w[0])
        error = p - truth
        slope = np.vstack([error.sum(axis=0), x.T @ error + w[1:]])
        return -np.log(p[np.arange(len(y)), y] + 1e-300).sum() + (w[1:] ** 2).sum() / 2, slope.ravel()

    w = minimize(loss, np.zeros((x.shape[1] + 1) * classes), jac=True, method="L-BFGS-B").x.reshape(-1, classes)
    return softmax(new @ w[1:] + w[0])


def linear(x, y, new):
    """Numbers at `new`, by a linear regression on standardised features with a unit penalty."""
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-12
    x, new = ((part - middle) / spread for part in (x, new))
    slope = np.linalg.solve(x.T @ x + np.eye(x.shape[1]), x.T @ (y - y.mean()))
    return y.mean() + new @ slope


def surface_summaries(folder):
    """A few numbers of the voxels: of the hydropathy mean, deviation and ninth decile; of the potential magnitude of the mean,
    its square, deviation, and the logarithm of the number of voxels; by the name of the sample."""
    known = {}
    for held in range(FOLDS):
        group = zarr.open_group(folder / f"fold-{held}.zarr", mode="r")
        offsets = group["offsets"][:]
        hydropathy, potential = (group[name][:].astype(float) for name in ("hydropathy", "potential"))
        for i, name in enumerate(group.attrs["samples"]["name"]):
            h, v = (values[offsets[i] : offsets[i + 1]] for values in (hydropathy, potential))
            known[name] = {
                "surface hydropathy": [h.mean(), h.std(), np.quantile(h, 0.9)],
                "mean potential": [v.mean()],
                "surface potential": [abs(v.mean()), v.mean() ** 2, v.std(), math.log(len(v))],
            }
    return known


def features(task, samples, summaries):
    """What each baseline knows of each sample."""

    def of(kind, sample):
        q, n = abs(sample["charge"]), math.log(sample["residues"])
        known = {
            "net charge": [q, q * q],
            "size": [n, sample["radius"]],
            "dipole": [sample["dipole"], sample["dipole"] ** 2 / sample["radius"] ** 2],
            "quadrupole": [sample["quadrupole"], sample["quadrupole"] ** 2 / sample["radius"] ** 4],
            "signed charge": [sample["charge"]],
            **summaries[sample["name"]],
            "composition": sample.get("composition", []),
        }
        return [value for word in kind.split(", ") for value in known[word]]

    kinds = [
        "net charge",
        "size",
        "surface potential",
        "net charge, size",
        "net charge, size, dipole",
        "net charge, size, dipole, quadrupole",
    ]
    if task == "oligomer":
        kinds = ["size", "net charge, signed charge", "surface hydropathy", "composition"]
        kinds.append("size, net charge, signed charge, surface hydropathy")
    return {kind: np.array([of(kind, sample) for sample in samples]) for kind in kinds}
