"""Tables of a blind trial in Markdown, from the results of its cases."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from benchmarks.trial.cases import KINDS, LATER_KINDS

Line = dict[str, Any]
ALL_KINDS = (*KINDS, *LATER_KINDS)
BINS = 10
CLOSED = 0.99
SETS = {
    "1": "exact model, periodic random",
    "2": "exact model, pure random through a Hann window",
    "3": "model and rig within tolerances, periodic random",
    "3a": "the same, with up to two proposed tests done",
    "4": "exact model, periodic random, kinds that joined the catalogue later",
}
TYPES = {
    "single": "single effects, named first",
    "pair": "pairs of effects, both named",
    "nothing": "no missing effect, recognised",
    "unknown": "effects outside the catalogue, reported as unexplained",
    "log_book": "errors of the log book, found",
}


def report(lines: Sequence[Line]) -> str:
    """Return the tables of all sets with results."""
    parts = []
    for name, words in SETS.items():
        mine = [line for line in lines if line["set"] == name]
        if mine:
            parts += [f"## Set {name}: {words}", "", _of(mine), "", *_scores(mine), "", *_by_kind(mine), ""]
            parts += [*_calibration(mine), "", *_matrix(mine), ""]
    return "\n".join(parts)


def _of(lines: Sequence[Line]) -> str:
    """Return number, seeds and code revisions of the cases."""
    seeds = ", ".join(str(seed) for seed in sorted({line["seed"] for line in lines if "seed" in line}))
    revisions = ", ".join(sorted({line["revision"] for line in lines if line.get("revision")}))
    return f"{len(lines)} cases, seed {seeds or 'not kept'}, code {revisions or 'not kept'}."


def _scores(lines: Sequence[Line]) -> list[str]:
    rows = ["| type of case | correct | cases | share | 95 % interval |", "|---|---|---|---|---|"]
    for type_, words in TYPES.items():
        mine = [line for line in lines if line["type"] == type_]
        if mine:
            right = sum(line["right"] for line in mine)
            alias = sum(line["by_alias"] for line in mine)
            low, high = _between(right, len(mine))
            words += f" ({alias} by an equivalent effect)" if alias else ""
            rows.append(
                f"| {words} | {right} | {len(mine)} | {100 * right / len(mine):.0f} % | "
                f"{low:.0f} to {high:.0f} % |"
            )
    for noise in sorted({line["noise"] for line in lines}):
        mine = [line for line in lines if line["noise"] == noise]
        right = sum(line["right"] for line in mine)
        low, high = _between(right, len(mine))
        rows.append(
            f"| all cases, noise level {noise:g} | {right} | {len(mine)} | {100 * right / len(mine):.0f} % | "
            f"{low:.0f} to {high:.0f} % |"
        )
    rows += ["", "| figure | value | cases or parameters |", "|---|---|---|"]
    return rows + [f"| {words} | {value} | {count} |" for words, value, count in figures(lines)]


def figures(lines: Sequence[Line]) -> list[tuple[str, str, int]]:
    """Return the further figures of merit: name, value, number of cases or parameters."""
    right = [line for line in lines if line["right"] and line["type"] in ("single", "pair", "log_book")]
    first_errors = [e for line in right for step in line["steps"] for e in list(step["errors"].values())[:1]]
    all_errors = [e for line in right for step in line["steps"] for e in step["errors"].values()]
    # An effect without influence on FRFs, as an armature, has no held-out difference.
    visible = [line for line in right if line.get("held_out_before", 0.0) > line.get("held_out_noise", 0.0)]
    closed = [1 - line["held_out_after"] / line["held_out_before"] for line in visible]
    within = [line["within_scatter"] for line in right if "within_scatter" in line]
    seconds = [line["seconds"] for line in lines]
    rows: list[tuple[str, str, int]] = []
    if first_errors:
        rows += [
            (
                "median error of the first parameter, relative to its value",
                f"{100 * _median(first_errors, 0):.3g} %",
                len(first_errors),
            ),
            (
                "median error of the first parameter, relative to its distance from zero effect",
                f"{100 * _median(first_errors, 1):.3g} %",
                len(first_errors),
            ),
            (
                "coverage of 95 % confidence intervals, all parameters",
                f"{100 * np.mean([abs(e[2]) < 1.96 for e in all_errors]):.0f} %",
                len(all_errors),
            ),
        ]
    if closed:
        share = np.mean([c > CLOSED for c in closed])
        rows.append(
            (
                "correct answers that reduce the held-out difference by over 99 %",
                f"{100 * share:.0f} %",
                len(closed),
            )
        )
    if within:
        share = np.mean(within)
        rows.append(
            (
                "correct answers with a remaining gap of 1 within its scatter",
                f"{100 * share:.0f} %",
                len(within),
            )
        )
    if stated := beliefs(lines):
        rows.append(("expected calibration error", f"{calibration_error(stated):.3f}", len(stated)))
    rows.append(("CPU time, median", f"{np.median(seconds):.1f} s", len(seconds)))
    rows.append(("CPU time, maximum", f"{max(seconds):.0f} s", len(seconds)))
    if failed := sum(bool(line["trouble"]) for line in lines):
        rows.append(("diagnoses that failed", str(failed), len(lines)))
    return rows


def beliefs(lines: Iterable[Line]) -> list[tuple[float, bool]]:
    """Return stated probability and truth of every first step, of cases whose answer is in the catalogue."""
    pairs = []
    for line in lines:
        if line["type"] in ("single", "pair", "log_book") and line["truth"]:
            for i, step in enumerate(line["steps"]):
                alias = line["by_alias"] and i < len(line["truth"])
                pairs.append((float(step["probability"]), bool(step["true"] or alias)))
    return pairs


def calibration_error(stated: Sequence[tuple[float, bool]]) -> float:
    """Return the mean over ten bins of |share of right ones - mean probability|, weighted by their counts."""
    probability, right = np.array([p for p, _ in stated]), np.array([r for _, r in stated], float)
    place = np.minimum((probability * BINS).astype(int), BINS - 1)
    total = 0.0
    for i in range(BINS):
        in_bin = place == i
        if in_bin.any():
            total += in_bin.sum() * abs(right[in_bin].mean() - probability[in_bin].mean())
    return float(total / len(stated))


def _calibration(lines: Sequence[Line]) -> list[str]:
    stated = beliefs(lines)
    rows = ["| stated probability | named effects | true |", "|---|---|---|"]
    for i in range(BINS):
        in_bin = [r for p, r in stated if min(int(p * BINS), BINS - 1) == i]
        if in_bin:
            rows.append(
                f"| {i / BINS:.1f} to {(i + 1) / BINS:.1f} | {len(in_bin)} | {100 * np.mean(in_bin):.0f} % |"
            )
    return rows


def _by_kind(lines: Sequence[Line]) -> list[str]:
    rows = [
        "| hidden effect | cases | correct | by an equivalent effect | median error of its value "
        "| named instead |",
        "|---|---|---|---|---|---|",
    ]
    for kind in ALL_KINDS:
        mine = [line for line in lines if line["type"] == "single" and line["truth"][0]["kind"] == kind]
        if not mine:
            continue
        wrong = Counter(_case_name(line) for line in mine if not line["right"])
        answers = ", ".join(f"{name} {count}" for name, count in wrong.most_common())
        errors = [
            e
            for line in mine
            if line["right"]
            for step in line["steps"][:1]
            for e in list(step["errors"].values())[:1]
        ]
        error = f"{100 * _median(errors, 0):.2g} %" if errors else ""
        right, alias = sum(line["right"] for line in mine), sum(line["by_alias"] for line in mine)
        rows.append(f"| `{kind}` | {len(mine)} | {right} | {alias or ''} | {error} | {answers} |")
    return rows


def _case_name(line: Line) -> str:
    """Return the kind named first for a single effect, marked if at another place; else the verdict."""
    if not line["steps"]:
        return "nothing" if line["verdict"] == "nothing_missing" else str(line["verdict"])
    first = line["steps"][0]
    same_kind = first["kind"] == line["truth"][0]["kind"] and not first["true"]
    return str(first["kind"]) + (" elsewhere" if same_kind else "")


def _matrix(lines: Sequence[Line]) -> list[str]:
    """Return the confusion matrix of hidden and named kinds; equivalent effects count as named."""
    pairs = Counter(
        (line["truth"][0]["kind"], line["steps"][0]["kind"] if line["steps"] else "nothing")
        for line in lines
        if line["type"] == "single"
    )
    hidden = [kind for kind in ALL_KINDS if any(h == kind for h, _ in pairs)]
    if not hidden:
        return []
    extra_kinds = sorted({columns for _, columns in pairs} - set(ALL_KINDS))
    columns = [kind for kind in ALL_KINDS if any(n == kind for _, n in pairs)] + extra_kinds
    rows = [
        "Confusion matrix. Rows: hidden effect. Columns: effect named first, by the number of its row or "
        "by name.",
        "",
        "| | hidden | "
        + " | ".join(str(ALL_KINDS.index(n) + 1) if n in ALL_KINDS else n for n in columns)
        + " |",
        "|---|---|" + "---|" * len(columns),
    ]
    for kind in hidden:
        cells = (str(pairs[kind, n]) if pairs[kind, n] else "" for n in columns)
        rows.append(f"| {ALL_KINDS.index(kind) + 1} | `{kind}` | " + " | ".join(cells) + " |")
    return rows


def _median(errors: Sequence[Sequence[float]], index: int) -> float:
    return float(np.median([e[index] for e in errors]))


def _between(right: int, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share, per cent."""
    z, share = 1.96, right / count
    middle = share + z**2 / (2 * count)
    half = z * np.sqrt(share * (1 - share) / count + z**2 / (4 * count**2))
    low, high = (100 * (middle + s * half) / (1 + z**2 / count) for s in (-1, 1))
    return float(low), float(high)


def row(line: Line) -> str:
    """Return one case in one line."""
    truth = " + ".join(f"{t['kind']} at {t['at']}" for t in line["truth"]) or line["what"] or "nothing"
    effects = " + ".join(f"{s['kind']} at {s['at']}" for s in line["steps"]) or "nothing"
    mark = "alias" if line["by_alias"] else "right" if line["right"] else "WRONG"
    belief = f"p {line['steps'][0]['probability']:.2f}" if line["steps"] else ""
    trouble = line["trouble"].strip().splitlines()[-1] if line["trouble"] else ""
    return (
        f"{line['number']:4d} {mark:5s} {line['type']:8s} gap {line['gap']:8.1f} -> "
        f"{line.get('remaining_gap', float('nan')):7.2f}  {truth:44s} named {effects:44s} "
        f"{line['verdict']:15s} {belief} {line['seconds']:.1f} s {trouble}"
    )
