"""How well each method reads one mode, over its width in lines and what spoils the lines.

python -m benchmarks.extraction_accuracy            # prints the tables
python -m benchmarks.extraction_accuracy --write docs/extraction-accuracy.md    # and writes the page
"""

from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from benchmarks.bench import Bench, parser
from benchmarks.spoilt_lines import (
    AVERAGES,
    CONDITIONS,
    FREQ,
    POINTS,
    RANDOM,
    SPECTRA,
    Spoil,
    clean,
    hann_h2,
    noisy,
)
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.extract import extract
from modallab.extraction.options import DistantLinesOptions, ExtractionOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit

BANDWIDTHS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
DRAWS = 24  # resonances at as many places between two lines
REPEATS = 4  # of each place, where there is noise
RESIDUAL = 3e-7  # m/N: up to 0.6 % of the peak of a mode of 1 kg, 2 % of its flanks
QUANTITIES = ("frequency", "loss factor", "|A|", "phase")
TOGETHER = "lscf"  # poles of all FRFs, here of one; `poly_reference_lscf` is the same with one reference
METHODS = (*EXTRACTION_METHODS, TOGETHER)
AUTOMATIC = "dobson"  # what `extract` takes unless told otherwise


@cache
def modes(bandwidth: float, residual: float, draws: int = DRAWS) -> tuple[ModeFit, ...]:
    """Return modes with resonances at all places between two lines, constants turned by up to 11 degrees."""
    rng = np.random.default_rng(1)
    places = 100 + (np.arange(draws) + 0.5) / draws - 0.5
    phases = rng.uniform(-0.2, 0.2, draws)
    return tuple(
        ModeFit(float(f), bandwidth / float(f), complex(np.exp(1j * phase)), residual)
        for f, phase in zip(places, phases, strict=True)
    )


def errors(
    method: str,
    spoil: Spoil,
    bandwidth: float,
    options: ExtractionOptions | None = None,
    *,
    undo: bool = True,
    averages: float = AVERAGES,
    draws: int = DRAWS,
) -> FloatArray:
    """Return median |error|, (4,): relative of frequency, loss factor and |A|, and of phase in degrees."""
    rng = np.random.default_rng(int(1000 * bandwidth))
    off = []
    places = modes(bandwidth, RESIDUAL if _exact(method) else 0.0, draws)
    for mode in places * (REPEATS if spoil in RANDOM else 1):
        lines = spoil(mode, rng)
        try:
            model = extract(
                FrfSet(FREQ, lines.values[:, None, None], (Dof(1, "Y"),), (Dof(1, "Y"),), FrfKind.INERTANCE),
                coherence=None if lines.coherence is None else lines.coherence[:, None],
                averages=averages,
                method=method,
                options=options,
                bands=[(float(FREQ[0]), float(FREQ[-1]))],
                leakage=lines.leakage if undo else None,
            )
        except NoModeInBandError:
            off.append(np.full(4, np.inf))
            continue
        assert model.modal_constant is not None
        ratio = complex(model.modal_constant[0, 0]) / mode.modal_constant
        off.append(
            np.array(
                [
                    model.frequencies[0] / mode.frequency - 1,
                    model.loss_factors[0] / mode.loss_factor - 1,
                    abs(ratio) - 1,
                    np.degrees(np.angle(ratio)),
                ]
            )
        )
    return np.asarray(np.median(np.abs(off), axis=0))


def _exact(method: str) -> bool:
    return method == TOGETHER or EXTRACTION_METHODS[method].exact


def run(draws: int = DRAWS, bandwidths: Sequence[float] = BANDWIDTHS) -> list[tuple[str, float, float]]:
    """Return (name, worst median error over bandwidths, limit)."""
    rows, worst_error = [], partial(_worst, draws=draws, bandwidths=bandwidths)
    for method in METHODS:
        if _exact(method):
            least = 0.2 if method in ("dobson", "linear_fit") else 2.0
            worst = worst_error(method, clean, least)
            rows.append((f"clean, {method}, from {least:g} lines: frequency", worst[0], 1e-6))
            rows.append((f"clean, {method}, from {least:g} lines: loss factor", worst[1], 1e-3))
    leaked = worst_error(AUTOMATIC, hann_h2, 0.5)
    rows.append(("Hanning H2, as chosen, from 0.5 lines: loss factor", leaked[1], 0.02))
    rows.append(("Hanning H2, as chosen, from 0.5 lines: |A|", leaked[2], 0.1))
    rows.append(
        ("5 % noise, as chosen, from 0.5 lines: loss factor", worst_error(AUTOMATIC, noisy, 0.5)[1], 0.05)
    )
    return rows


def _worst(method: str, spoil: Spoil, least: float, draws: int, bandwidths: Sequence[float]) -> FloatArray:
    widths = [width for width in bandwidths if width >= least]
    return np.asarray(np.max([errors(method, spoil, width, draws=draws) for width in widths], axis=0))


