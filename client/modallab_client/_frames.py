"""Results as tables of pandas and as labelled arrays of xarray; each is an extra."""

from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client._plots import UNITS
from modallab_client.errors import MissingExtraError

if TYPE_CHECKING:
    from modallab_client.results import Measurement, ModalModel


def modes(model: "ModalModel") -> Any:
    """Return one row a mode: frequency, loss factor, their standard errors and scatter."""
    try:
        import pandas
    except ImportError as error:
        raise _missing("to_pandas", "pandas") from error
    rows = []
    for number, mode in enumerate(model.modes, 1):
        row: dict[str, Any] = {"mode": number}
        for name in ("frequency", "loss_factor"):
            spread = getattr(mode, f"{name}_spread")
            row |= {name: getattr(mode, name), f"{name}_error": mode.standard_errors.get(name)}
            if spread is not None:
                row |= {f"{name}_{part}": getattr(spread, part) for part in ("min", "max", "mean", "sd")}
        rows.append(row | {"flags": ", ".join(mode.flag_counts)})
    return pandas.DataFrame(rows).set_index("mode") if rows else pandas.DataFrame()


def measurement(test: "Measurement") -> Any:
    """Return FRFs, coherence and auto spectra by frequency, response and force."""
    try:
        import xarray
    except ImportError as error:
        raise _missing("to_xarray", "xarray") from error
    axes = ("freq", "output", "input")
    unit = UNITS.get(test.kind, "")
    described = {
        "frf": (test.values, unit),
        "coherence": (test.coherence, "1"),
        "force_spectrum": (test.force_spectrum, "N²/Hz"),
        "response_spectrum": (test.response_spectrum, "unit²/Hz"),
    }
    variables = {
        name: (axes[: np.ndim(values)], values, {"units": units})
        for name, (values, units) in described.items()
        if values is not None
    }
    places = {
        "freq": ("freq", test.freq, {"units": "Hz"}),
        "output": list(test.outputs),
        "input": list(test.inputs),
    }
    attributes = {"id": test.id, "kind": test.kind, "averages": test.averages}
    return xarray.Dataset(variables, places, attributes)


def _missing(function: str, package: str) -> MissingExtraError:
    return MissingExtraError(f"{function} needs {package}: pip install 'modallab[tables]'")
