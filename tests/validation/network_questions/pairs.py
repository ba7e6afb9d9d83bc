"""Small chains and their charge mutants: B2 of two copies, and the moments of their charges."""

import json
import math
import random
import time

import numpy as np

from entries import chains, residues_of
from plan import LEAST_RESIDUES, MOST_RESIDUES_OF_PAIRS, PH, REVERSALS, REVERSED, SALT, protomer, write


def mutations(pqr, name):
    """Some charged residues, drawn at random, get the opposite charge."""
    charged = [(chain, number, letter) for chain, number, letter in residues_of(pqr) if letter in REVERSED]
    # A number with an insertion code is left alone.
    charged = [residue for residue in charged if residue[1].lstrip("-").isdigit()]
    drawn = random.Random(f"mutant of {name}").sample(charged, min(REVERSALS, len(charged)))
    return ",".join(f"{chain}:{letter}{number}{REVERSED[letter]}" for chain, number, letter in drawn)


def chains_of_pairs(output):
    """One small chain of each cluster, the first by name, in random order, so that any first part is a fair sample."""
    chosen = {}
    for row in chains(output):
        if LEAST_RESIDUES <= len(row["sequence"]) <= MOST_RESIDUES_OF_PAIRS:
            chosen.setdefault(row["cluster"], row)
    rows = sorted(chosen.values(), key=lambda row: row["name"])
    random.Random(1).shuffle(rows)
    return rows


def moments(pqr):
    """Net charge (e), dipole about the centroid (e Å), traceless quadrupole (e Å²), radius of gyration (Å)."""
    atoms = [line.split()[6:10] for line in pqr.read_text().splitlines() if line.startswith("ATOM")]
    values = np.array(atoms, float)
    r, q = values[:, :3] - values[:, :3].mean(axis=0), values[:, 3]
    second = 3 * np.einsum("i,ij,ik->jk", q, r, r) - np.eye(3) * (q * (r**2).sum(axis=1)).sum()
    return {
        "charge": q.sum(),
        "dipole": np.linalg.norm(q @ r),
        "quadrupole": np.linalg.norm(second) / 3,
        "radius": math.sqrt((r**2).sum(axis=1).mean()),
    }


def stage_pairs(structures, output, minutes):
    end = time.monotonic() + 60 * minutes
    for row in chains_of_pairs(output):
        for kind in ("wild", "mutant"):
            name = f"{row['name']}-{kind}"
            result = output / "pairs" / f"{name}.json"
            if result.exists():
                continue
            if time.monotonic() > end:
                raise SystemExit("the time for pairs is over; the same command continues")
            changes = mutations(output / "chains" / f"{row['name']}.pqr", row["name"]) if kind == "mutant" else ""
            protomer(
                *("ingest", structures / row["file"], "-o", output / "pairs", "--name", name, "--chain", row["chain"]),
                *("--ph", PH, "--charges", "formal", "--export", "pqr", "-q", "--force"),
                *(("--mutate", changes) if changes else ()),
            )
            body = output / "pairs" / f"{name}.body"
            done, cpu = protomer("pair", body, "--salt", SALT, "--relative-error", "0.02", "--no-cache", "--json", "-q")
            known = json.loads(done.stdout)["conditions"][0]
            values = {key: known[key] for key in known if key.startswith(("b2_", "b22_"))}
            written = {"name": name, "cluster": row["cluster"], "residues": len(row["sequence"]), "mutations": changes}
            written |= {"pair_cpu_s": cpu, **values, **moments(output / "pairs" / f"{name}.pqr")}
            write(result, json.dumps(written, indent=1))
            print(name, f"{known['b2_angstrom3'] / known['b2_hard_angstrom3']:.3f}", f"{cpu:.1f} s", flush=True)
