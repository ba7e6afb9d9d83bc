"""Equations of state and free volumes of hard bodies against an independent program.

python tests/validation/hard_shapes.py PROTOMER equations_of_state.json OUTPUT [SWEEPS]

Runs one `protomer hpmc run` per row, and prints the table of docs/validation/hard-shapes-equations-of-state.md.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

NAMES = {"cube": "cube", "octahedron": "octahedron", "tetrahedron": "tetrahedron"}


def shape(row, output):
    """Arguments for the shape of a row, its volume and its circumradius."""
    body = row["body"]
    if body in ("sphere", "disk"):
        point = output / f"{body}.txt"
        point.write_text("0 0 0\n" if body == "sphere" else "0 0\n")
        return [str(point), "--rounding", "1"], 1.0
    if body.endswith("-gon"):
        return [f"polygon:{body.removesuffix('-gon')}"], None
    edge = {"cube": math.sqrt(3) / 2, "octahedron": math.sqrt(0.5), "tetrahedron": math.sqrt(3 / 8)}
    return [NAMES[body]], edge[body]


def main():
    program, reference, output = sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), Path(sys.argv[3])
    sweeps = sys.argv[4] if len(sys.argv) > 4 else "20000"
    output.mkdir(parents=True, exist_ok=True)
    print("| body | packing fraction | quantity | reference | protomer | difference over what is allowed |")
    print("|---|---|---|---|---|---|")
    worst = 0.0
    for row in reference["bodies_3d"] + reference["bodies_2d"]:
        name, circumradius = shape(row, output)
        kinds = row.get("depletant_free_volume", [])
        command = [program, "hpmc", "run", "--shape", *name, "--bodies", str(row["N"])]
        command += ["--packing-fraction", str(row["phi"]), "--equilibration", "4000", "--sweeps", sweeps]
        command += ["--trajectory-every", "0", "--seed", "1", "--json", "-q", "--no-progress"]
        if kinds:
            command += ["--depletants", ",".join(f"{kind['q'] * circumradius}:0" for kind in kinds)]
        if "mu_ex" in row:
            command += ["--insertions", "200"]
        command += ["-o", str(output / f"{row['body']}-{row['phi']}")]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        compared = [("Z", row["Z"], row["error"], found["compressibility_factor"], found["compressibility_factor_error"])]
        for kind, measured in zip(kinds, found.get("depletants", []), strict=True):
            mean, error = measured["free_volume_fraction"], measured["free_volume_fraction_error"]
            compared.append((f"free volume, q = {kind['q']}", kind["alpha"], kind["error"], mean, error))
        if "mu_ex" in row:
            mean, error = found["excess_chemical_potential_kt"], found["excess_chemical_potential_kt_error"]
            compared.append(("excess chemical potential", row["mu_ex"], row["mu_ex_error"], mean, error))
        for what, value, error, mean, our_error in compared:
            allowed = 3 * math.hypot(error, our_error) + 0.002 * abs(value)
            part = (mean - value) / allowed
            worst = max(worst, abs(part))
            ours = f"{mean:.5f} ± {our_error:.5f}"
            print(f"| {row['body']} | {row['phi']} | {what} | {value} ± {error} | {ours} | {part:+.2f} |", flush=True)
    print(f"\nThe largest is {worst:.2f}.")
    return worst > 1


if __name__ == "__main__":
    sys.exit(main())
