"""Every mode in every FRF: fitted together, each freed of the others in turn."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.progress import Progress, silent
from modallab.extraction.preprocessing.fit_windows import Windows
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.method import ExtractionMethod, ModeFits
from modallab.extraction.single_mode.screening import Screening, screen

ROUNDS = 3  # what neighbours leave after one subtraction is second order; the later ones settle it
LEAKY_ROUNDS = 16  # the correction for leakage needs the mode that it corrects; H1 settles slowest
# Leaked lines err most where the response is highest, and in proportion to its square: with this much
# at the peak the fit rests on the flanks, from where the correction converges for 0.1 line wide modes.
LEAKED = 0.1
TINY = 1e-12  # (rad/s)^2, below any line above 0 Hz


@dataclass(frozen=True, eq=False)
class Table:
    """Modes by FRFs; every array (n_modes, n_frf). Errors are standard errors, widened by the misfit."""

    frequency: FloatArray  # Hz
    loss_factor: FloatArray
    modal_constant: ComplexArray  # 1/kg, of receptance; at the other FRFs' eigenvalue where not good
    frequency_error: FloatArray
    loss_factor_error: FloatArray
    modal_constant_error: FloatArray
    screening: Screening
    lines: IntArray | None = None  # (n_modes, n_frf, 2) first and last that each fit drew on
    # (n_modes, n_frf, 2) what leakage may still move frequency, Hz, and loss factor by; None where none leaks
    leakage_bias: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Data:
    """The lines of every fit, (n_modes, n_frf, n_lines), and how they were taken."""

    freq: FloatArray  # Hz
    receptance: ComplexArray  # m/N
    weight: FloatArray  # one over E|error|^2, 0 for a line not used
    spacing: float  # of the lines, Hz
    leakage: WindowLeakage | None
    drive: int | None  # which FRF is that of the drive point

    @property
    def x(self) -> FloatArray:
        """omega^2, (rad/s)^2."""
        return (2 * np.pi * self.freq) ** 2


def gather(
    freq: FloatArray,
    receptance: ComplexArray,
    variance: FloatArray,
    windows: Windows,
    leakage: WindowLeakage | None,
    drive: int | None,
) -> Data:
    """Return the lines inside the windows; `freq` (n_freq,), the others (n_freq, n_frf)."""
    column = np.arange(receptance.shape[1])[None, :, None]
    values = receptance[windows.index, column]
    noise = variance[windows.index, column]
    if leakage is not None:
        inside = windows.index <= windows.ends[:, :, 1:]  # lines left out, next to the peak, tell its height
        power = np.where(inside, np.abs(values) ** 2, 0.0)
        peak = power.max(axis=2, keepdims=True)
        noise = noise + LEAKED**2 * power * (power / np.where(peak > 0, peak, 1.0))
    usable = windows.used & np.isfinite(noise) & (noise > 0)
    weight = np.where(usable, 1 / np.where(usable, noise, 1.0), 0.0)
    spacing = float(np.median(np.diff(freq)))
    return Data(freq[windows.index], values, weight, spacing, leakage, drive)


@dataclass(frozen=True, eq=False)
class Settled:
    """Fits that do not change any more, and what the last of them saw."""

    table: Table
    cleaned: ComplexArray  # (n_modes, n_frf, n_lines) m/N, freed of leakage and other modes
    others: ComplexArray  # (n_modes, n_frf, n_lines) m/N, the other modes
    inertance: BoolArray  # (n_modes,) True where the mode was fitted on inertance


def fit_all(
    method: ExtractionMethod,
    law: DampingModel,
    data: Data,
    known: ComplexArray | float = 0.0,
    progress: Progress = silent,
    inertance: BoolArray | None = None,
) -> Settled:
    """Return every mode in every FRF.

    One window at a time, a single mode and a constant are fitted; then the other modes are taken off every
    window and the fits repeated. The constant stands for what lies outside the range: it is one in
    inertance for rigid bodies, in receptance for higher modes, so both are tried and each mode keeps the
    kind with the smaller misfit. In inertance too a mode is a mode and a constant. An FRF that does
    not show a mode has its modal constant from linear least squares at the eigenvalue of the others.

    Parameters
    ----------
    method, law
        How a mode is fitted, and what its damping does.
    known
        (n_modes, n_frf, n_lines) receptance of modes that are not to be fitted again, m/N.
    progress
        Told of every round.
    inertance
        (n_modes,) True where a mode is to be fitted on inertance; None: the better kind, as above.
    """
    others = np.zeros_like(data.receptance) + known
    undone = np.ones_like(data.receptance)
    rounds = ROUNDS if data.leakage is None else LEAKY_ROUNDS
    for n in range(rounds):
        progress(n / (rounds + 1), f"round {n + 1} of {rounds + 1}")
        now = fit_once(method, law, data, data.receptance * undone - others, inertance)
        others = _others(law, data, now.table.modal_constant, now.eigenvalue) + known
        if data.leakage is not None:
            step = undoing(law, data, data.leakage, now, now.rest + others)
            # modes much narrower than a line swing about the answer unless the late steps are halved
            share = 1.0 if n < LEAKY_ROUNDS // 2 else 0.5
            undone = (1 - share) * undone + share * step
    # the lines as they are now have no leakage left
    cleaned = data.receptance * undone - others
    last = fit_once(method, law, replace(data, leakage=None), cleaned, inertance)
    return Settled(last.table, cleaned, others, last.inertance)


@dataclass(frozen=True, eq=False)
class Round:
    """One fit of every window."""

    table: Table
    eigenvalue: ComplexArray  # (n_modes, n_frf)
    rest: ComplexArray  # receptance beside each mode, as `Data`
    inertance: BoolArray  # (n_modes,)
    widened: FloatArray  # (n_modes, n_frf) what the misfit has widened the errors by


def fit_once(
    method: ExtractionMethod,
    law: DampingModel,
    data: Data,
    target: ComplexArray,
    inertance: BoolArray | None = None,
) -> Round:
    """Return a mode and a constant fitted to every window of `target`, (n_modes, n_frf, n_lines) m/N."""
    n_modes, n_frf, n_lines = data.freq.shape
    asked = slice(None) if inertance is None else (inertance.astype(np.int64), np.arange(n_modes))
    frf = np.stack([target, -data.x * target])[asked]
    weight = np.stack([data.weight, data.weight / np.maximum(data.x, TINY) ** 2])[asked]
    rows = (frf.size // n_lines, n_lines)
    freq = np.broadcast_to(data.freq, frf.shape)
    order = np.repeat([0, 2], n_modes * n_frf) if inertance is None else np.repeat(2 * inertance, n_frf)
    fits = law.fit(method, freq.reshape(rows), frf.reshape(rows), weight.reshape(rows), order)
    if inertance is None:
        kind = _better_kind(np.where(fits.found, fits.misfit, np.inf).reshape(2, n_modes, n_frf))
        first = kind * n_modes + np.arange(n_modes)
    else:
        kind, first = inertance.astype(np.int64), np.arange(n_modes)
    pick = first[:, None] * n_frf + np.arange(n_frf)
    return _complete(law, data, fits, pick, frf.reshape(rows)[pick], weight.reshape(rows)[pick], kind == 1)


def _better_kind(misfit: FloatArray) -> IntArray:
    """Return 0 or 1 a mode: which kind leaves the lower median misfit; `misfit` (2, n_modes, n_frf)."""
    middle = np.sort(misfit, axis=2)[:, :, (misfit.shape[2] - 1) // 2]
    better: IntArray = (middle[1] < middle[0]).astype(np.int64)
    return better


def _complete(
    law: DampingModel,
    data: Data,
    fits: ModeFits,
    pick: IntArray,
    frf: ComplexArray,
    weight: FloatArray,
    inertance: BoolArray,
) -> Round:
    """Return what `fit_once` does, from the fits picked, (n_modes, n_frf), and their lines."""
    widened = np.sqrt(np.maximum(fits.misfit[pick], 1))
    frequency, loss_factor = fits.frequency[pick], fits.loss_factor[pick]
    errors = fits.frequency_error[pick] * widened, fits.loss_factor_error[pick] * widened
    screening = screen(frequency, loss_factor, *errors, fits.found[pick], data.spacing)
    found = fits.found[pick]
    # before neighbours and leakage are off, perhaps none is good: those found serve until then
    good = np.where(screening.good.any(axis=1, keepdims=True), screening.good, found)
    own = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
    n_good = good.sum(axis=1, keepdims=True)
    shared = (good * own).sum(axis=1, keepdims=True) / np.maximum(n_good, 1)
    if data.leakage is not None:
        good = found  # a line's leakage is that of the fit through it, good or not
    eigenvalue = np.where(good, own, np.where(n_good > 0, shared, 1j))
    # back from inertance: divide the response by -omega^2, the modal constant by that at the pole
    factor = np.where(inertance[:, None, None], -np.maximum(data.x, TINY), 1)
    divisor = np.where(inertance[:, None], -law.pole(eigenvalue, eigenvalue)[0], 1)
    shape = law.response(data.freq, eigenvalue[:, :, None], np.ones(1, complex))
    held, held_error = _held(frf, weight, factor * shape)
    constant = np.where(good, fits.modal_constant[pick] / divisor, held) * (n_good > 0)
    error = np.where(good, fits.modal_constant_error[pick] * widened / np.abs(divisor), held_error)
    mode = law.response(data.freq, eigenvalue[:, :, None], constant[:, :, None])
    total = weight.sum(axis=2, keepdims=True)
    residual = (weight * (frf - factor * mode)).sum(axis=2, keepdims=True) / np.where(total > 0, total, 1)
    table = Table(frequency, loss_factor, constant, *errors, error, screening)
    return Round(table, eigenvalue, residual / factor, inertance, widened)


def _held(frf: ComplexArray, weight: FloatArray, shape: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """Return the modal constant and its error, (n_modes, n_frf), of modes of known `shape`."""
    total = weight.sum(axis=2, keepdims=True)
    share = weight / np.where(total > 0, total, 1)
    shape = shape - (share * shape).sum(axis=2, keepdims=True)
    flat = frf - (share * frf).sum(axis=2, keepdims=True)
    power = (weight * np.abs(shape) ** 2).sum(axis=2)
    safe = np.where(power > 0, power, np.inf)
    constant = (weight * shape.conj() * flat).sum(axis=2) / safe
    left = flat - constant[:, :, None] * shape
    misfit = (weight * np.abs(left) ** 2).sum(axis=2) / np.maximum((weight > 0).sum(axis=2) - 2, 1)
    return constant, np.sqrt(np.maximum(misfit, 1) / 2 / safe)


def undoing(
    law: DampingModel, data: Data, leakage: WindowLeakage, now: Round, rest: ComplexArray
) -> ComplexArray:
    """Return what to multiply the measured lines by, as `data`; `rest` is the receptance beside each mode."""
    # a mode at a time, as each line has a hundred nodes of quadrature
    each = [
        leakage.correction(data.freq[m], data.spacing, *one)
        for m, one in enumerate(poles(law, data, now, rest))
    ]
    return np.stack(each)


def poles(
    law: DampingModel, data: Data, now: Round, rest: ComplexArray
) -> list[tuple[SinglePole, SinglePole]]:
    """Return each mode as a pole in inertance, in all FRFs and at the drive point; else as `undoing`."""
    squared, constant = law.pole(now.eigenvalue, now.table.modal_constant)
    mode = law.response(data.freq, now.eigenvalue[:, :, None], now.table.modal_constant[:, :, None])
    # turned to inertance, a mode is a pole and its modal constant
    pole = constant[:, :, None] / (squared[:, :, None] - data.x)
    inertance = constant[:, :, None] - data.x * (rest + mode - pole)
    at = data.drive
    if at is None:
        drive, beside = np.zeros_like(constant), np.zeros_like(rest)
    else:
        used = data.weight[:, at] > 0
        mean = (used * inertance[:, at]).sum(axis=1) / np.maximum(used.sum(axis=1), 1)
        drive = np.broadcast_to(constant[:, at, None], constant.shape)
        beside = np.broadcast_to(mean[:, None, None], rest.shape)
    return [
        (
            SinglePole(squared[m], -squared[m] * constant[m], inertance[m]),
            SinglePole(squared[m], -squared[m] * drive[m], beside[m]),
        )
        for m in range(len(squared))
    ]


def _others(law: DampingModel, data: Data, constant: ComplexArray, eigenvalue: ComplexArray) -> ComplexArray:
    """Return the receptance of all modes but its own in every window, (n_modes, n_frf, n_lines)."""
    others = np.zeros_like(data.receptance)
    for m in range(len(constant)):  # all at once would be the square of the modes in memory
        each = law.response(data.freq, eigenvalue[m][:, None], constant[m][:, None])
        each[m] = 0
        others += each
    return others
