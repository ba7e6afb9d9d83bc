"""Fit of the titration model to measured pKa values, with cross-validation by family of proteins.

    cargo run --release -p protomer-field --example titration_terms -- FOLDER/*.pdb.gz > terms.jsonl
    python tests/validation/fit_titration.py terms.jsonl measured.csv

measured.csv has the columns of tests/validation/measured_pka.py. Fitted are the factors of desolvation (linear and
quadratic) and of pairs, and the pKa value in water of each kind of group, with a normal prior of 0.3 units about the values
of PROPKA 3. The factor of the background is 1. The fit minimises the sum of squared errors and twice the number of errors
above one unit, counted smoothly. Needs numpy and scipy.
"""

import csv
import json
import math
import random
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

LN10 = math.log(10)
PH = np.arange(-2, 16.01, 0.5)
KINDS = ["ASP", "GLU", "HIS", "LYS", "TYR", "CYS", "N-term", "C-term"]
START = np.array([0.4, 0.27, 0.5] + [0.3, 0.0, 0.4, 0.0, 0.3, -1.0, 0.0, 0.2])
PRIOR, TYPICAL_ERROR, COUNT_WEIGHT, COUNT_WIDTH = 0.3, 0.8, 2.0, 0.12
NEIGHBOURS, FOLDS, SEED = 4, 5, 1
# Entries of one protein or of close relatives; others are families of one.
FAMILIES = [
    "135l 1lse 2lzt 4lzt 1lz3 6lyz 1lz1",
    "1a2p 1b2x 1bni 1bnr 1fw7",
    "1lni 1rgg",
    "1ert 1trw 3trx",
    "1kf3 3rn3 7rsa",
    "1a6k 1a6m 1duk 1ymb",
    "4hhb 1hho",
    "9rnt 1bvi",
    "1hv1 1xnb",
    "1gb1 1pga 2gb1 2qmt 3gb1 1igc 2igh",
    "1beg 1beo",
    "1ig5 1igv 3icb",
    "1pnt 1z12",
    "4pti 1d0d",
    "1egf 1epg 1eph 3egf",
    "1ppn 1ppo",
    "1bus 2bus",
    "1ex3 2tga",
]


def kind(group):
    if group["kind"] in ("NTerminus", "CTerminus"):
        return "N-term" if group["kind"] == "NTerminus" else "C-term"
    return {"HIE": "HIS", "HID": "HIS", "HIP": "HIS"}.get(group["name"], group["name"])


def read_terms(path):
    proteins = {}
    for line in path.open():
        terms = json.loads(line)
        count = len(terms["groups"])
        kinds = [kind(group) for group in terms["groups"]]
        proteins[Path(terms["file"]).name.split(".")[0]] = {
            "kinds": kinds,
            "keys": [(g["chain"], str(g["number"]), k) for g, k in zip(terms["groups"], kinds)],
            "charge": np.array([group["charge"] for group in terms["groups"]]),
            "model": np.array([group["model"] for group in terms["groups"]]),
            "histidine": np.array([name == "HIS" for name in kinds])[:, None],
            "desolvation": np.array(terms["desolvation"]),
            "background": np.array(terms["background"]),
            "tautomer": np.array(terms["tautomer"])[:, None],
            "pair": np.array(terms["pair"]).reshape(count, count),
            "tautomer_pair": np.array(terms["tautomer_pair"]).reshape(count, count),
        }
    return proteins


def read_measured(path, proteins):
    """(entry, index of the group, pKa, kind, exposed share) of each value."""
    values = []
    for row in csv.DictReader(path.open(newline="")):
        key = (row["chain"], row["residue_number"], row["residue"])
        if key in proteins[row["entry"]]["keys"]:
            index = proteins[row["entry"]]["keys"].index(key)
            values.append((row["entry"], index, float(row["pka"]), row["residue"], float(row["exposed_percent"])))
    return values


