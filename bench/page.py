"""The page of a run: tables and pictures of the rows that `run.py` collected."""

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

OWN = "servo_id"
KINDS = [("no effect", 0, 0), ("1 or 2", 1, 2), ("3 to 5", 3, 5)]


class Summary:
    """The figures of a method."""

    def __init__(self, method, lowest):
        self.method, self.rows = method, method["rows"]
        self.done = [row for row in self.rows if "failed" not in row]
        judged = [row for row in self.rows if row["group"] not in ("speed", "Go2", "EMPS")]
        self.known = [row for row in judged if "right" in row]
        self.of_known = len([row for row in judged if "right" in row or "failed" in row])
        self.converged = [row for row in self.known if row["converged"]]
        self.right = sum(row["right"] for row in self.converged)
        self.wrong = len(self.converged) - self.right
        self.covered = sum(row["covered"] for row in self.converged)
        self.intervals = sum(row["intervals"] for row in self.converged)
        ratios = [row["held_out"] / lowest[row["log"]] for row in self.rows if "held_out" in row]
        self.best = 100 * np.mean([ratio <= 1.05 for ratio in ratios]) if ratios else np.nan
        self.ratio = np.median(ratios) if ratios else np.nan
        self.seconds = np.median([row["seconds"] for row in self.done if row["group"] != "speed"] or [np.nan])
        self.failed = len(self.rows) - len(self.done)


def number(value, digits=3):
    """A figure as text; a dash where there is none."""
    if value is None or not np.isfinite(value):
        return "–"
    return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"


def share(part, all_):
    return f"{100 * part / all_:.1f} %" if all_ else "–"


def table(heading, rows):
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def lowest_held_out(results):
    """The lowest held-out error of each log."""
    lowest = {}
    for method in results["methods"].values():
        for row in method["rows"]:
            if "held_out" in row:
                lowest[row["log"]] = min(row["held_out"], lowest.get(row["log"], np.inf))
    return {log: max(error, 1e-12) for log, error in lowest.items()}


def seconds_at(method, rows):
    found = [row["seconds"] for row in method["rows"] if row["group"] == "speed" and row["rows"] == rows and "seconds" in row]
    return float(np.median(found)) if found else np.nan


def ratio_of_time(results, rows):
    """Time of the output-error fit over ours."""
    methods = results["methods"]
    if "output_error" not in methods or OWN not in methods:
        return np.nan
    return seconds_at(methods["output_error"], rows) / seconds_at(methods[OWN], rows)


def goals(results, own):
    """Each goal: text, measured, whether it is met."""
    wrong = own.wrong / len(own.converged) if own.converged else np.nan
    coverage = own.covered / own.intervals if own.intervals else np.nan
    rows = [
        ("wrong among converged at most 1 %", share(own.wrong, len(own.converged)), wrong <= 0.01),
        ("the 95 % interval holds the truth in 93 to 99 %", share(own.covered, own.intervals), 0.93 <= coverage <= 0.99),
        ("held-out error lowest or within 5 % of it in 80 % of the logs", f"{number(own.best)} %", own.best >= 80),
    ]
    for size, factor in ((10_000, 10), (100_000, 5)):
        measured = ratio_of_time(results, size)
        text = f"{factor} times faster than the output-error fit at {size:,} rows".replace(",", " ")
        rows.append((text, f"{number(measured, 2)} times", measured >= factor))
    return rows


def advantages(other, own):
    """In what another method is better."""
    better = []
    if other.known and other.right / other.of_known > own.right / max(own.of_known, 1):
        better.append(f"right in {share(other.right, other.of_known)} of its logs, we in {share(own.right, own.of_known)}")
    if other.best > own.best:
        better.append(f"held-out error lowest or within 5 % in {number(other.best)} % of its logs, we in {number(own.best)} %")
    if other.ratio < own.ratio:
        better.append(f"held-out error {number(other.ratio)} times the lowest at the median, ours {number(own.ratio)} times")
    if other.seconds < own.seconds:
        better.append(f"{number(other.seconds, 2)} s at the median, we {number(own.seconds, 2)} s")
    if other.method.get("megabytes", np.inf) < own.method.get("megabytes", 0):
        better.append("less memory")
    return better


