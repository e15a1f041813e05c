"""Correlation of measured FRFs with those of a model at the same points and lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.reply import Matrix
from modallab.correlation.frequency_response import fdac, frac, ridge
from modallab.correlation.settings import RESPONSES
from modallab.fe.receptance import receptance
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True, eq=False)
class ResponseCorrelation:
    """FRAC by FRF and FDAC by line, at the points that measurement and model share."""

    outputs: tuple[Dof, ...]
    """Common response DoFs as measured, with their signs."""
    inputs: tuple[Dof, ...]
    """Common force DoFs as measured, with their signs."""
    frac: Matrix
    """(n_out, n_in) frequency response assurance criterion (FRAC), 0 to 1."""
    freq: FloatArray
    """Hz, (n_lines,) lines of both axes of the FDAC, a selection of the measured lines."""
    fdac: FloatArray
    """(n_in, n_lines, n_lines) frequency domain assurance criterion (FDAC), measured by model line."""
    frequency_scale: float | None = None
    """Measured over model frequency along the FDAC's ridge: about 1.1 for a structure 21 % stiffer than the
    model. None for a single response, or without a maximum between 1/1.5 and 1.5."""
    fdac_on_ridge: float | None = None
    """Mean FDAC along the ridge."""
    fdac_unscaled: float | None = None
    """Mean FDAC at equal frequencies."""
    notes: tuple[str, ...] = ()
    """Remarks, in sentences."""

    def __post_init__(self) -> None:
        n = len(self.freq)
        shapes = {
            "freq": (n,),
            "frac": (len(self.outputs), len(self.inputs)),
            "fdac": (len(self.inputs), n, n),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))


def compare_responses(measured: FrfSet, system: DynamicSystem) -> ResponseCorrelation:
    """Return the correlation of measured FRFs with a model's at the same points and lines.

    The model is without the masses of a rig. Points that are not in the model and the line at 0 Hz are
    left out.

    Raises
    ------
    InvalidInputError
        If the two share no output or no input, or there is no line above 0 Hz.
    """
    common = _common_responses(measured, system)
    freq = common.freq
    computed = _responses(system, common, freq)
    n_plotted = min(
        len(freq), RESPONSES.plotted_lines, int(np.sqrt(RESPONSES.max_plotted_values / len(common.inputs)))
    )
    plotted = np.unique(np.linspace(0, len(freq) - 1, n_plotted).round().astype(int))
    scale: tuple[float | None, ...] = (None, None, None)
    if len(common.outputs) > 1 and len(freq) > 1:  # one response alone has no shape
        scale = _ridge(system, common)
    n_omitted = sum(len(dofs) for dofs in (measured.outputs, measured.inputs))
    n_omitted -= sum(len(dofs) for dofs in (common.outputs, common.inputs))
    return ResponseCorrelation(
        outputs=common.outputs,
        inputs=common.inputs,
        frac=frac(common.values, computed),
        freq=freq[plotted],
        fdac=fdac(common.values[plotted], computed[plotted]),
        frequency_scale=scale[0],
        fdac_on_ridge=scale[1],
        fdac_unscaled=scale[2],
        notes=(f"{n_omitted} measured points are none of the model's",) if n_omitted else (),
    )


def _common_responses(measured: FrfSet, system: DynamicSystem) -> FrfSet:
    """Return the measured FRFs at points of the model and lines above 0 Hz."""
    model_dofs = set(system.dofs)
    rows = [i for i, dof in enumerate(measured.outputs) if dof.point in model_dofs]
    columns = [i for i, dof in enumerate(measured.inputs) if dof.point in model_dofs]
    for name, indices, dofs in (("outputs", rows, measured.outputs), ("inputs", columns, measured.inputs)):
        if not indices:
            raise InvalidInputError(
                f"the model has none of the measured {name}",
                field=name,
                value=[str(dof) for dof in dofs[:5]],
                allowed=[str(dof) for dof in system.dofs[:5]],
            )
    lines = measured.freq > 0
    if not lines.any():
        raise InvalidInputError(
            "there is no line above 0 Hz",
            field="freq",
            value=0.0,
            allowed=bounds(exclusive_minimum=0, unit="Hz"),
        )
    return FrfSet(
        freq=measured.freq[lines],
        values=measured.values[lines][:, rows][:, :, columns],
        outputs=tuple(measured.outputs[i] for i in rows),
        inputs=tuple(measured.inputs[i] for i in columns),
        kind=measured.kind,
    )


def _responses(system: DynamicSystem, like: FrfSet, freq: FloatArray) -> ComplexArray:
    """Return the model's FRFs at other lines, (n_freq, n_out, n_in), of the same points and kind."""
    alpha = receptance(system, freq, system.selection(like.outputs), system.selection(like.inputs))
    factor = (2j * np.pi * freq) ** FrfKind.RECEPTANCE.steps_to(like.kind)
    return np.asarray(alpha * factor[:, None, None])


def _ridge(system: DynamicSystem, measured: FrfSet) -> tuple[float | None, float | None, float]:
    """Return the frequency scale of the FDAC's ridge, and the means on it and at equal frequencies."""
    freq = measured.freq
    ends = np.log(max(freq[0], RESPONSES.ridge_start * freq[-1])), np.log(freq[-1])
    grid, step = np.linspace(*ends, RESPONSES.ridge_lines, retstep=True)
    even = np.exp(grid)
    flat = measured.values.reshape(len(freq), -1)
    fine = np.stack([np.interp(even, freq, column) for column in flat.T], axis=1)
    computed = _responses(system, measured, even)
    return ridge(fdac(fine.reshape(RESPONSES.ridge_lines, *measured.values.shape[1:]), computed), float(step))
