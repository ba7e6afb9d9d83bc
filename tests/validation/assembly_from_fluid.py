"""What the runs of assembly_from_fluid.sh show: clusters, contacts, native-like contacts, against sweeps.

    python assembly_from_fluid.py OUTPUT

Writes assembly-from-fluid.csv (every frame), .png and .svg into OUTPUT and prints the tables of the page.
"""

import csv
import json
import sys
from pathlib import Path

import gsd.hoomd
import matplotlib
import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

CONTACT_GAP_ANGSTROM = 5.0
EQUILIBRATION_SWEEPS = 500
# Contacts are followed from this sweep on, over these numbers of frames (of 5000 sweeps).
FRAME_SWEEPS = 5000
LATE_SWEEP = 10000
LAGS = (1, 4)
NATIVE_DISTANCE_ANGSTROM = 8.0
NATIVE_ANGLE_RAD = np.radians(30.0)
ARRANGEMENTS = ["candidate_1", "candidate_2", "candidate_3", "candidate_4", "tilted"]
SALTS = ["10mM", "50mM", "100mM", "300mM"]
COLOURS = {"10mM": "#4477aa", "50mM": "#228833", "100mM": "#ccbb44", "300mM": "#ee6677"}


class State:
    """Kinds (0: plus, 1: minus), positions (Å), rotations and the box of one frame."""

    def __init__(self, kinds, positions, wxyz, box):
        self.kinds, self.positions, self.box = np.asarray(kinds), np.asarray(positions, float), np.asarray(box, float)
        self.rotations = Rotation.from_quat(np.roll(np.asarray(wxyz, float), -1, axis=1))

    def relative(self, first, second):
        """Pose of the second body in the frame of the first: the nearest image."""
        displacement = self.positions[second] - self.positions[first]
        displacement -= self.box * np.round(displacement / self.box)
        back = self.rotations[first].inv()
        return back.apply(displacement), back * self.rotations[second]


def state_of_assembly(path):
    assembly = json.loads(path.read_text())
    placements = assembly["placements"]
    return State(
        [["plus", "minus"].index(p["body"]) for p in placements],
        [p["position_angstrom"] for p in placements],
        [p["orientation_wxyz"] for p in placements],
        assembly["box_angstrom"],
    )


class Surfaces:
    """The vertices of both kinds, to find contacts as the program defines them: vertex to vertex."""

    def __init__(self, shapes):
        self.vertices = [np.array(shape["vertices"], float) for shape in shapes]
        self.trees = [cKDTree(vertices) for vertices in self.vertices]
        self.radii = [np.linalg.norm(vertices, axis=1).max() for vertices in self.vertices]

    def contacts(self, state):
        found = []
        for second in range(len(state.kinds)):
            for first in range(second):
                a, b = state.kinds[first], state.kinds[second]
                place, turn = state.relative(first, second)
                if np.linalg.norm(place) >= self.radii[a] + self.radii[b] + CONTACT_GAP_ANGSTROM:
                    continue
                points = turn.apply(self.vertices[b]) + place
                points = points[np.linalg.norm(points, axis=1) < self.radii[a] + CONTACT_GAP_ANGSTROM]
                distances, _ = self.trees[a].query(points, distance_upper_bound=CONTACT_GAP_ANGSTROM)
                if np.isfinite(distances).any():
                    found.append((first, second))
        return found


def clusters(bodies, contacts):
    adjacency = np.zeros((bodies, bodies))
    for first, second in contacts:
        adjacency[first, second] = 1
    count, label = connected_components(adjacency, directed=False)
    return count, np.bincount(label).max()


def resembles(poses, place, turn):
    """Whether a relative pose lies within both tolerances of one of these."""
    return any(
        np.linalg.norm(place - other) < NATIVE_DISTANCE_ANGSTROM
        and (turn * other_turn.inv()).magnitude() < NATIVE_ANGLE_RAD
        for other, other_turn in poses
    )


def neighbour_poses(state, surfaces):
    """The relative poses of neighbours, by kinds. Those that the symmetry of the stack makes equal are kept once; a pair of
    one kind counts as seen from either body, so that the order in which bodies are numbered does not matter."""
    poses = {(0, 0): [], (0, 1): [], (1, 1): []}
    for first, second in surfaces.contacts(state):
        for a, b in [(first, second), (second, first)]:
            kinds = (state.kinds[a], state.kinds[b])
            if kinds not in poses:
                continue
            place, turn = state.relative(a, b)
            known = poses[kinds]
            if not any(np.linalg.norm(place - p) < 0.1 and (turn * t.inv()).magnitude() < 0.01 for p, t in known):
                known.append((place, turn))
    return poses


def ordered(state, pair):
    """The pair with a positive body first where there is one."""
    first, second = pair
    return (first, second) if state.kinds[first] <= state.kinds[second] else (second, first)


def native_like(state, contacts, poses):
    count = 0
    for pair in contacts:
        first, second = ordered(state, pair)
        count += resembles(poses[state.kinds[first], state.kinds[second]], *state.relative(first, second))
    return count