def pictures(results, shown, folder):
    """Three pictures: right by the number of effects, held-out error against the lowest, time by rows."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    width = 0.8 / max(len(shown), 1)
    lowest = lowest_held_out(results)
    for place, summary in enumerate(shown):
        name, colour = summary.method["name"], f"C{place}"
        heights = []
        for _, low, high in KINDS:
            of_kind = [r for r in summary.known if r["group"] == "drawn" and low <= len(r["effects"]) <= high]
            heights.append(100 * np.mean([r["right"] for r in of_kind]) if of_kind else 0)
        left.bar(np.arange(3) + place * width, heights, width, color=colour, label=name)
        ratios = sorted(r["held_out"] / lowest[r["log"]] for r in summary.rows if "held_out" in r)
        middle.plot(ratios, 100 * np.arange(1, len(ratios) + 1) / max(len(ratios), 1), color=colour)
        sizes = [10_000, 100_000]
        right.loglog(sizes, [seconds_at(summary.method, size) for size in sizes], "o-", color=colour)
    left.set_xticks(np.arange(3) + 0.4, [name for name, *_ in KINDS])
    left.set(title="right, % of drawn logs", xlabel="effects beside friction and load")
    middle.set(title="held-out error over the lowest", xscale="log", xlim=(1, 1e4), xlabel="ratio", ylabel="% of logs below")
    right.set(title="processor time of a fit, s", xlabel="rows")
    figure.legend(loc="outside lower center", ncols=4, fontsize="small", frameon=False)
    figure.savefig(folder / "results.png", dpi=100)
    plt.close(figure)


def by_kind(results, shown):
    rows = []
    for summary in shown:
        cells = [summary.method["name"]]
        for _, low, high in KINDS:
            of_kind = [r for r in summary.known if r["group"] == "drawn" and low <= len(r["effects"]) <= high]
            good = [r for r in of_kind if r["converged"]]
            cells.append(f"{sum(r['right'] for r in good)}, {sum(not r['right'] for r in good)} of {len(of_kind)}")
        errors = [100 * r["error_of_b"] for r in summary.known]
        cells += [number(np.median(errors)) if errors else "–", number(np.quantile(errors, 0.9)) if errors else "–"]
        rows.append(cells)
    return table(["method", *(f"{name}: right, wrong" for name, *_ in KINDS), "error of b, median, %", "90 % below, %"], rows)


def held_out_by_group(results, shown):
    groups = sorted({log["group"] for log in results["logs"]} - {"speed"})
    rows = []
    for summary in shown:
        cells = [summary.method["name"]]
        for group in groups:
            errors = [r["held_out"] for r in summary.rows if r["group"] == group and "held_out" in r]
            cells.append(number(100 * np.median(errors)) if errors else "–")
        rows.append(cells)
    counts = {group: sum(log["group"] == group for log in results["logs"]) for group in groups}
    return table(["method", *(f"{group}, {counts[group]} logs" for group in groups)], rows)


def write(results, folder):
    folder.mkdir(parents=True, exist_ok=True)
    lowest = lowest_held_out(results)
    methods = results["methods"]
    shown = [Summary(method, lowest) for method in methods.values() if method["rows"]]
    own = Summary(methods[OWN], lowest) if OWN in methods else None
    parts = ["# Benchmark: results\n"]
    parts.append(
        f"{results['date']}, {results['machine']}, drawn logs of seed {results['seed']}:\n"
        f"`{results['command']}`. How it is measured: [the benchmark](README.md).\n"
    )
    if own:
        parts.append("## Where we lose\n")
        lost = [f"- **Not reached**: {text}. Measured: {measured}." for text, measured, met in goals(results, own) if not met]
        for other in shown:
            better = advantages(other, own) if other.method is not own.method else []
            if better:
                lost.append(f"- **{other.method['name']}**: " + "; ".join(better) + ".")
        parts.append("\n".join(lost or ["- Nowhere in this run."]) + "\n")
        reached = [(text, measured, "yes" if met else "**no**") for text, measured, met in goals(results, own)]
        parts.append("## Goals\n\n" + table(["goal", "measured", "reached"], reached))
    rows = []
    for summary in shown:
        method = summary.method
        rows.append(
            [
                method["name"],
                f"{summary.right} of {summary.of_known}",
                f"{summary.wrong} of {len(summary.converged)}",
                share(summary.covered, summary.intervals),
                f"{number(summary.best)} %",
                number(summary.ratio),
                number(summary.seconds, 2),
                number(method.get("megabytes")),
                method.get("user_lines", "–"),
                summary.failed,
            ]
        )
    heading = ["method", "right", "wrong among converged", "95 % interval holds", "held-out: lowest within 5 %"]
    heading += ["held-out: over the lowest, median", "s, median", "MB", "lines", "failed"]
    parts.append("## All methods\n\n![Right, held-out error and time of each method](results.png)\n\n" + table(heading, rows))
    parts.append("## Drawn logs, by the number of effects\n\n" + by_kind(results, shown))
    parts.append("## Held-out error, median, % of the motion\n\n" + held_out_by_group(results, shown))
    times = [[s.method["name"], *(number(seconds_at(s.method, n), 2) for n in (10_000, 100_000))] for s in shown]
    parts.append("## Processor time of a fit, s, logs without effects\n\n" + table(["method", "10 000 rows", "100 000 rows"], times))
    parts.append("## Methods, licences, and what did not run\n")
    notes = []
    for method in methods.values():
        reasons = [row["failed"] for row in method["rows"] if "failed" in row]
        left = len(results["logs"]) - len(method["rows"])
        note = [f"not run: {method['not_run']}"] if "not_run" in method else []
        note += [f"{len(reasons)} failed: {max(set(reasons), key=reasons.count)}"] if reasons else []
        note += [f"{left} logs not taken: its {results['budget']} s were over"] if left and "not_run" not in method else []
        notes.append([method["name"], method["licence"], "; ".join(note) or "all logs"])
    parts.append(table(["method", "licence", "remark"], notes))
    if results["missing"]:
        parts.append("Logs that were not at hand:\n\n" + table(["logs", "reason"], results["missing"].items()))
    (folder / "RESULTS.md").write_text("\n".join(parts))
    pictures(results, shown, folder)
