"""What the lattice that finds the surface changes: shells, handles and distances of meshes.

    python lattice_spacing.py PROTOMER STRUCTURES [EVERY]

Runs `protomer surface` on every EVERY-th file (8 by default) of a folder of structures, at several densities
and spacings of the lattice, and prints a table. Shells and handles are compared with those at 0.3 Å, file by
file; the distances of the mesh from the exact surface are means over the files.
"""

import json
import subprocess
import sys
from pathlib import Path

CASES = [(1, 0.3), (1, 0.2), (1, 0.4), (1, 0.5), (0.5, 0.3), (0.5, 0.5), (0.5, 0.8)]
SUFFIXES = (".pdb", ".cif", ".pdb.gz", ".cif.gz")


def surface(program: str, file: Path, density: float, spacing: float) -> dict[str, float]:
    command = [program, "surface", str(file), "--density", str(density), "--lattice-spacing", str(spacing)]
    run = subprocess.run([*command, "--json", "-j", "1"], capture_output=True, text=True, check=True)
    report = json.loads(run.stdout)
    report["outer"] = report["components"] - report["cavities"]
    return report


def main(program: str, folder: str, every: str = "8") -> None:
    files = sorted(file for file in Path(folder).iterdir() if file.name.endswith(SUFFIXES))
    files = files[int(every) - 1 :: int(every)]
    if not files:
        sys.exit(f"{folder} holds too few structures for every {every}th; give a smaller number")
    reference: list[dict[str, float]] = []
    print("| density, lattice | outer shells | walls of cavities | handles | rms distance | largest distance |")
    print("|---|---|---|---|---|---|")
    for density, spacing in CASES:
        found = [surface(program, file, density, spacing) for file in files]
        reference = reference or found
        pairs = list(zip(found, reference, strict=True))
        changed = [sum(abs(a[key] - b[key]) for a, b in pairs) for key in ("outer", "cavities", "genus")]
        rms, largest = (
            sum(one[f"mesh_{key}_distance_angstrom"] for one in found) / len(found) for key in ("rms", "largest")
        )
        cells = " | ".join(str(count) for count in changed)
        print(f"| {density}, {spacing} Å | {cells} | {rms:.3f} Å | {largest:.2f} Å |", flush=True)
    totals = [sum(one[key] for one in reference) for key in ("outer", "cavities", "genus")]
    print(f"of {totals[0]} outer shells, {totals[1]} walls of cavities and {totals[2]} handles in {len(files)} files")


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
