"""B2 of the residue beads of BPTI (5PTI, bundled) with our integrator and with duello's, for the same beads, charges and potential.

    python tests/validation/duello_b2.py OUTPUT [--protomer PATH]

Needs gemmi and duello 0.7 (both on PyPI) in the environment of this Python. Beads sit at the centres of the heavy atoms;
lysine and arginine carry +1 e, aspartate and glutamate -1 e. Some minutes on two cores, nearly all of them duello's.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

import gemmi

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


def beads(structure):
    """Name, centre and number of each residue of the first chain."""
    found = []
    for residue in gemmi.read_structure(str(structure))[0][0].get_polymer():
        atoms = [atom.pos for atom in residue if not atom.is_hydrogen() and atom.altloc in ("\0", "A")]
        centre = [sum(getattr(place, axis) for place in atoms) / len(atoms) for axis in "xyz"]
        found.append((residue.name, centre, residue.seqid.num))
    return found


def write_inputs(found, output):
    lines = [f"{len(found)}", "residue beads"]
    lines += [f"{name} {x:.3f} {y:.3f} {z:.3f}" for name, (x, y, z), _ in found]
    (output / "beads.xyz").write_text("\n".join(lines) + "\n")
    row = "ATOM  %5d  CA  %3s A%4d    %8.3f%8.3f%8.3f %8.4f %7.4f\n"
    rows = [row % (i + 1, name, number, *at, CHARGES_E.get(name, 0.0), 3.0) for i, (name, at, number) in enumerate(found)]
    (output / "beads.pqr").write_text("".join(rows))
    atoms = [
        f"  - {{name: {name}, charge: {CHARGES_E.get(name, 0.0)}, mass: 100.0, hydrophobicity: !Lambda {stickiness}, "
        f"σ: {diameter}, ε: {EPSILON_KJ_PER_MOL}}}"
        for name, (stickiness, diameter) in CALVADOS.items()
    ]
    energy = [
        "system:",
        "  energy:",
        "    - !Nonbonded",
        "      default:",
        "        - !AshbaughHatch {mixing: arithmetic, cutoff: 20.0}",
    ]
    (output / "topology.yaml").write_text("\n".join(["atoms:", *atoms, *energy]) + "\n")


def theirs(output, salt):
    duello = Path(sys.executable).parent / "duello"
    command = [duello, "scan", "-1", "beads.xyz", "-2", "beads.xyz", "-a", "topology.yaml", "-M", str(salt)]
    command += ["--rmin", "14", "--rmax", "70", "--dr", "0.5", "--max-ndiv", "1", "--cutoff", "1000"]
    done = subprocess.run(list(map(str, command)), cwd=output, capture_output=True, text=True)
    found = re.search(r"Second virial coefficient,.*= (-?[\d.]+) ", done.stdout + done.stderr)
    if found is None:
        raise SystemExit(done.stdout + done.stderr)
    return float(found.group(1))


def ours(output, protomer, salt):
    subprocess.run([protomer, "ingest", "beads.pqr", "-o", ".", "-q", "--force"], cwd=output, check=True)
    command = [protomer, "pair", "beads.body", "--core", "beads", "--contacts", "calvados3", "--salt", f"{salt}M"]
    command += ["--relative-error", "0.01", "--json", "-q"]
    done = subprocess.run(command, cwd=output, capture_output=True, text=True, check=True)
    condition = json.loads(done.stdout)["conditions"][0]
    return condition["b2_angstrom3"], condition["b2_error_angstrom3"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--protomer", default="target/release/protomer")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    root = Path(__file__).resolve().parents[2]
    write_inputs(beads(root / "data/structures/5pti.cif.gz"), arguments.output)
    for salt in (0.1, 0.5):
        value, error = ours(arguments.output, str(Path(arguments.protomer).resolve()), salt)
        print(f"{salt} M: {value:.0f} ± {error:.0f} Å³ here, {theirs(arguments.output, salt):.0f} Å³ duello", flush=True)


if __name__ == "__main__":
    main()
