"""B2 of residue beads with our integrator and with duello's, for the same beads, charges and potential.

    python tests/validation/duello_b2.py OUTPUT [--protomer PATH]
    python tests/validation/duello_b2.py OUTPUT --structure 2cds.pdb.gz --ph 4.5 --temperature 293.15 --range 24 80 1

Needs gemmi and duello 0.7 (both on PyPI) in the environment of this Python. By default BPTI (5PTI, bundled): beads at the
centres of the heavy atoms, +1 e on lysine and arginine, -1 e on aspartate and glutamate. With --structure and --ph the
beads and the charges are those of duello's converter, pdb2xyz: centres of mass and charges of that pH, also at both ends of
the chain (https://files.rcsb.org/download/2CDS.pdb.gz). Some minutes on two cores, nearly all of them duello's.

python/checks/test_pair_duello.py does the same for a few residues.
"""

import argparse
import gzip
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

BIN = Path(sys.executable).parent
CHARGES_E = {"LYS": 1.0, "ARG": 1.0, "ASP": -1.0, "GLU": -1.0}
EPSILON_KJ_PER_MOL = 0.8368
# Stickiness and diameter (Å) of Calvados 3: Cao et al., Protein Sci. 33, e5172 (2024).
CALVADOS = {
    "ARG": (0.7407902764839954, 6.56), "ASP": (0.092587557536158, 5.58), "ASN": (0.3706962163690402, 5.68),
    "GLU": (0.000249590539426, 5.92), "LYS": (0.1380602542039267, 6.36), "HIS": (0.4087176216525476, 6.08),
    "GLN": (0.3143449791669133, 6.02), "SER": (0.4473142572693176, 5.18), "CYS": (0.5922529084601322, 5.48),
    "GLY": (0.7538308115197386, 4.50), "THR": (0.2672387936544146, 5.62), "ALA": (0.3377244362031627, 5.04),
    "MET": (0.5170874160398543, 6.18), "TYR": (0.950628687301107, 6.46), "VAL": (0.2936174211771383, 5.86),
    "TRP": (1.033450123574512, 6.78), "LEU": (0.5548615312993875, 6.18), "ILE": (0.5130398874425708, 6.18),
    "PRO": (0.3469777523519372, 5.56), "PHE": (0.8906449355499866, 6.36),
}  # fmt: skip


class Scan(NamedTuple):
    """The grid of duello: distances of the centres (Å), and how often the faces of an icosahedron are divided."""

    least: float = 14.0
    most: float = 70.0
    step: float = 0.5
    divisions: int = 1


def beads(structure):
    """Name, centre and number of each residue of the first chain."""
    import gemmi

    found = []
    for residue in gemmi.read_structure(str(structure))[0][0].get_polymer():
        atoms = [atom.pos for atom in residue if not atom.is_hydrogen() and atom.altloc in ("\0", "A")]
        centre = [sum(getattr(place, axis) for place in atoms) / len(atoms) for axis in "xyz"]
        found.append((residue.name, centre, residue.seqid.num))
    return found


def write_inputs(found, output):
    """Beads of formal charges, for both programs."""
    lines = [f"{len(found)}", "residue beads"]
    lines += [f"{name} {x:.3f} {y:.3f} {z:.3f}" for name, (x, y, z), _ in found]
    (output / "beads.xyz").write_text("\n".join(lines) + "\n")
    write_pqr([(name, number, at, CHARGES_E.get(name, 0.0)) for name, at, number in found], output)
    atoms = [
        f"  - {{name: {name}, charge: {CHARGES_E.get(name, 0.0)}, mass: 100.0, hydrophobicity: !Lambda {stickiness}, "
        f"σ: {diameter}, ε: {EPSILON_KJ_PER_MOL}}}"
        for name, (stickiness, diameter) in CALVADOS.items()
    ]
    write_topology(atoms, output)


def write_topology(atoms, output):
    energy = [
        "system:",
        "  energy:",
        "    - !Nonbonded",
        "      default:",
        "        - !AshbaughHatch {mixing: arithmetic, cutoff: 20.0}",
    ]
    (output / "topology.yaml").write_text("\n".join(["atoms:", *atoms, *energy]) + "\n")


