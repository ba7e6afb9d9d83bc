"""Deposited entries: one chain of each, its label from the biological assembly, its cluster."""

import collections
import csv
import json
import re

from plan import K_MER, LEAST_RESIDUES, ONE_LETTER, PH, SHARED_K_MERS, protomer, text_of, write


def cif_rows(text, category):
    """The rows of a category of an mmCIF file as dictionaries, whether it is a loop or single values."""
    word = r"'[^'\n]*'|\"[^\"\n]*\"|\S+"
    loop = re.search(rf"^loop_\s*\n((?:_{category}\.\S+\s*\n)+)((?:[^#\n].*\n)*)", text, re.M)
    if loop:
        names = [name.split(".")[1] for name in loop[1].split()]
        words = re.findall(word, loop[2])
        return [dict(zip(names, words[at : at + len(names)])) for at in range(0, len(words), len(names))]
    row = {name: value for name, value in re.findall(rf"^_{category}\.(\S+)[ \t]+({word})", text, re.M)}
    return [row] if row else []


def assembly_labels(text, is_cif):
    """What each deposited assembly says: monomer or oligomer, the author's word before the program's."""
    if is_cif:
        counts = [row.get("oligomeric_count", "?") for row in cif_rows(text, "pdbx_struct_assembly")]
        return ["monomer" if count == "1" else "oligomer" for count in counts if count.isdigit()]
    labels = []
    for part in re.split(r"^REMARK 350 BIOMOLECULE:", text, flags=re.M)[1:]:
        said = re.search(r"AUTHOR DETERMINED BIOLOGICAL UNIT: *(\S+)", part) or re.search(
            r"SOFTWARE DETERMINED QUATERNARY STRUCTURE: *(\S+)", part
        )
        if said:
            labels.append("monomer" if said[1].startswith("MONOMER") else "oligomer")
    return labels


def first_chain(text, is_cif):
    """The name of the first chain with enough amino acids."""
    residues = collections.defaultdict(set)
    if is_cif:
        names = [line.split(".")[1].strip() for line in re.findall(r"^_atom_site\.\S+", text, re.M)]
        name, chain, number = (names.index(key) for key in ("label_comp_id", "auth_asym_id", "auth_seq_id"))
        for line in text.splitlines():
            if line.startswith("ATOM "):
                words = line.split()
                if words[name] in ONE_LETTER:
                    residues[words[chain]].add(words[number])
    else:
        for line in text.split("\nENDMDL")[0].splitlines():
            if line.startswith("ATOM") and line[17:20] in ONE_LETTER and line[21] != " ":
                residues[line[21]].add(line[22:27])
    return next((chain for chain, known in residues.items() if len(known) >= LEAST_RESIDUES), None)


def residues_of(pqr):
    """The amino acids of a PQR file in order: chain, number, name."""
    known = {}
    for line in pqr.read_text().splitlines():
        words = line.split()
        if words and words[0] == "ATOM" and words[3] in ONE_LETTER:
            known.setdefault((words[4], words[5]), ONE_LETTER[words[3]])
    return [(chain, number, name) for (chain, number), name in known.items()]


def clusters_of(rows):
    """Single linkage over the clusters of the manifest and over shared k-mers; every row gets its cluster."""
    parent = list(range(len(rows)))

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    mers = [{row["sequence"][at : at + K_MER] for at in range(len(row["sequence"]) - K_MER + 1)} for row in rows]
    for i, row in enumerate(rows):
        for j in range(i):
            least = SHARED_K_MERS * min(len(mers[i]), len(mers[j]))
            if row["manifest_cluster"] == rows[j]["manifest_cluster"] or len(mers[i] & mers[j]) >= least:
                parent[root(i)] = root(j)
    for i, row in enumerate(rows):
        row["cluster"] = rows[root(i)]["name"]


def stage_chains(structures, output):
    with open(structures / "MANIFEST.tsv", newline="") as file:
        entries = list(csv.DictReader(file, delimiter="\t"))
    rows, left_out = [], collections.Counter()
    for entry in sorted(entries, key=lambda entry: entry["file"]):
        if entry["n_nucleotides"] != "0":
            left_out["nucleic acid"] += 1
            continue
        path = structures / entry["file"]
        name, is_cif = entry["file"].split(".")[0], ".cif" in entry["file"]
        text = text_of(path)
        chain = first_chain(text, is_cif)
        if chain is None:
            left_out["no chain"] += 1
            continue
        if not (output / "chains" / f"{name}.pqr").exists():
            done, _ = protomer(
                *("ingest", path, "-o", output / "chains", "--name", name, "--chain", chain, "--ph", PH),
                *("--charges", "formal", "--export", "pqr", "-q", "--force"),
                may_fail=True,
            )
            if done.returncode:
                left_out["ingest failed"] += 1
                continue
        labels = set(assembly_labels(text, is_cif))
        residues = residues_of(output / "chains" / f"{name}.pqr")
        rows.append(
            {
                "name": name,
                "file": entry["file"],
                "chain": chain,
                "manifest_cluster": entry["cluster"],
                "sequence": "".join(letter for _, _, letter in residues),
                "label": labels.pop() if len(labels) == 1 else "contradictory" if labels else "not given",
            }
        )
    clusters_of(rows)
    write(output / "chains.json", json.dumps({"rows": rows, "left_out": left_out}, indent=1))
    print(f"{len(rows)} chains, {len({row['cluster'] for row in rows})} clusters; left out: {dict(left_out)}")


def chains(output):
    return json.loads((output / "chains.json").read_text())["rows"]
