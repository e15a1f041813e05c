"""JSON and npz to studies; pure."""

from collections.abc import Sequence

from modallab_client import studies
from modallab_client._wire import Arrays, Json, floats, texts


def study(data: Json) -> studies.Study:
    """Return a study."""
    return studies.Study(
        id=data["id"],
        method=data["method"],
        levels=texts(level["name"] for level in data["levels"]),
        divisions=texts(data["divisions"]),
        seeds=tuple(map(int, data["seeds"])),
        wrong={
            part: {int(member): float(value) for member, value in table.items()}
            for part, table in data["wrong"].items()
        },
        cells=tuple(_cell(one) for one in data["table"]),
        runs=tuple(_run(one) for one in data["runs"]),
    )


def _cell(data: Json) -> studies.StudyCell:
    return studies.StudyCell(
        level=data["level"],
        division=data["division"],
        n_runs=int(data["n_runs"]),
        n_failed=int(data["n_failed"]),
        n_converged=int(data["n_converged"]),
        suspected=float(data["suspected"]),
        unfounded=float(data["unfounded"]),
        coefficient_error=_pair(data.get("coefficient_error")),
        frequency_error=_pair(data.get("frequency_error")),
        coverage=data.get("coverage"),
    )


def _pair(values: Sequence[float] | None) -> tuple[float, float] | None:
    return None if values is None else (float(values[0]), float(values[1]))


def _run(data: Json) -> studies.StudyRun:
    return studies.StudyRun(
        level=data["level"],
        division=data["division"],
        seed=int(data["seed"]),
        converged=bool(data["converged"]),
        stopped_because=data["stopped_because"],
        suspected={part: tuple(map(int, found)) for part, found in data["suspected"].items()},
        all_suspected=bool(data["all_suspected"]),
        n_unfounded=int(data["n_unfounded"]),
        coefficient_error=data.get("coefficient_error"),
        frequency_error=data.get("frequency_error"),
        coverage=data.get("coverage"),
    )


def coefficients(given: Arrays) -> studies.StudyCoefficients:
    """Return the coefficients that all runs found."""
    members = tuple(int(number) for number in given["members"])
    return studies.StudyCoefficients(
        texts(given["parts"]), members, floats(given["true"]), floats(given["coefficients"])
    )
