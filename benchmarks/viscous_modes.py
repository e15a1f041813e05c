"""Six viscous modes in noisy FRFs made by formula: errors against standard errors and Cramer-Rao bounds.

python -m benchmarks.viscous_modes 100                     # one set of shapes, beside sdypy-EMA
python -m benchmarks.viscous_modes 5 --seeds 3 7 100       # several sets: are all modes found?
"""

import contextlib
import importlib.util
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.bench import Bench, parser
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.extract import extract

FREQUENCY = np.array([30.0, 42.0, 43.0, 70.0, 95.0, 110.0, 260.0])  # Hz, the last one above the lines
DAMPING_RATIO = np.array([0.005, 0.01, 0.012, 0.003, 0.02, 0.008, 0.01])
N_IN_BAND, PAIR = 6, slice(1, 3)
FREQ: FloatArray = np.linspace(0.0, 150.0, 1201)  # Hz, 0 to 150
N_FRF = 12
SHAPES_SEED = 1
OTHER_SEEDS = (3, 7, 100, *range(200, 207))  # of which each fits a twentieth of the draws
# Largest modal constant over its bound from which a mode must be found: a fit accepts modes from five
# standard errors on, and noise takes three off.
VISIBLE = 8.0
LEVELS = (60, 40, 30)  # dB of each FRF's rms above the rms of its noise
NOISY = 30  # where the limits are at least three times the bound
N_DRAWS = 100

LARGEST_FREQUENCY_ERROR, LARGEST_DAMPING_ERROR = 2e-4, 1e-2  # relative
LARGEST_RATIO = 1.3  # RMS error over the bound
WITHIN = {1: (0.60, 0.75), 2: (0.92, 0.98)}  # share of errors within so many standard errors


def natural_poles() -> ComplexArray:
    """Return the poles s, (7,) rad/s."""
    natural = 2 * np.pi * FREQUENCY
    return np.asarray(natural * (-DAMPING_RATIO + 1j * np.sqrt(1 - DAMPING_RATIO**2)))


def modal_constants(seed: int = SHAPES_SEED) -> FloatArray:
    """Return the modal constants of standard normal shapes, driven at the first DoF, (7, 12) 1/kg."""
    shapes = np.random.default_rng(seed).standard_normal((len(FREQUENCY), N_FRF))
    return np.asarray(shapes * shapes[:, :1])


def inertance(freq: FloatArray, constants: FloatArray) -> ComplexArray:
    """Return `-omega^2 sum A/(omega_r^2 - omega^2 + 2 i zeta omega_r omega)`, (n_lines, n_frf)."""
    omega, natural = 2 * np.pi * freq[:, None], 2 * np.pi * FREQUENCY
    modes = 1 / (natural**2 - omega**2 + 2j * DAMPING_RATIO * natural * omega)
    return np.asarray(-(omega**2) * (modes @ constants))


def noise_of(exact: ComplexArray, level: int) -> FloatArray:
    """Return the rms of the noise of each FRF, (n_frf,), `level` dB below the FRF's."""
    return np.asarray(np.sqrt((np.abs(exact) ** 2).mean(axis=0)) * 10 ** (-level / 20))


def drawn(exact: ComplexArray, level: int, draw: int) -> ComplexArray:
    """Return the FRFs with circular noise."""
    parts = np.random.default_rng([level, draw]).standard_normal((2, *exact.shape))
    return np.asarray(exact + noise_of(exact, level) * (parts[0] + 1j * parts[1]) / np.sqrt(2))