def chance(rng, state, contacts, poses, draws=200):
    """The expected number of native-like contacts if each contact kept its distance and were turned at random."""
    expected = 0.0
    for pair in contacts:
        first, second = ordered(state, pair)
        known = poses[state.kinds[first], state.kinds[second]]
        distance = np.linalg.norm(state.relative(first, second)[0])
        for other, _ in known:
            # Directions within the tolerance of place, sampled, times the exact share of rotations within an angle θ of
            # a given one, (θ - sin θ)/π. Neighbour poses that lie within the tolerances of each other are counted
            # twice: an upper bound.
            directions = rng.normal(size=(draws, 3))
            directions *= distance / np.linalg.norm(directions, axis=1)[:, None]
            near = (np.linalg.norm(directions - other, axis=1) < NATIVE_DISTANCE_ANGSTROM).mean()
            expected += near * (NATIVE_ANGLE_RAD - np.sin(NATIVE_ANGLE_RAD)) / np.pi
    return expected


def analyse(output):
    rows, lost, logs, cpu = [], [], {}, {}
    surfaces, poses = None, None
    rng = np.random.default_rng(1)
    checked = differing = 0
    for folder in sorted(output.glob("*/*/replica_*")):
        if not (folder / "cpu_seconds").exists():
            continue
        start, salt, replica = folder.parts[-3], folder.parts[-2], int(folder.name.split("_")[1])
        run = folder / f"salt_{float(salt[:-2]) / 1000:.6f}M" / "replica_0"
        log = np.genfromtxt(run / "log.csv", delimiter=",", names=True)
        logs[start, salt, replica] = log
        cpu[start, salt, replica] = sum(map(float, (folder / "cpu_seconds").read_text().split()))
        with gsd.hoomd.open(str(run / "trajectory.gsd")) as trajectory:
            if surfaces is None:
                surfaces = Surfaces(trajectory[0].particles.type_shapes)
                states = {name: state_of_assembly(output / f"{name}.json") for name in ARRANGEMENTS}
                each = {name: neighbour_poses(state, surfaces) for name, state in states.items()}
                best = each["candidate_3"]
                poses = {kinds: sum((one[kinds] for one in each.values()), []) for kinds in best}
                for name, state in states.items():
                    found = surfaces.contacts(state)
                    own = native_like(state, found, each[name])
                    print(f"{name}: {len(found)} contacts, of which {own} resemble its own neighbour poses,",
                          f"{native_like(state, found, best)} those of candidate_3; distinct poses",
                          {f"{a}{b}": len(p) for (a, b), p in each[name].items()})
            first = state_of_assembly(output / ("candidate_3.json" if start == "native" else f"fluid_{replica}.json"))
            frames = [(0, first)] + [
                (EQUILIBRATION_SWEEPS + int(frame.configuration.step),
                 State(frame.particles.typeid, frame.particles.position, frame.particles.orientation,
                       frame.configuration.box[:3]))
                for frame in trajectory
            ]
        at = {int(sweep): index for index, sweep in enumerate(log["sweep"])}
        sets = []
        for sweep, state in frames:
            contacts = surfaces.contacts(state)
            sets.append(set(contacts))
            count, largest = clusters(len(state.kinds), contacts)
            index = at.get(sweep - EQUILIBRATION_SWEEPS)
            if index is not None:
                checked += 1
                differing += largest != log["largest_cluster"][index]
            sums = [state.kinds[a] + state.kinds[b] for a, b in contacts]
            rows.append({
                "start": start, "salt": salt, "replica": replica, "sweep": sweep, "largest_cluster": largest,
                "mean_cluster": len(state.kinds) / count, "unlike_contacts": sums.count(1),
                "plus_plus_contacts": sums.count(0), "minus_minus_contacts": sums.count(2),
                "native_like": native_like(state, contacts, best),
                "native_like_by_chance": chance(rng, state, contacts, best),
                "like_any_of_five": native_like(state, contacts, poses),
                "like_any_by_chance": chance(rng, state, contacts, poses),
                "energy_kT": log["energy_kT"][index] if index is not None else float("nan"),
            })
        late = [found for (sweep, _), found in zip(frames, sets) if sweep >= LATE_SWEEP]
        for lag in LAGS:
            pairs = [(len(a & b), len(a)) for a, b in zip(late, late[lag:])]
            lost.append((start, salt, replica, lag, sum(p[0] for p in pairs), sum(p[1] for p in pairs)))
    print(f"largest cluster recomputed from {checked} frames: {differing} differ from the log")
    if differing > checked / 100:
        sys.exit("the contacts found here are not those of the program")
    return rows, lost, logs, cpu


def series(rows, start, salt, key):
    """The sweeps that all replicas have reached, and the values, a row per replica."""
    by_replica = {}
    for row in rows:
        if row["start"] == start and row["salt"] == salt:
            by_replica.setdefault(row["replica"], {})[row["sweep"]] = row[key]
    sweeps = sorted(set.intersection(*map(set, by_replica.values())))
    return np.array(sweeps), np.array([[one[sweep] for sweep in sweeps] for one in by_replica.values()], float)


