"""Tables, report.json and the figure."""

import itertools
import json
import random

import matplotlib
import numpy as np

from judge import judge
from networks import finished, folder_of, predictions, runs_of, tried
from plan import CHARGE_BINS, CLASSES, FOLDS, PERMUTED, SIZE_CUTS, TASKS, TRIED, write
from samples import blocks, exchanged, folds_of, samples_of
from scores import auc

matplotlib.use("svg")
from matplotlib import pyplot as plt  # noqa: E402, after the backend is chosen


def table(lines):
    return "\n".join("| " + " | ".join(line) + " |" for line in [lines[0], ["---"] * len(lines[0]), *lines[1:]])


def show(result):
    """The table of a task."""
    names = list(result["scores"]["network"])
    lines = [["", *names, f"network less this, {names[1]}"]]
    for who, scored in result["scores"].items():
        cells = [f"{s['value']:.3f} ({s['interval'][0]:.3f} to {s['interval'][1]:.3f})" for s in scored.values()]
        other = scored[names[1]]
        low, high = other["interval_of_difference"]
        cells.append("" if who == "network" else f"{other['network_less_this']:+.3f} ({low:+.3f} to {high:+.3f})")
        lines.append([who, *cells])
    print(table(lines))
    p = ", ".join(f"{what} {value:.4f}" for what, value in result["permutation_p"].items())
    print(f"\npermutation p of the network: {p}")
    if "confusion" in result:
        print(f"confusion (true by row): {result['confusion']}")
    print(f"mean potential and net charge: correlation {result['correlation_of_mean_potential_and_charge']:.2f}")


def by_net_charge(result):
    """Where the sign is right: the shares of the network and of the last baseline, by the magnitude of the net charge."""
    lines = [["net charge (e)", "samples", "repulsion", "network right", "last baseline right"]]
    for low, high in itertools.pairwise(CHARGE_BINS):
        rows = [row for row in result["rows"] if low <= abs(row["charge"]) < high]
        if rows:
            truth = [CLASSES["sign"].index(row["class"]) for row in rows]
            right = [[np.argmax(row[who]) == t for row, t in zip(rows, truth)] for who in ("network", "baseline")]
            shares = [f"{np.mean(values):.2f}" for values in (truth, *right)]
            lines.append([f"{low} to {high}", str(len(rows)), *shares])
    return table(lines)


def errors_of_pairs(samples):
    """What the statistical errors of B2 mean for the labels."""
    error = np.array([sample["b2_error_angstrom3"] / sample["b2_hard_angstrom3"] for sample in samples])
    ratio = np.array([sample["ratio"] for sample in samples])
    near = {cut: int((abs(ratio - cut) < 2 * error).sum()) for cut in SIZE_CUTS}
    quantiles = np.quantile(ratio, [0, 0.1, 0.25, 0.5, 0.75, 0.9, 1]).round(3).tolist()
    return {
        "relative_error_median": float(np.median(error)),
        "relative_error_largest": float(error.max()),
        "within_two_errors_of_the_cut": near,
        "ratio_quantiles_0_10_25_50_75_90_100": quantiles,
    }


def costs(output):
    """Processor times in seconds."""
    known = {}
    pairs = [json.loads(path.read_text())["pair_cpu_s"] for path in (output / "pairs").glob("*.json")]
    if pairs:
        known["pair"] = {"mean": np.mean(pairs), "median": np.median(pairs), "all": np.sum(pairs), "bodies": len(pairs)}
    for task, setting in tried():
        folder = folder_of(output, task, setting)
        made = [json.loads(path.read_text()) for path in folder.glob("voxelize-*.json")]
        ran = [json.loads(path.read_text()) for path in (folder / runs_of(setting)).glob("[0-9].json")]
        if len(ran) == FOLDS:
            count = sum(one["structures"] for one in made)
            known[f"{task}, {setting}"] = {
                "voxelize_per_structure": sum(one["cpu_s"] for one in made) / count,
                "predict_per_structure": sum(one["predict_cpu_s"] for one in ran) / count,
                "train_per_network": sum(one["train_cpu_s"] for one in ran) / FOLDS,
            }
    return known


def figure(report, path):
    """Rankings of all networks and baselines with their intervals, a panel per task."""
    matplotlib.rcParams |= {"svg.hashsalt": "network-questions", "svg.fonttype": "none"}
    tasks = [task for task in TASKS if any(f"{task}, {setting}" in report for setting in TRIED[task])]
    panels, axes = plt.subplots(1, len(tasks), figsize=(4.3 * len(tasks), 3.4), constrained_layout=True, squeeze=False)
    for axis, task in zip(axes[0], tasks):
        networks, baselines = {}, {}
        for setting in TRIED[task]:
            result = report.get(f"{task}, {setting}")
            if result:
                what = list(result["scores"]["network"])[1]
                networks[f"network, {setting}"] = result["scores"]["network"][what]
                # The summary of the potential depends on the setting; the last one stands.
                baselines |= {who: one[what] for who, one in result["scores"].items() if who not in ("network", "prior")}
        known = networks | baselines
        for at, (who, score) in enumerate(reversed(known.items())):
            low, high = score["interval"]
            colour = "tab:red" if who.startswith("network") else "tab:grey"
            axis.errorbar(score["value"], at, xerr=[[score["value"] - low], [high - score["value"]]], fmt="o", color=colour)
        axis.set_yticks(range(len(known)), [who.replace("net charge", "charge") for who in reversed(known)], fontsize=7)
        axis.axvline(0.0 if what == "rank correlation" else 0.5, color="black", linewidth=0.7)
        axis.set_xlabel(what)
        axis.set_title(task)
    panels.savefig(path, metadata={"Date": None})


def stage_report(output):
    report = {"costs": costs(output)}
    for task, setting in tried():
        if not finished(folder_of(output, task, setting) / runs_of(setting)):
            continue
        result = report[f"{task}, {setting}"] = judge(output, task, setting)
        print(f"\n{task}, {setting}: {result['samples']} samples of {result['clusters']} clusters, {result.get('classes', 'a number')},", end=" ")
        print(f"{result['left_out']} left out\n")
        show(result)
        if task == "sign":
            print(f"\n{by_net_charge(result)}")
    report["errors_of_pairs"] = errors_of_pairs(samples_of(output, "sign"))
    print(report["errors_of_pairs"])
    retrained = {}
    for task, setting in PERMUTED.items():
        samples, permutation = samples_of(output, task), 1
        while finished(runs := folder_of(output, task, setting, permutation) / runs_of(setting)):
            network = predictions(runs, CLASSES[task])
            source = exchanged(blocks(samples), random.Random(f"labels {permutation}"))
            used = [i for i, sample in enumerate(samples) if sample["name"] in network]
            positive = np.array([samples[source[i]]["label"] == CLASSES[task][1] for i in used])
            score = np.array([network[samples[i]["name"]][1] for i in used])
            retrained[f"{task}, {permutation}"] = float(auc(score, positive, np.array(folds_of(samples))[used]))
            permutation += 1
    report["retrained_on_exchanged_labels_auc"] = retrained
    write(output / "report.json", json.dumps(report, indent=1, default=float))
    figure(report, output / "network-questions.svg")
    print(f"\nAUC of networks trained on exchanged labels: {retrained}")
    print(json.dumps(report["costs"], indent=1, default=float))