def pka_values(protein, numbers):
    """pKa of each group: exact over its strongest neighbours, mean field of the rest, as the program does."""
    linear, quadratic, scale = numbers[:3]
    shifts = dict(zip(KINDS, numbers[3:]))
    model = protein["model"] + np.array([shifts.get(name, 0.0) for name in protein["kinds"]])
    charge, desolvation = protein["charge"], protein["desolvation"]
    energy = linear * desolvation + quadratic * np.maximum(desolvation, 0) ** 2 + protein["background"]
    alone = charge[:, None] * LN10 * (PH - model[:, None]) + energy[:, None]
    pair, tautomer_pair = scale * protein["pair"], scale * protein["tautomer_pair"]
    count = len(charge)
    neighbours = min(NEIGHBOURS, count - 1)
    nearest = np.argsort(-np.abs(pair), axis=1)[:, :neighbours]
    clusters = np.concatenate([np.arange(count)[:, None], nearest], axis=1)
    states = ((np.arange(2 ** (neighbours + 1))[:, None] >> np.arange(neighbours + 1)) & 1).astype(float)
    within = np.stack([pair[np.ix_(members, members)] for members in clusters])
    pair_energy = 0.5 * np.einsum("sa,nab,sb->ns", states, within, states)[:, :, None]
    shares = 1 / (1 + np.exp(np.clip(alone, -60, 60)))
    for _ in range(25):
        half = np.clip(protein["tautomer"] + tautomer_pair @ shares, -30, 30)
        neutral = np.where(protein["histidine"], -np.log(0.2 * np.exp(-half) + 0.8 * np.exp(half)), 0.0)
        field = pair @ shares
        local = (alone - neutral)[clusters] + field[clusters] - np.einsum("nab,nbp->nap", within, shares[clusters])
        total = np.einsum("sa,nap->nsp", states, local) + pair_energy
        weights = np.exp(total.min(axis=1, keepdims=True) - total)
        means = (weights * states[None, :, :1]).sum(axis=1) / weights.sum(axis=1)
        change = np.abs(means - shares).max()
        shares = 0.5 * (shares + means)
        if change < 2e-3:
            break
    return [half_protonation(share, sign > 0) for share, sign in zip(shares, charge)]


def half_protonation(charged, is_base):
    odds = np.log(np.maximum(charged, 1e-12) / np.maximum(1 - charged, 1e-12)) * (1 if is_base else -1)
    falls = np.where((odds[:-1] >= 0) & (odds[1:] < 0))[0]
    if len(falls) == 0:
        return PH[-1] if odds[-1] >= 0 else PH[0]
    step = falls[0] if is_base else falls[-1]
    return PH[step] + (PH[1] - PH[0]) * odds[step] / (odds[step] - odds[step + 1])


def errors(proteins, values, numbers):
    computed = {entry: pka_values(proteins[entry], numbers) for entry in {value[0] for value in values}}
    return np.array([computed[entry][index] - pka for entry, index, pka, *_ in values])


def fit(proteins, values, start=START):
    def residuals(numbers):
        off = errors(proteins, values, numbers)
        above_one = COUNT_WEIGHT / (1 + np.exp((1 - np.abs(off)) / COUNT_WIDTH))
        return np.concatenate([off, above_one, numbers[3:] / PRIOR * TYPICAL_ERROR])

    return least_squares(residuals, start, diff_step=0.03, max_nfev=8).x


def show(name, values, off):
    def figures(chosen):
        part = off[chosen]
        return f"{math.sqrt((part**2).mean()):.2f} ({(np.abs(part) > 1).mean():.0%})" if len(part) else "-"

    cells = [figures(np.arange(len(off)))]
    cells += [figures(np.array([value[3] == name for value in values])) for name in KINDS]
    exposed = np.array([value[4] for value in values])
    cells += [figures(exposed < 20), figures(exposed >= 20)]
    print(f"| {name} | " + " | ".join(cells) + " |")


def main():
    proteins = read_terms(Path(sys.argv[1]))
    values = read_measured(Path(sys.argv[2]), proteins)
    numbers = fit(proteins, values)
    print(f"{len(values)} values; factors {np.round(numbers[:3], 3)}; shifts of the values in water:")
    print({name: round(float(shift), 2) for name, shift in zip(KINDS, numbers[3:])})
    print("\n| RMSD (off by more than one unit) | all | " + " | ".join(KINDS) + " | buried | exposed |")
    print("|---" * (len(KINDS) + 4) + "|")
    show("fit", values, errors(proteins, values, numbers))
    family = {entry: line for line in FAMILIES for entry in line.split()}
    names = sorted({family.get(value[0], value[0]) for value in values})
    random.Random(SEED).shuffle(names)
    fold = {name: index % FOLDS for index, name in enumerate(names)}
    off = np.zeros(len(values))
    for left_out in range(FOLDS):
        outside = [fold[family.get(value[0], value[0])] == left_out for value in values]
        part = fit(proteins, [value for value, out in zip(values, outside) if not out], numbers)
        print(f"fold {left_out}: factors {np.round(part[:3], 2)}", file=sys.stderr)
        off[outside] = errors(proteins, [value for value, out in zip(values, outside) if out], part)
    show("family left out", values, off)
    in_water = np.array([proteins[entry]["model"][index] - pka for entry, index, pka, *_ in values])
    show("values in water", values, in_water)


if __name__ == "__main__":
    main()
