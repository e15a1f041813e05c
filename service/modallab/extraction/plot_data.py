"""Data of plots of a single-mode fit, computed again from the measured responses."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.core.modal_model import ModalModel
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.reply import BoolVector, ComplexVector, NanFloat, Vector
from modallab.extraction.method_options import options_type
from modallab.extraction.options import MIN_LINES, Damping, ExtractionOptions
from modallab.extraction.preprocessing.fit_windows import Windows, window_stride, without_nearest
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.settings import FIT_PLOT
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS, DampingModel
from modallab.extraction.single_mode.fit_data import FitData, window_data
from modallab.extraction.single_mode.fit_table import ConvergedFits
from modallab.extraction.single_mode.fitting import fit_all
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit
from modallab.extraction.single_mode.plan import choice_value


@dataclass(frozen=True, eq=False)
class FitPlotData:
    """One fit: measured lines, lines without leakage and other modes, and the mode through them."""

    method: str
    """Single-mode method."""
    damping: Damping
    """Damping model; with viscous damping `x...` of the details is omega, rad/s, instead of omega^2."""
    kind: FrfKind
    """Kind of all responses: the one that the mode was fitted to."""
    freq: Vector
    """(n_lines,) Hz."""
    used: BoolVector
    """(n_lines,) False where a line was left out."""
    measured: ComplexVector
    """(n_lines,) measured response."""
    cleaned: ComplexVector
    """(n_lines,) response without leakage and without the other modes."""
    curve_freq: Vector
    """(n_curve,) Hz."""
    curve: ComplexVector
    """(n_curve,) mode and residual."""
    frequency: float
    """Hz, natural frequency."""
    loss_factor: float
    """Structural loss factor."""
    modal_constant: complex
    """1/kg, of receptance."""
    residual: complex
    """Unit of the responses, constant beside the mode."""
    details: Mapping[str, FloatArray | ComplexArray]
    """Arrays of the method's plot; empty for fewer than four lines."""

    quality: Mapping[str, NanFloat]
    """%, measures of quality that only this method has."""

    def __post_init__(self) -> None:
        n = len(self.freq)
        for name, of, shape in (
            ("freq", float, (n,)),
            ("used", bool, (n,)),
            ("measured", complex, (n,)),
            ("cleaned", complex, (n,)),
            ("curve_freq", float, (None,)),
            ("curve", complex, (len(self.curve_freq),)),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), of, shape, name=name))


def fit_plot_data(
    responses: Responses, model: ModalModel, mode: int, row: int, *, leakage: WindowLeakage | None = None
) -> FitPlotData:
    """Return one of the fits of a modal model.

    The other modes are subtracted as the model has them, and the mode is fitted to the same lines again.

    Parameters
    ----------
    responses
        Responses of the model.
    model
        From a single-mode method.
    mode, row
        Index of the mode, and of the FRF.
    leakage
        As in `extract`.

    Raises
    ------
    InvalidInputError
        If there is no such fit, or the model is not from single-mode fits.
    """
    ends = _ends(responses, model)
    for name, value, n in (("mode", mode, len(ends)), ("row", row, ends.shape[1])):
        if not 0 <= value < n:
            raise InvalidInputError(f"no such {name}", field=name, value=value, allowed=bounds(0, n - 1))
    damping = Damping(choice_value(model.choices, "damping") or Damping.STRUCTURAL)
    stride = _stride(model, ends[mode])
    leave_out = int(choice_value(model.choices, "leave_out") or 0)
    data = _window_lines(responses, ends[mode], stride, leave_out, leakage)
    settled, place = _refit(DAMPING_MODELS[damping], model, mode, row, data)
    table, mean = settled.table, model.modes[mode]
    identified = bool(
        table.frequency[0, place] > 0
    )  # where it was not, the modal constant is of the mean mode
    fit = ModeFit(
        float(table.frequency[0, place] if identified else mean.frequency),
        float(table.loss_factor[0, place] if identified else mean.loss_factor),
        complex(table.modal_constant[0, place]),
    )
    n_lines = int(ends[mode, row, 1] - ends[mode, row, 0]) // stride + 1
    inside = (0, row, slice(0, n_lines))
    order = 2 if settled.inertance[0] else 0
    freq = data.freq[inside]
    factor = (2j * np.pi * freq) ** order
    cleaned = factor * settled.cleaned[0, place, :n_lines]
    fitted_lines = _FittedLines(freq, cleaned, data.weight[inside] / np.abs(factor) ** 2, order)
    return _plot_data(model, damping, fit, fitted_lines, factor * data.receptance[inside])


def _refit(
    damping_model: DampingModel, model: ModalModel, mode: int, row: int, data: FitData
) -> tuple[ConvergedFits, int]:
    """Return the fit of one FRF, and its index among the fits computed for it.

    All FRFs together decided to which kind of response the mode was fitted: it is the kind that reproduces
    the frequency. The drive point is fitted too where it is needed for the leakage correction. A rejected fit
    has no frequency for this comparison: then all FRFs are fitted.
    """
    method = EXTRACTION_METHODS[model.method].with_options(_options(model))
    fitted = np.nan if model.fitted_frequency is None else float(model.fitted_frequency[mode, row])
    if not np.isfinite(fitted):
        rows = np.arange(data.freq.shape[1])
        return fit_all(method, damping_model, data, _other_modes(damping_model, model, mode, data, rows)), row
    drive = None if data.leakage is None else data.drive
    rows = np.unique([row] if drive is None else [row, drive])
    selection = FitData(
        data.freq[:, rows],
        data.receptance[:, rows],
        data.weight[:, rows],
        data.spacing,
        data.leakage,
        None if drive is None else int(np.searchsorted(rows, drive)),
    )
    other_modes, place = (
        _other_modes(damping_model, model, mode, selection, rows),
        int(np.searchsorted(rows, row)),
    )
    candidates = [
        fit_all(method, damping_model, selection, other_modes, inertance=np.array([kind]))
        for kind in (False, True)
    ]
    distance = [abs(float(candidate.table.frequency[0, place]) - fitted) for candidate in candidates]
    return candidates[int(np.argmin(distance))], place


