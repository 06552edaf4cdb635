"""Prints what `run` measured, as a table and as verdicts, and writes it to `simplifiers.csv`."""

import csv
import sys
from pathlib import Path

COLUMNS = ["mesh", "target", "peer", "wall_s", "cpu_s", "before_mb", "peak_mb"]
ERRORS = ["faces", "rms", "mean", "hausdorff"]
OURS = "ours-1"
# Further above the target a mesh has faces to spare.
SPARE = 1.005
# What is said of ours, and which value is the worst.
WORST = {"RMS/VTK's": max, "speed/meshoptimizer's": min, "2 threads/1": min, "peak MB": max}


def main(folder):
    rows = load(folder)
    with open(folder / "simplifiers.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS + ERRORS)
        writer.writeheader()
        writer.writerows(rows)
    verdicts = []
    for mesh, target in dict.fromkeys((row["mesh"], row["target"]) for row in rows):
        group = {row["peer"]: row for row in rows if (row["mesh"], row["target"]) == (mesh, target)}
        print_group(f"{mesh} to {target} faces", group)
        if OURS in group and not has_spare_faces(group[OURS]):
            verdicts.append(verdict(f"{mesh} {target}", group))
    print_verdicts(verdicts)


def load(folder):
    """One row for each mesh, target and peer, in the order of the first run; the last measurement counts."""
    errors = {}
    with open(folder / "errors.csv", newline="") as file:
        for row in csv.DictReader(file):
            if row["file"] != "file":
                errors[row["file"]] = {name: float(row[name]) for name in ERRORS}
    rows = {}
    with open(folder / "costs.csv", newline="") as file:
        for fields in csv.reader(file):
            row = dict(zip(COLUMNS, fields, strict=True))
            key = "-".join(fields[:3])
            numbers = {name: float(row[name]) for name in COLUMNS[3:]}
            rows[key] = row | numbers | errors[key] | {"target": int(row["target"])}
    return list(rows.values())


def has_spare_faces(row):
    return row["faces"] > SPARE * row["target"]


def print_group(title, group):
    print(f"\n{title}")
    heads = ["faces", "CPU s", "wall s", "RMS e-4", "mean e-4", "Hausdorff e-3", "input MB", "peak MB"]
    print(f"{'':24}" + "".join(f"{head:>{width(head)}}" for head in heads))
    for peer, row in group.items():
        mark = "*" if has_spare_faces(row) else ""
        values = [
            f"{row['faces']:.0f}{mark}",
            f"{row['cpu_s']:.3f}",
            f"{row['wall_s']:.3f}",
            f"{row['rms'] * 1e4:.2f}",
            f"{row['mean'] * 1e4:.2f}",
            f"{row['hausdorff'] * 1e3:.2f}",
            f"{row['before_mb']:.0f}",
            f"{row['peak_mb']:.0f}",
        ]
        print(f"{peer:24}" + "".join(f"{v:>{width(h)}}" for v, h in zip(values, heads)))
    if any(map(has_spare_faces, group.values())):
        print("* stopped above the number that was asked for: not compared")


def width(head):
    return max(9, len(head) + 2)


def verdict(name, group):
    ours = group[OURS]

    def dominates(row):
        """No worse in time and in error, and better in one."""
        mine, theirs = ((r["cpu_s"], r["rms"]) for r in (ours, row))
        return theirs != mine and all(t <= m for t, m in zip(theirs, mine))

    def ratio(column, over, under):
        return group[over][column] / group[under][column] if {over, under} <= set(group) else None

    others = {p: row for p, row in group.items() if p != "ours-2" and not has_spare_faces(row)}
    return {
        "": name,
        "RMS/VTK's": ratio("rms", OURS, "vtk"),
        "speed/meshoptimizer's": ratio("cpu_s", "meshoptimizer-simplify", OURS),
        "2 threads/1": ratio("wall_s", OURS, "ours-2"),
        "peak MB": ours["peak_mb"],
        "dominated by": ", ".join(p for p, row in others.items() if dominates(row)) or "none",
    }


def print_verdicts(verdicts):
    """A line for each mesh and number of faces, and the worst of each column."""
    if not verdicts:
        return
    worst = {"": "worst", "dominated by": f"{sum(row['dominated by'] != 'none' for row in verdicts)} times"}
    for column, pick in WORST.items():
        worst[column] = pick((row[column] for row in verdicts if row[column] is not None), default=None)
    print(f"\n{OURS:16}" + "".join(f"{c:>{len(c) + 3}}" for c in WORST) + "   dominated by")
    for row in [*verdicts, worst]:
        values = {c: "" if row[c] is None else f"{row[c]:.2f}" for c in WORST}
        line = "".join(f"{value:>{len(c) + 3}}" for c, value in values.items())
        print(f"{row['']:16}{line}   {row['dominated by']}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
