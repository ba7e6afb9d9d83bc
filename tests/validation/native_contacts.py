#!/usr/bin/env python3
"""How many crystal complexes overlap as hard bodies, for several definitions of the hard core.

usage: python3 tests/validation/native_contacts.py PROTOMER FOLDER [-- CORE ...]

FOLDER holds NAME_receptor_bound.pdb.gz and NAME_ligand_bound.pdb.gz in one frame. A CORE is a list of flags in one
word, such as "--core native --offset 0.4"; without any, those of docs/validation/native-contacts.md are measured.
Prints a table: definition, complexes that overlap, volume of all cores over that of the surfaces.
"""
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

CORES = ["--core surface", "--core surface --offset 0.5", "--core surface --offset 0.7", "--core surface --offset 0.9",
         "--core native --offset 0", "--core native --offset 0.4", "--core native"]


def header_and_arrays(path):
    """The header of a body file and its arrays of numbers by name."""
    data, place = path.read_bytes(), 20

    def take(form):
        nonlocal place
        values = struct.unpack_from("<" + form, data, place)
        place += struct.calcsize("<" + form)
        return values[0]

    take(f"{take('H')}s")
    header, arrays = json.loads(take(f"{take('Q')}s")), {}
    for _ in range(take("I")):
        name, code, rank = take(f"{take('H')}s").decode(), take("B"), take("B")
        count = 1
        for _ in range(rank):
            count *= take("Q")
        form = {1: "d", 5: "I"}[code]
        arrays[name] = struct.unpack_from(f"<{count}{form}", data, place)
        place += count * struct.calcsize(form)
    return header, arrays


def volume(vertices, triangles):
    """Volume inside a closed mesh, Å³."""
    point = lambda index: vertices[3 * index:3 * index + 3]
    six = 0.0
    for corner in range(0, len(triangles), 3):
        (a, b, c), (d, e, f), (g, h, i) = map(point, triangles[corner:corner + 3])
        six += a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return six / 6


def measured(protomer, receptor, flags, folder):
    """Whether a complex overlaps in its crystal pose, and the volumes of its cores and surfaces, Å³."""
    files = [receptor, receptor.with_name(receptor.name.replace("receptor", "ligand"))]
    subprocess.run([protomer, "ingest", *files, "-o", folder, "-q", *flags.split()], check=True)
    bodies, places, core_volume, surface_volume = [], [], 0.0, 0.0
    for file in files:
        name = file.name.split(".")[0]
        header, arrays = header_and_arrays(folder / f"{name}.body")
        bodies.append({"name": name, "file": f"{name}.body"})
        places.append({"body": name, "position_angstrom": header["provenance"]["origin_angstrom"],
                       "orientation_wxyz": [1, 0, 0, 0]})
        surface = volume(arrays["vertices_angstrom"], arrays["triangles"])
        surface_volume += surface
        core_volume += volume(arrays["core_vertices_angstrom"], arrays["core_triangles"]) if "core_triangles" in arrays else surface
    assembly = folder / "assembly.json"
    assembly.write_text(json.dumps({"bodies": bodies, "placements": places}))
    answer = subprocess.run([protomer, "inspect", assembly, "--energy", "none", "--json", "-q"], check=True, capture_output=True)
    return json.loads(answer.stdout)["overlaps"], core_volume, surface_volume


def main():
    protomer, folder, *rest = sys.argv[1:]
    cores = rest[1:] or CORES
    receptors = sorted(Path(folder).glob("*_receptor_bound.pdb.gz"))
    surfaces = None
    print("| hard core | overlap | volume | which |\n|---|---|---|---|")
    for flags in cores:
        overlapping, total, surface_total = [], 0.0, 0.0
        for receptor in receptors:
            with tempfile.TemporaryDirectory() as work:
                overlaps, core_volume, surface_volume = measured(protomer, receptor, flags, Path(work))
            total, surface_total = total + core_volume, surface_total + surface_volume
            if overlaps:
                overlapping.append(receptor.name[:4].upper())
        surfaces = surfaces or surface_total
        which = " ".join(overlapping) if len(overlapping) < 12 else ""
        print(f"| `{flags}` | {len(overlapping)} of {len(receptors)} | {total / surfaces:.2f} | {which} |", flush=True)


if __name__ == "__main__":
    main()