@dataclass(frozen=True, eq=False)
class _FittedLines:
    """Lines of a fit."""

    freq: Vector
    """(n_lines,) Hz."""
    frf: ComplexArray
    """(n_lines,) without leakage and other modes."""
    weight: FloatArray
    """(n_lines,) one over E|error|^2."""
    order: int
    """Number of time derivatives of receptance in `frf`."""


def _options(model: ModalModel) -> ExtractionOptions:
    """Return the options that a modal model was extracted with."""
    return options_type(model.method)(**model.options)  # type: ignore[arg-type]


def _plot_data(
    model: ModalModel, damping: Damping, fit: ModeFit, lines: _FittedLines, measured: ComplexArray
) -> FitPlotData:
    """Return the plot data of a fit, with its residual."""
    method, options = EXTRACTION_METHODS[model.method], _options(model)
    law, freq, frf, weight = DAMPING_MODELS[damping], lines.freq, lines.frf, lines.weight
    order = np.array(lines.order)
    eigenvalue = np.array((2 * np.pi * fit.frequency) ** 2 * (1 + 1j * fit.loss_factor))
    constant = np.array(fit.modal_constant)

    def mode_response(line_freq: FloatArray) -> ComplexArray:
        return np.asarray((2j * np.pi * line_freq) ** order * law.response(line_freq, eigenvalue, constant))

    residual = complex((weight * (frf - mode_response(freq))).sum() / max(weight.sum(), SAFE_DIVISOR))
    curve_freq = np.linspace(freq[0], freq[-1], FIT_PLOT.curve_points)
    pole = frf - law.image_terms(freq, eigenvalue, constant, order)
    enough = (weight > 0).sum() >= MIN_LINES
    details = method.plot_with_options(options)(law.abscissa(freq), pole, weight) if enough else {}
    refit = law.fit(method.with_options(options), freq[None], frf[None], weight[None], order[None])
    return FitPlotData(
        method=model.method,
        damping=damping,
        kind=FrfKind.INERTANCE if lines.order else FrfKind.RECEPTANCE,
        freq=freq,
        used=weight > 0,
        measured=measured,
        cleaned=frf,
        curve_freq=curve_freq,
        curve=mode_response(curve_freq) + residual,
        frequency=fit.frequency,
        loss_factor=fit.loss_factor,
        modal_constant=fit.modal_constant,
        residual=residual,
        details={
            name: values * law.loss_per_pole if name == "damping_surface" else values
            for name, values in details.items()
        },
        quality={name: float(values[0]) for name, values in refit.quality.items()},
    )


def _ends(responses: Responses, model: ModalModel) -> IntArray:
    """Return the lines of the fits, (n_modes, n_frf, 2), if the model has them for these FRFs."""
    if model.method not in EXTRACTION_METHODS or model.fitted_lines is None:
        raise InvalidInputError(
            "these modes are not from fits of single modes",
            field="method",
            value=model.method,
            allowed=list(EXTRACTION_METHODS),
        )
    if model.frfs != responses.frfs or model.fitted_lines.max(initial=0) >= len(responses.freq):
        raise InvalidInputError(
            "these responses are not those that the modes were identified from",
            field="responses",
            value=len(responses.frfs),
            allowed="the measurement behind the modal model",
        )
    return model.fitted_lines


def _stride(model: ModalModel, ends: IntArray) -> int:
    """Return the distance, in lines, of the lines of a mode's fits; requested lines are all used."""
    requested = model.options.get("lines") is not None
    return 1 if requested else window_stride(int(np.diff(ends, axis=1).max()) + 1)


def _window_lines(
    responses: Responses, ends: IntArray, stride: int, leave_out: int, leakage: WindowLeakage | None
) -> FitData:
    """Return the lines of one mode in every FRF, as they were fitted; `ends` (n_frf, 2)."""
    count = (ends[:, 1:] - ends[:, :1]) // stride + 1
    offset = np.arange(count.max())
    index = np.minimum(ends[:, :1] + stride * offset, len(responses.freq) - 1)
    used = offset < count
    if leave_out:
        columns = np.arange(len(ends))[:, None]
        used = without_nearest(np.abs(responses.mobility)[index, columns], used, leave_out)
    windows = Windows(index[None], used[None], ends[None], np.array([stride]))
    receptance, variance = responses.receptance, responses.variance
    return window_data(responses.freq, receptance, variance, windows, leakage, responses.drive_row)


def _other_modes(
    damping_model: DampingModel, model: ModalModel, mode: int, data: FitData, rows: IntArray
) -> ComplexArray:
    """Return the receptance of all other modes of the model, (1, n_rows, n_lines)."""
    response = np.zeros_like(data.receptance)
    if model.modal_constant is None or model.fitted_frequency is None or model.fitted_loss_factor is None:
        return response
    for m, mean_mode in enumerate(model.modes):
        if m != mode:
            identified = np.isfinite(model.fitted_frequency[m, rows])
            frequency = np.where(identified, model.fitted_frequency[m, rows], mean_mode.frequency)
            loss_factor = np.where(identified, model.fitted_loss_factor[m, rows], mean_mode.loss_factor)
            eigenvalue = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
            constant = model.modal_constant[m, rows]
            response += damping_model.response(data.freq, eigenvalue[:, None], constant[:, None])
    return response
