"""Contents of a universal file, for error messages."""

from collections import Counter

from modallab.interchange.uff_split import Dataset, split

_FUNCTIONS = {
    0: "functions of no type",
    1: "time responses",
    2: "auto spectra",
    3: "cross spectra",
    4: "FRFs",
    5: "transmissibilities",
    6: "coherences",
    7: "auto correlations",
    8: "cross correlations",
    9: "power spectral densities",
    10: "energy spectral densities",
    11: "probability densities",
    12: "spectra",
    26: "multiple coherences",
    27: "orders",
}
_DATA_TYPES = {
    0: "unknown",
    1: "general",
    2: "stress",
    3: "strain",
    5: "temperature",
    6: "heat flux",
    8: "displacement",
    9: "reaction force",
    11: "velocity",
    12: "acceleration",
    13: "force",
    15: "pressure",
    16: "mass",
    17: "time",
    18: "frequency",
    19: "rpm",
    20: "order",
}
_DATASETS = {
    15: "nodes",
    18: "coordinate systems",
    55: "data at nodes",
    82: "trace lines",
    151: "header",
    164: "units",
    1858: "qualifiers",
    2400: "model header",
    2411: "nodes",
    2412: "elements",
    2414: "analysis data",
    2420: "coordinate systems",
    2467: "groups",
}


def contents(payload: bytes) -> str:
    """Return the datasets of a universal file with their counts: `2 time responses (58), nodes (15)`.

    Parameters
    ----------
    payload
        The file, which has been read before.
    """
    counts = Counter(map(_name, split(payload, {}, ())))
    return ", ".join(f"{count} {name}" if count > 1 else name for name, count in counts.items())


def data_type(number: int) -> str:
    """Return the quantity of a specific data type."""
    return _DATA_TYPES.get(number, f"of type {number}")


def _name(dataset: Dataset) -> str:
    if dataset.kind is not None:
        return f"{_FUNCTIONS.get(dataset.kind, f'functions of type {dataset.kind}')} (58)"
    return f"{_DATASETS.get(dataset.number, 'dataset')} ({dataset.number})"