def convert(structure, ph, output):
    """Beads of duello's own converter, for both programs."""
    text = structure.read_bytes()
    (output / "structure.pdb").write_bytes(gzip.decompress(text) if structure.suffix == ".gz" else text)
    command = [BIN / "pdb2xyz", "-i", "structure.pdb", "-o", "beads.xyz", "-t", "topology.yaml", "--pH", ph]
    subprocess.run(list(map(str, command)), cwd=output, capture_output=True, check=True)
    # duello 0.7 refuses other keys of this file.
    atoms = [line for line in (output / "topology.yaml").read_text().splitlines() if line.startswith("  - {")]
    write_topology(atoms, output)
    fields = (re.search(r"charge: (\S+), .*name: (\w+),", line).groups() for line in atoms)
    charges = {name: float(charge) for charge, name in fields}
    rows = [line.split() for line in (output / "beads.xyz").read_text().splitlines()[2:]]
    # Cysteines in bridges have their own name. The ends of the chain, NTR and CTR, have a charge in addition to the bead of
    # their residue; to us they are charges only, to duello also repulsive balls of 2 Å.
    names = [("CYS" if row[0] == "CSS" else row[0]) for row in rows]
    beads = [(name, n + 1, list(map(float, row[1:])), charges[row[0]]) for n, (name, row) in enumerate(zip(names, rows))]
    write_pqr(beads, output)


def write_pqr(beads, output):
    row = "ATOM  %5d  CA  %3s A%4d    %8.3f%8.3f%8.3f %8.4f %7.4f\n"
    rows = [row % (n + 1, name, number, *at, charge, 3.0) for n, (name, number, at, charge) in enumerate(beads)]
    (output / "beads.pqr").write_text("".join(rows))


def theirs(output, salt, scan=Scan(), temperature=298.15, short_range=1000.0):
    """B2 (Å³) and the relative permittivity of duello."""
    command = [BIN / "duello", "scan", "-1", "beads.xyz", "-2", "beads.xyz", "-a", "topology.yaml", "-M", salt]
    command += ["-T", temperature, "--rmin", scan.least, "--rmax", scan.most, "--dr", scan.step]
    command += ["--max-ndiv", scan.divisions, "--cutoff", 1000, "--sr-cutoff", short_range, "--backend", "simd"]
    done = subprocess.run(list(map(str, command)), cwd=output, capture_output=True, text=True)
    text = done.stdout + done.stderr
    found = re.search(r"Second virial coefficient,.*= (-?[\d.]+) ", text)
    permittivity = re.search(r"εᵣ = ([\d.]+)", text)
    if found is None or permittivity is None:
        raise SystemExit(text)
    return float(found.group(1)), float(permittivity.group(1))


def ours(output, protomer, salt, permittivity, temperature=298.15, relative_error=0.01):
    """B2 (Å³) and its standard error in the same medium."""
    subprocess.run([protomer, "ingest", "beads.pqr", "-o", ".", "-q", "--force"], cwd=output, check=True)
    command = [protomer, "pair", "beads.body", "--core", "beads", "--contacts", "calvados3", "--salt", f"{salt}M"]
    command += ["--temperature", f"{temperature}K", "--permittivity", permittivity]
    command += ["--relative-error", relative_error, "--json", "-q"]
    done = subprocess.run(list(map(str, command)), cwd=output, capture_output=True, text=True, check=True)
    condition = json.loads(done.stdout)["conditions"][0]
    return condition["b2_angstrom3"], condition["b2_error_angstrom3"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", default="target/release/protomer")
    parser.add_argument("--structure", type=Path, help="a PDB file, with --ph")
    parser.add_argument("--ph", type=float)
    parser.add_argument("--temperature", type=float, default=298.15, help="K")
    parser.add_argument("--range", type=float, nargs=3, default=Scan()[:3], help="least and largest distance, step (Å)")
    parser.add_argument("--divisions", type=int, default=1)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    if (arguments.structure is None) != (arguments.ph is None):
        parser.error("--structure and --ph belong together")
    if arguments.structure is not None:
        convert(arguments.structure, arguments.ph, arguments.output)
    else:
        root = Path(__file__).resolve().parents[2]
        write_inputs(beads(root / "data/structures/5pti.cif.gz"), arguments.output)
    scan = Scan(*arguments.range, arguments.divisions)
    for salt in (0.1, 0.5):
        their_value, permittivity = theirs(arguments.output, salt, scan, arguments.temperature, short_range=20.0)
        protomer = str(Path(arguments.protomer).resolve())
        value, error = ours(arguments.output, protomer, salt, permittivity, arguments.temperature)
        print(f"{salt} M: {value:.0f} ± {error:.0f} Å³ here, {their_value:.0f} Å³ duello", flush=True)


if __name__ == "__main__":
    main()
