"""Measured and computed isoelectric points of proteins.

    python tests/validation/isoelectric_points.py FOLDER... [--protomer PATH] [--salt 10mM]

The FOLDERs hold structures by the name of their entry, such as 1epg.pdb.gz; proteins without one are named and left out. Runs
`protomer titrate` for each protein, and prints the table of the page: the measured point, that of titrate, and the null model,
every group with its model pKa value in water. Sources of the measured points: docs/validation/measured-pka.md.
"""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ACIDS = {"ASP", "GLU", "CYS", "TYR", "C-term"}
NEAR = 0.5


class Protein(NamedTuple):
    """A protein with its measured point."""

    name: str
    entry: str
    chains: str
    measured: float
    source: str
    keeps_ligands: bool = False


# Metals and haem that belong to the protein are kept; inhibitors, substrates and additives are not.
PROTEINS = [
    Protein("epidermal growth factor, mouse", "1epg", "A", 4.6, "PIP-DB"),
    Protein("azurin, P. aeruginosa", "5azu", "A", 5.6, "PIP-DB", True),
    Protein("3α-hydroxysteroid dehydrogenase, rat", "1afs", "A", 5.9, "PIP-DB"),
    Protein("pyrophosphatase, yeast (D117E)", "117e", "A,B", 5.0, "PIP-DB"),
    Protein("procarboxypeptidase A2, human", "1aye", "A", 5.1, "PIP-DB", True),
    Protein("AmpC β-lactamase, E. coli", "3bls", "A", 5.4, "PIP-DB"),
    Protein("phosphotriesterase, B. diminuta", "1dpm", "A,B", 7.4, "PIP-DB"),
    Protein("xylanase, B. circulans", "1xnb", "A", 8.8, "PIP-DB"),
    Protein("chymotrypsinogen A, bovine", "1ex3", "A", 9.6, "PIP-DB"),
    Protein("adrenodoxin reductase, bovine", "1e6e_receptor_unbound", "A", 5.4, "PIP-DB"),
    Protein("progelatinase (MMP-2), human", "1gxd_receptor_bound", "A", 5.64, "PIP-DB"),
    Protein("carboxypeptidase B, human", "1zli_receptor_bound", "A", 6.6, "PIP-DB"),
    Protein("β-glucosidase 1, A. aculeatus", "4iid", "A", 4.9, "PIP-DB"),
    Protein("lysozyme, hen", "4lzt", "A", 10.7, "JECFA"),
    Protein("ribonuclease Sa", "1rgg", "A", 3.5, "Shaw"),
    Protein("cytochrome c551, P. aeruginosa", "451c", "A", 4.7, "crystals", True),
    Protein("cytochrome c, horse", "1hrc", "A", 9.44, "Hristova", True),
    Protein("parvalbumin, pike", "2pvb", "A", 4.10, "2PVB", True),
    Protein("interleukin-1β, human", "1iob", "A", 6.9, "Kikumoto"),
    Protein("fatty acid binding protein, human muscle", "2hmb", "A", 5.2, "Peeters"),
    Protein("α-lactalbumin, bovine (M90V)", "1hfz", "D", 4.6, "BoMiProt", True),
    Protein("trypsinogen, bovine", "2tga", "A", 9.3, "neotrypsinogens"),
    Protein("β-lactoglobulin, bovine", "1b0o", "A", 5.39, "Nozaki"),
]


def structure(entry, folders):
    """The file of an entry, or None."""
    for folder in folders:
        for ending in (".pdb.gz", ".cif.gz", ".pdb", ".cif"):
            path = Path(folder) / f"{entry}{ending}"
            if path.exists():
                return path
    return None


def titrated(protomer, path, protein, salt):
    """The answer of titrate; None, with its message on stderr, where it fails."""
    words = [protomer, "titrate", path, "--chain", protein.chains, "--ph", 7, "--salt", salt, "--json"]
    if protein.keeps_ligands:
        words.append("--keep-ligands")
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{protein.name}: {done.stderr.strip()}", file=sys.stderr)
        return None
    return json.loads(done.stdout)


def model_charge_e(groups, ph):
    """Net charge of independent groups with their model pKa values, e."""
    charge = 0.0
    for group in groups:
        protonated = 1 / (1 + 10 ** (ph - group["model_pka"]))
        charge += protonated - 1 if group["residue"] in ACIDS else protonated
    return charge


def model_point(groups):
    """pH at which independent groups with model pKa values have no net charge, by bisection."""
    low, high = 0.0, 14.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if model_charge_e(groups, middle) > 0 else (low, middle)
    return 0.5 * (low + high)


def summary(name, errors):
    """A line on the errors of a way to compute points."""
    near = sum(abs(error) <= NEAR for error in errors)
    root = math.sqrt(sum(error * error for error in errors) / len(errors))
    middle = sorted(map(abs, errors))[len(errors) // 2]
    return f"{name}: {near} of {len(errors)} within {NEAR}, root mean square {root:.2f}, median size {middle:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--protomer", default="target/release/protomer")
    parser.add_argument("--salt", default="10mM")
    arguments = parser.parse_args()
    errors = {"titrate": [], "model values": []}
    print("| protein | structure | measured | `titrate` | model values | source |")
    print("|---|---|---|---|---|---|")
    for protein in PROTEINS:
        path = structure(protein.entry, arguments.folders)
        if path is None:
            print(f"{protein.name}: no {protein.entry} in {', '.join(map(str, arguments.folders))}", file=sys.stderr)
            continue
        answer = titrated(arguments.protomer, path, protein, arguments.salt)
        if answer is None:
            continue
        if answer["isoelectric_point"] is None:
            print(f"{protein.name}: no isoelectric point from pH 0 to 14", file=sys.stderr)
            continue
        points = {"titrate": answer["isoelectric_point"], "model values": model_point(answer["groups"])}
        for way, point in points.items():
            errors[way].append(round(point, 1) - protein.measured)
        entry = protein.entry.split("_")[0].upper()
        print(
            f"| {protein.name} | {entry} {protein.chains} | {protein.measured:g} | {points['titrate']:.1f} "
            f"| {points['model values']:.1f} | {protein.source} |",
            flush=True,
        )
    if not errors["titrate"]:
        sys.exit("no protein of the table has a structure in the folders; name folders that hold ENTRY.pdb.gz")
    for way, found in errors.items():
        print(summary(way, found))


if __name__ == "__main__":
    main()