INTRODUCTION = """# Accuracy of the extraction of a single mode

Terms and symbols: [glossary](glossary.md).

Written by `python -m benchmarks.extraction_accuracy --write docs/extraction-accuracy.md`. One mode of
1 kg at 100 Hz, line spacing 1 Hz. The tables give the median error over {draws} positions of the resonance
between two lines, with {repeats} random draws each if there is noise. Columns: half-power bandwidth over line
spacing. Frequency, loss factor and magnitude of the modal constant |A| in %, its phase in degrees; "-" where
most draws show no mode.

All responses include a constant residual of {residual:g} m/N, except those for peak picking, which cannot
separate it from the mode. The methods run as in `extract`: lines and weights chosen from the data, receptance
or inertance by the smaller misfit, leakage corrected in closed form. `lscf` uses a single frequency response
function (FRF); `poly_reference_lscf` gives the same with one drive point.

- **Clean**: no error. Peak picking is biased even here: up to half a line in frequency, and towards too
  much damping.
- **Hanning H1, H2**: expected spectra of a white force with a Hann window, by numerical convolution
  ({points} points a line), independent of the closed form of the correction.
- **5 % noise**: independent errors of 5 % in magnitude and in phase at every line.
- **Floor noise**: independent errors of 1 % of the largest magnitude, in real and imaginary part
  of every line.
"""
LEAKY = f"""
## Correction of leakage

Dobson's method, median error of the loss factor in %. "Corrected" stands for the closed form of the
leakage of one mode, estimated together with the mode. "Expected" lines are the limit of many averages
(10,000 are assumed); "drawn" lines scatter as those of {AVERAGES:g} averages (complex Wishart
distribution, line by line). By default `extract` corrects leakage, and leaves out the nearest 4 lines
for H1, but not for H2.
"""
TREATMENTS: dict[str, tuple[ExtractionOptions, bool]] = {
    "uncorrected, 12 lines": (DistantLinesOptions(lines=12, leave_out=0), False),
    "without the nearest 4 of 16": (DistantLinesOptions(lines=16, leave_out=4), False),
    "corrected, 12 lines": (DistantLinesOptions(lines=12, leave_out=0), True),
    "corrected, without the nearest 4 of 16": (DistantLinesOptions(lines=16, leave_out=4), True),
}


def report(draws: int, bandwidths: Sequence[float]) -> str:
    """Return the tables as markdown."""
    parts = [INTRODUCTION.format(draws=draws, repeats=REPEATS, residual=RESIDUAL, points=POINTS)]
    for name, spoil in CONDITIONS.items():
        table = {
            method: np.array([errors(method, spoil, width, draws=draws) for width in bandwidths])
            for method in METHODS
        }
        rows = [
            (quantity, method, *(_cell(value, n) for value in values[:, n]))
            for n, quantity in enumerate(QUANTITIES)
            for method, values in table.items()
        ]
        parts.append(f"\n## {name[0].upper()}{name[1:]}\n\n{_table(('', 'method'), rows, bandwidths)}")
    rows = [
        (name, treatment, *(_cell(_treated(spoil, width, treatment, draws), 1) for width in bandwidths))
        for name, spoil in SPECTRA.items()
        for treatment in TREATMENTS
    ]
    parts.append(f"{LEAKY}\n{_table(('', 'treatment of lines'), rows, bandwidths)}")
    return "".join(parts)


def _treated(spoil: Spoil, bandwidth: float, treatment: str, draws: int) -> float:
    options, undo = TREATMENTS[treatment]
    # what is expected is known exactly: random error must not be why a fit is refused
    averages = AVERAGES if spoil in RANDOM else 1e4
    of_loss_factor = 1
    median = errors(AUTOMATIC, spoil, bandwidth, options, undo=undo, averages=averages, draws=draws)
    return float(median[of_loss_factor])


def _cell(value: float, quantity: int) -> str:
    if not np.isfinite(value):
        return "-"
    return f"{value if quantity == 3 else 100 * value:.2g}"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]], bandwidths: Sequence[float]) -> str:
    head = [*heads, *(f"{width:g}" for width in bandwidths)]
    lines = [head, ["---"] * len(heads) + ["---:"] * len(bandwidths), *rows]
    return "".join(f"| {' | '.join(_plain(cell) for cell in line)} |\n" for line in lines)


def _plain(cell: str) -> str:
    return cell.replace("|", "\\|")


BENCH = Bench(run, short=partial(run, draws=1, bandwidths=(2.0,)))


def main() -> None:
    """Print the tables, and write the page."""
    arguments = parser(__doc__)
    arguments.add_argument("--draws", type=int, default=DRAWS, help="places of a resonance (%(default)s)")
    arguments.add_argument("--bandwidths", type=float, nargs="+", default=BANDWIDTHS, help="lines")
    arguments.add_argument("--write", type=Path, help="write the tables to this file")
    options = arguments.parse_args()
    text = report(options.draws, options.bandwidths)
    print(text)
    if options.write:
        options.write.write_text(text)


if __name__ == "__main__":
    main()
