"""The table of mutation_scan.sh, from scan.json and the sweeps of the mutants in the current folder."""

import json
from pathlib import Path


def with_error(value, scale=1.0, digits=4):
    error = value["error"]
    return f"{scale * value['mean']:.{digits}f}" + (f" ± {scale * error:.{digits}f}" if error else "")


def main():
    rows = json.loads(Path("scan.json").read_text())["mutations"]
    print("| mutant | salt (mM) | effective frames | bound, frames weighted | bound, simulated | standard errors apart |")
    print("|---|---|---|---|---|---|")
    halves = []
    for mutant in ["E17Q", "D50N", "K15E"]:
        row = next(row for row in rows if row["mutation"] == f"A:{mutant}" and row["body"] == "unchanged")
        sweep = json.loads(Path(f"{mutant}.sweep.json").read_text())
        for at, salt, replicas in zip(row["at_salts"], sweep["salts"], sweep["replicas"]):
            assert abs(at["salt_molar"] - salt["salt_M"]) < 1e-9
            spread = salt["bound_fraction_sd"] / len(replicas) ** 0.5
            own = sum(r["bound_fraction"]["standard_error"] ** 2 for r in replicas) ** 0.5 / len(replicas)
            error = max(spread, own)
            weighted = at["contacts_left"]
            apart = (weighted["mean"] - salt["bound_fraction_mean"]) / (error**2 + weighted["error"] ** 2) ** 0.5
            print(
                f"| {mutant} | {1e3 * at['salt_molar']:.0f} | {at['effective_frames']:.0f} | {with_error(weighted)} "
                f"| {salt['bound_fraction_mean']:.4f} ± {error:.4f} | {apart:+.1f} |"
            )
        halves.append((mutant, row, sweep))
    print()
    print("| mutant | energy (kT) | half salt, frames weighted (mM) | half salt, simulated (mM) |")
    print("|---|---|---|---|")
    for mutant, row, sweep in halves:
        molar, interval = sweep["half_bound_salt_molar"], sweep["half_bound_salt_interval_molar"]
        simulated = "-"
        if molar:
            low, high = (f"{1e3 * end:.1f}" if end else "open" for end in interval)
            simulated = f"{1e3 * molar:.1f} ({low} to {high})"
        half = row["half_salt_molar"]
        weighted = f"{1e3 * half:.1f}" if half else "-"
        print(f"| {mutant} | {with_error(row['energy_change_kt'], digits=2)} | {weighted} | {simulated} |")


if __name__ == "__main__":
    main()