def spread(values, digits=1):
    """Mean and standard deviation of the replicas, where there is more than one."""
    mean = f"{np.mean(values):.{digits}f}"
    return mean if len(values) == 1 else f"{mean} ± {np.std(values, ddof=1):.{digits}f}"


def tables(rows, lost, cpu):
    present = {(row["start"], row["salt"]) for row in rows}
    runs = [(start, salt) for start in ("fluid", "native") for salt in SALTS if (start, salt) in present]
    print("\nLargest and mean cluster against sweeps (mean ± standard deviation of replicas)\n")
    for start, salt in runs:
        sweeps, largest = series(rows, start, salt, "largest_cluster")
        _, mean = series(rows, start, salt, "mean_cluster")
        used = np.array([seconds for key, seconds in cpu.items() if key[:2] == (start, salt)])
        chosen = sorted({round(part * (len(sweeps) - 1)) for part in (0, 0.25, 0.5, 0.75, 1)})
        cells = [f"{sweeps[k]}: {spread(largest[:, k])}; {spread(mean[:, k])}" for k in chosen]
        print(f"| {start} {salt} | " + " | ".join(cells) + f" | {spread(used)} |")
    print("\nLast quarter (mean over frames of each replica, then mean ± standard deviation of replicas)\n")
    keys = ["largest_cluster", "mean_cluster", "unlike_contacts", "plus_plus_contacts", "minus_minus_contacts",
            "native_like", "native_like_by_chance", "like_any_of_five", "like_any_by_chance", "energy_kT"]
    print("| start | " + " | ".join(keys) + " |")
    for start, salt in runs:
        cells = []
        for key in keys:
            sweeps, values = series(rows, start, salt, key)
            late = np.nanmean(values[:, sweeps >= 0.75 * sweeps[-1]], axis=1)
            cells.append(spread(late, 3 if key.endswith("by_chance") else 1))
        print(f"| {start} {salt} | " + " | ".join(cells) + " |")
    later = " and ".join(str(lag * FRAME_SWEEPS) for lag in LAGS)
    print(f"\nContacts from sweep {LATE_SWEEP} on that are there {later} sweeps later as well\n")
    for start, salt in runs:
        cells = []
        for lag in LAGS:
            kept = [(k, n) for s, c, _, g, k, n in lost if (s, c, g) == (start, salt, lag)]
            total = sum(n for _, n in kept)
            cells.append(f"{sum(k for k, _ in kept) / total:.2f} of {total}" if total else "none")
        print(f"| {start} {salt} | " + " | ".join(cells) + " |")
    print(f"\nCPU-seconds in all: {sum(cpu.values()):.0f}")


def figure(rows, logs, output):
    pyplot.rcParams.update({"font.size": 9, "svg.hashsalt": "protomer"})
    canvas, axes = pyplot.subplots(2, 2, figsize=(9, 6.4), sharex=True, constrained_layout=True)
    panels = [("largest_cluster", "bodies in the largest cluster"), ("energy_kT", "energy (kT)"),
              ("unlike_contacts", "contacts between unlike kinds"), ("native_like", "native-like contacts")]
    for axis, (key, label) in zip(axes.flat, panels):
        for salt in SALTS:
            for start in ("fluid", "native"):
                if not any(row["start"] == start and row["salt"] == salt for row in rows):
                    continue
                if key in ("largest_cluster", "energy_kT"):
                    chosen = [log for (s, c, _), log in logs.items() if (s, c) == (start, salt)]
                    rows_of_all = min(len(log) for log in chosen)
                    sweeps = EQUILIBRATION_SWEEPS + chosen[0]["sweep"][:rows_of_all]
                    values = np.array([log[key][:rows_of_all] for log in chosen])
                else:
                    sweeps, values = series(rows, start, salt, key)
                mean = values.mean(axis=0)
                dashed = start == "native"
                axis.plot(sweeps / 1000, mean, "--" if dashed else "-", color=COLOURS[salt], lw=1.2,
                          label=None if dashed else salt.replace("mM", " mM"))
                if len(values) > 2:
                    axis.fill_between(sweeps / 1000, values.min(axis=0), values.max(axis=0), color=COLOURS[salt],
                                      alpha=0.18, lw=0)
        axis.set_ylabel(label)
    for axis in axes[1]:
        axis.set_xlabel("sweeps from the start (thousands)")
    axes[0, 0].set_ylim(0, 16.5)
    axes[0, 0].plot([], [], "k--", lw=1.2, label="from the stack")
    axes[0, 0].legend(frameon=False, fontsize=8, ncol=2)
    for suffix in ("svg", "png"):
        metadata = {"Date": None} if suffix == "svg" else None
        canvas.savefig(output / f"assembly-from-fluid.{suffix}", dpi=130, metadata=metadata)


def main():
    output = Path(sys.argv[1])
    rows, lost, logs, cpu = analyse(output)
    with open(output / "assembly-from-fluid.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    tables(rows, lost, cpu)
    figure(rows, logs, output)


if __name__ == "__main__":
    main()
