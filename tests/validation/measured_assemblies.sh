#!/usr/bin/env bash
# Assemblies whose equilibria are measured, by `stability`: the tables of docs/validation/natural-complexes.md.
#
#     bash tests/validation/measured_assemblies.sh STRUCTURES OUTPUT
#
# STRUCTURES holds the entries 1A8O, 1B0O, 1HHO, 4E43, 4HHB and 7AZ6 (protomer fetch), as lower-case .pdb.gz or .cif.gz. Takes
# about forty minutes of processor time.
set -euo pipefail
protomer=${PROTOMER:-target/release/protomer}
structures=$1
mkdir -p "$2"
run() {
    local entry=$1
    shift
    local file
    file=$(ls "$structures/$entry".*.gz | head -1)
    "$protomer" stability "$file" "$@" --force -q -o "$output/$entry"
    echo "== $entry"
    cut -d, -f1-6 "$output/$entry/stability.csv"
    cut -d, -f1-3,6,7,10 "$output/$entry/parts.csv"
}
output=$2
run 1a8o --assembly 1 --salt 50mM,150mM,500mM
run 1b0o --assembly 1 --salt 20mM,100mM,500mM --ph 3,5.3,7 --concentration 10uM
run 7az6 --assembly 1 --salt 50mM,150mM,500mM
run 4e43 --chain A,B --salt 50mM,150mM,500mM
run 4hhb --salt 50mM,150mM,500mM
run 1hho --assembly 1 --salt 50mM,100mM,500mM --ph 6,7.4,8.5