def bounds(constants: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the Cramer-Rao bounds of frequency, Hz, and damping ratio of the modes in the band, (2, 6).

    The unknowns are the poles of all seven modes and their complex constants in every FRF.
    """
    omega = 2 * np.pi * FREQ[:, None]
    s = natural_poles()
    upper, lower = 1 / (1j * omega - s), 1 / (1j * omega - s.conj())
    linear = -(omega[..., None] ** 2) * np.stack([upper + lower, 1j * (upper - lower)], axis=2)
    slopes = -(omega[..., None] ** 2) * np.stack([upper**2 + lower**2, 1j * (upper**2 - lower**2)], axis=2)
    columns = linear.reshape(len(FREQ), -1)
    columns = np.concatenate([columns.real, columns.imag])
    directions = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))[0]
    fisher = np.zeros((2 * len(s), 2 * len(s)))
    for constant, sd in zip((constants / (2j * s.imag[:, None])).T, noise, strict=True):
        # residue R: R/(i omega - s)^2 by s, and its conjugate by conj(s)
        turned = np.stack(
            [
                constant.real[:, None] * slopes[:, :, 0].T + constant.imag[:, None] * slopes[:, :, 1].T,
                constant.real[:, None] * slopes[:, :, 1].T - constant.imag[:, None] * slopes[:, :, 0].T,
            ],
            axis=1,
        ).reshape(2 * len(s), -1)
        stacked = np.concatenate([turned.real, turned.imag], axis=1).T
        free = stacked - directions @ (directions.T @ stacked)
        fisher += 2 / sd**2 * (free.T @ free)
    covariance = np.linalg.inv(fisher)
    # frequency |s|/2 pi and damping ratio -Re s/|s| by real and imaginary part of s
    size = np.abs(s)
    jacobian = np.stack(
        [
            np.stack([s.real / size, s.imag / size], axis=1) / (2 * np.pi),
            np.stack([-(s.imag**2), s.real * s.imag], axis=1) / size[:, None] ** 3,
        ]
    )
    blocks = covariance.reshape(len(s), 2, len(s), 2)[np.arange(len(s)), :, np.arange(len(s))]
    return np.asarray(np.sqrt(np.einsum("qra,rab,qrb->qr", jacobian, blocks, jacobian))[:, :N_IN_BAND])


def visibility(constants: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the largest modal constant of each mode over its Cramer-Rao bound for known poles, (6,)."""
    omega, s = 2 * np.pi * FREQ[:, None], natural_poles()
    upper, lower = 1 / (1j * omega - s), 1 / (1j * omega - s.conj())
    columns = -(omega[..., None] ** 2) * np.stack([upper + lower, 1j * (upper - lower)], axis=2)
    columns = columns.reshape(len(FREQ), -1)
    columns = np.concatenate([columns.real, columns.imag])
    length = np.linalg.norm(columns, axis=0)
    inverse = np.linalg.inv((columns / length).T @ (columns / length)) / np.outer(length, length)
    # noise of either part is half of the variance; the residue is A/(2 i omega_d), here imaginary
    bound = np.sqrt(np.diag(inverse)[1::2, None] / 2) * noise
    residue = np.abs(constants) / (2 * s.imag[:, None])
    return np.asarray((residue / bound).max(axis=1)[:N_IN_BAND])


@dataclass(frozen=True, eq=False)
class Extracted:
    """Modes of the draws at one level."""

    values: FloatArray
    """(n_draws, 2, 6) frequency, Hz, and damping ratio; NaN in a draw with other than six modes."""
    errors: FloatArray
    """(n_draws, 2, 6) their standard errors."""


Reader = Callable[[ComplexArray], tuple[FloatArray, FloatArray]]


def ours(values: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the modes of `lscf` with default options, and their standard errors, both (2, n)."""
    dofs = tuple(Dof(n + 1, "Z") for n in range(values.shape[1]))
    frf = FrfSet(FREQ, values[:, :, None], dofs, dofs[:1], FrfKind.INERTANCE)
    model = extract(frf, coherence=None, averages=1.0, method="lscf")
    errors = [[mode.standard_errors[name] for mode in model.modes] for name in ("frequency", "loss_factor")]
    halves = np.array([[1.0], [0.5]])  # the damping ratio is half the loss factor
    return halves * np.array([model.frequencies, model.loss_factors]), halves * np.array(errors)


def peer(values: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the poles of sdypy-EMA at order 60 nearest the true frequencies, without standard errors."""
    from sdypy import EMA  # type: ignore[import-not-found]

    model = EMA.Model(frf=values.T, freq=FREQ, lower=1, upper=150, pol_order_high=60, frf_form="accelerance")
    with contextlib.redirect_stderr(io.StringIO()):  # a progress bar
        model.get_poles(show_progress=False)
    frequency, ratio = np.asarray(model.pole_freq[-1]), np.asarray(model.pole_xi[-1])
    damped = ratio > 0
    nearest = np.abs(frequency[damped] - FREQUENCY[:N_IN_BAND, None]).argmin(axis=1)
    found = np.array([frequency[damped][nearest], ratio[damped][nearest]], float)
    return found, np.full(found.shape, np.nan)


def extracted(read: Reader, level: int, n_draws: int, seed: int = SHAPES_SEED) -> Extracted:
    """Return the modes of each draw."""
    exact = inertance(FREQ, modal_constants(seed))
    values, errors = np.full((2, n_draws, 2, N_IN_BAND), np.nan)
    for n in range(n_draws):
        try:
            found, error = read(drawn(exact, level, n))
        except NoModeInBandError:
            continue
        if found.shape[1] == N_IN_BAND:
            values[n], errors[n] = found, error
    return Extracted(values, errors)


def compared(result: Extracted, level: int, seed: int = SHAPES_SEED) -> dict[str, float]:
    """Return the draws without the six modes, the worst errors of the pair, and errors over bounds."""
    constants = modal_constants(seed)
    truth = np.array([FREQUENCY[:N_IN_BAND], DAMPING_RATIO[:N_IN_BAND]])
    bound = bounds(constants, noise_of(inertance(FREQ, constants), level))
    found = np.isfinite(result.values).all(axis=(1, 2))
    error = result.values[found] - truth
    allowed = np.array([[LARGEST_FREQUENCY_ERROR], [LARGEST_DAMPING_ERROR]]) * truth
    if level == NOISY:
        allowed = np.maximum(allowed, 3 * bound)
    scores = np.abs(error / result.errors[found])
    pair = (np.abs(error) / allowed)[:, :, PAIR]
    root_mean_square = np.sqrt((error**2).mean(axis=0)) / bound
    return {
        "draws without exactly six modes": float(np.count_nonzero(~found)),
        "pair, worst frequency over its limit": float(pair[:, 0].max(initial=0.0)),
        "pair, worst damping over its limit": float(pair[:, 1].max(initial=0.0)),
        "RMS error over Cramer-Rao bound, worst mode": float(root_mean_square.max()),
        "RMS error over Cramer-Rao bound, mean": float(root_mean_square.mean()),
        **{f"% within {n} standard errors": 100 * float((scores < n).mean()) for n in WITHIN},
    }


def found_modes(seed: int, level: int, n_draws: int) -> tuple[int, FloatArray]:
    """Return in how many draws not all visible modes are found, or others, and the invisible ones, Hz."""
    constants = modal_constants(seed)
    exact = inertance(FREQ, constants)
    hidden = visibility(constants, noise_of(exact, level)) < VISIBLE
    truth, width = FREQUENCY[:N_IN_BAND], (2 * DAMPING_RATIO * FREQUENCY)[:N_IN_BAND]
    wrong = 0
    for n in range(n_draws):
        try:
            frequency = ours(drawn(exact, level, n))[0][0]
        except NoModeInBandError:
            frequency = np.zeros(0)
        near = np.abs(frequency[:, None] - truth) < width / 2
        wrong += (
            not ((near.sum(axis=0) == 1) | hidden & ~near.any(axis=0)).all() or not near.any(axis=1).all()
        )
    return wrong, truth[hidden]


def found_rows(seeds: Sequence[int], n_draws: int) -> Iterator[tuple[str, float, float]]:
    """Yield the draws of each set of shapes with wrong modes; modes too weak to be seen do not count."""
    for seed in seeds:
        for level in LEVELS:
            wrong, hidden = found_modes(seed, level, n_draws)
            name = f"viscous modes, {level} dB, shapes of seed {seed}: of {n_draws} draws with wrong modes"
            if len(hidden):
                weak = ", ".join(f"{frequency:g} Hz" for frequency in hidden)
                name += f" (below {VISIBLE:g} bounds in every FRF: {weak})"
            yield name, float(wrong), 0.0


def run(n_draws: int = N_DRAWS, seeds: Sequence[int] = OTHER_SEEDS) -> list[tuple[str, float, float]]:
    """Return (name, value, limit)."""
    rows = list(found_rows(seeds, max(n_draws // 20, 1)))
    for level in LEVELS:
        figures = compared(extracted(ours, level, n_draws), level)
        names = [name for name in figures if "%" not in name and "mean" not in name]
        limits = dict(zip(names, (0.0, 1.0, 1.0, LARGEST_RATIO), strict=True))
        rows += [(f"viscous modes, {level} dB: {name}", figures[name], limits[name]) for name in names]
        for n, (least, most) in WITHIN.items():
            covered = figures[f"% within {n} standard errors"]
            name = f"viscous modes, {level} dB: {covered:.1f} % within {n} standard errors; off the middle"
            rows.append((name, abs(covered / 100 - (least + most) / 2), (most - least) / 2))
    return rows


BENCH = Bench(run, short=partial(run, n_draws=1, seeds=(3,)))


def main() -> None:
    """Print the figures of this package and of sdypy-EMA."""
    arguments = parser(__doc__)
    arguments.add_argument("draws", type=int, nargs="?", default=N_DRAWS, help="default: %(default)s")
    arguments.add_argument("--seed", type=int, default=SHAPES_SEED, help="of the shapes")
    arguments.add_argument("--seeds", type=int, nargs="*", help="of several sets of shapes")
    chosen = arguments.parse_args()
    if chosen.seeds:
        for name, wrong, _ in found_rows(chosen.seeds, chosen.draws):
            print(f"{name}: {wrong:.0f}", flush=True)
        return
    n_draws, seed = chosen.draws, chosen.seed
    readers: dict[str, Reader] = {"lscf": ours}
    if importlib.util.find_spec("sdypy") is None:
        print("SKIPPED: the row of sdypy-EMA, which is not installed: pip install sdypy-EMA")
    else:
        readers["sdypy-EMA"] = peer
    for level in LEVELS:
        for name, read in readers.items():
            print(f"{level} dB, {name}, {n_draws} draws, shapes of seed {seed}")
            for quantity, value in compared(extracted(read, level, n_draws, seed), level, seed).items():
                print(f"    {quantity:<46} {value:8.3g}", flush=True)


if __name__ == "__main__":
    main()
