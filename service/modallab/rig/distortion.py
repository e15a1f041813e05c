"""Nonlinear forces in the measuring chain: equivalent linearisation, and spectra of the residual forces."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.attachment import Attachment
from modallab.fe.variants import attached_variants
from modallab.rig.analyser import Analyser
from modallab.rig.cell_averages import CellAverages, mean_about
from modallab.rig.drive import reaction, transmission
from modallab.rig.equivalent_linearisation import (
    LocalResponseSpectrum,
    closed_loop_receptances,
    equivalent_rms,
    residual_spectrum,
)
from modallab.rig.line_kernels import refined_panels
from modallab.rig.local_force import LinearisedForce, LocalForce
from modallab.rig.nonlinear_settings import DISTORTION
from modallab.rig.run import Run
from modallab.rig.source import Source


def with_equivalent_linearisation(
    runs: Sequence[Run],
    forces: Sequence[LocalForce],
    analyser: Analyser,
    source: Source,
    *,
    same_in_all_runs: bool = False,
    initial_rms: FloatArray | None = None,
) -> tuple[Run, ...]:
    """Return runs with the equivalent spring or damper of every nonlinear force attached.

    Power that repeats with the record lies on the lines, other power everywhere between them.

    Parameters
    ----------
    same_in_all_runs
        Whether the motion of the first run is used for all runs if all power lies between the lines. Runs
        then differ by an accelerometer's mass only, which screening may neglect. With power on the lines
        a resonance that crosses a line may change the motion a lot.
    initial_rms
        (n_run, r) root mean squares of an almost identical chain, if all power lies on the lines; Newton's
        method starts there instead of a search for the smallest solution.
    """
    if same_in_all_runs and source.continuous == 1:
        (first,) = with_equivalent_linearisation(runs[:1], forces, analyser, source)
        later_runs = (
            replace(_with_linearised(run, first.local_forces), response_spectrum=first.response_spectrum)
            for run in runs[1:]
        )
        return (first, *later_runs)
    if source.continuous > 0:
        return tuple(_by_quadrature(runs, forces, analyser, source.continuous))
    omega, power = 2 * np.pi * analyser.freq[1:], _power_of_lines(analyser, analyser.freq[1:])
    open_loop = local_receptances(runs, forces, omega)
    rms = equivalent_rms(forces, *open_loop, omega, power, initial_rms)
    spectra = _local_spectra(
        forces, *closed_loop_receptances(forces, rms, *open_loop, omega), omega, analyser
    )
    return tuple(
        replace(_with_linearised(run, _linearised_forces(forces, run_rms)), response_spectrum=spectrum)
        for run, run_rms, spectrum in zip(runs, rms, spectra, strict=True)
    )


def with_linearisation_of(runs: Sequence[Run], others: Sequence[Run]) -> tuple[Run, ...]:
    """Return runs with the equivalent springs and dampers of other runs, which are very much like them."""
    return tuple(
        replace(_with_linearised(run, other.local_forces), response_spectrum=other.response_spectrum)
        for run, other in zip(runs, others, strict=True)
    )


def _local_spectra(
    forces: Sequence[LocalForce],
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
    analyser: Analyser,
) -> list[LocalResponseSpectrum]:
    """Return the motion spectra at the forces of each run, at 0 Hz and at `omega` (n,) rad/s.

    Parameters
    ----------
    driven, fed_back
        As in `local_forces_receptances`, with the equivalent linearisation.
    """
    of_velocity = [force.of_velocity for force in forces]
    density = analyser.source_density(omega / (2 * np.pi))
    size = density[:, None] * (np.abs(driven) ** 2).sum(axis=3)
    size *= np.where(of_velocity, omega[:, None] ** 2, 1.0)
    answer = np.einsum("nfrr->nfr", fed_back) * np.where(of_velocity, 1j * omega[:, None], 1.0)
    # A motion has no mean; what answers a steady force is real, and about what answers a slow one.
    spectra = np.concatenate([np.zeros_like(size[:, :1]), size], axis=1)
    answers = np.concatenate([answer[:, :1].real, answer], axis=1)
    return [LocalResponseSpectrum(*pair) for pair in zip(spectra, answers, strict=True)]


def _by_quadrature(
    runs: Sequence[Run], forces: Sequence[LocalForce], analyser: Analyser, share: float
) -> Iterator[Run]:
    """Yield the linearised runs for sources with continuous spectra.

    Fixed-point iteration: quadrature refined at the resonances of the linearised structure gives the motion,
    and the motion gives new resonances. Each run starts from the previous one, from which it differs by an
    accelerometer.
    """
    lines, panels = analyser.freq[1:], replace(analyser, n_lines=DISTORTION.initial_panels + 1)
    power = (1 - share) * _power_of_lines(analyser, lines)
    if share == 1:
        lines, power = lines[:0], power[:0]
    rms: FloatArray | None = None
    for run in runs:
        start_run = run if rms is None else _with_linearised(run, _linearised_forces(forces, rms))
        resonances = start_run.resonances(analyser.frequency_max)
        for _ in range(DISTORTION.max_refinements):
            nodes, hertz = refined_panels(panels, *resonances)
            weights = np.concatenate([power, share * analyser.source_density(nodes) * hertz])
            omega = 2 * np.pi * np.concatenate([lines, nodes])
            driven, fed_back = local_receptances([run], forces, omega)
            initial_rms = _open_loop_rms(forces, driven, omega, weights) if rms is None else rms
            rms = equivalent_rms(forces, driven, fed_back, omega, weights, initial_rms[None])[0]
            loaded = _with_linearised(run, _linearised_forces(forces, rms))
            loaded_resonances = loaded.resonances(analyser.frequency_max)
            if _is_resolved(loaded_resonances, resonances, analyser):
                break
            resonances = loaded_resonances
        yield loaded


def _open_loop_rms(
    forces: Sequence[LocalForce], driven: ComplexArray, omega: FloatArray, power: FloatArray
) -> FloatArray:
    """Return the root mean square motions (r,) without the nonlinear forces."""
    scale = np.where([force.of_velocity for force in forces], omega[:, None] ** 2, 1.0)
    return np.asarray(np.sqrt(power @ ((np.abs(driven[0]) ** 2).sum(axis=2) * scale)))


def _is_resolved(
    resonances: tuple[FloatArray, FloatArray],
    refined_resonances: tuple[FloatArray, FloatArray],
    analyser: Analyser,
) -> bool:
    """Return whether the quadrature is refined at every resonance, within half its bandwidth."""
    (frequency, half_width), (refined_frequency, refined_width) = resonances, refined_resonances
    inside = frequency < analyser.frequency_max + analyser.spacing
    frequency, half_width = (
        frequency[inside],
        np.maximum(half_width[inside], DISTORTION.min_half_width * analyser.spacing),
    )
    near = np.abs(frequency[:, None] - refined_frequency) <= half_width[:, None]
    return bool((near & (refined_width <= 2 * half_width[:, None])).any(axis=1).all())


def _linearised_forces(forces: Sequence[LocalForce], rms: FloatArray) -> tuple[LinearisedForce, ...]:
    return tuple(force.linearised(float(force_rms)) for force, force_rms in zip(forces, rms, strict=True))


def _with_linearised(run: Run, linearised: tuple[LinearisedForce, ...]) -> Run:
    system = run.system
    for linearised_force in linearised:
        column, line = system.selection((linearised_force.force.dof,)), np.array([[linearised_force.slope]])
        of_velocity = linearised_force.force.of_velocity
        attachment = Attachment(column, viscous=line) if of_velocity else Attachment(column, stiffness=line)
        system = system.attach(attachment)
    return replace(run, system=system, local_forces=linearised)


def check_first_order(runs: Sequence[Run], analyser: Analyser, source: Source) -> None:
    """Raise unless residual forces move the structure less than the sources do.

    Expected spectra treat the residual of a nonlinear force as an independent source that does not alter
    the motion; this first-order theory fails if the residual moves the structure as much as the sources.

    Raises
    ------
    InvalidInputError
        If they do not hold.
    """
    if not runs[0].local_forces:
        return
    lines = analyser.freq[1:]
    forces = [linearised_force.force for linearised_force in runs[0].local_forces]
    driven, fed_back = local_receptances(runs, forces, 2 * np.pi * lines)
    residual_density = residual_spectra(runs, analyser, source, lines).density
    by_residuals = (np.abs(fed_back) ** 2 * residual_density[:, :, None, :]).sum(axis=(1, 3))
    by_sources = analyser.source_density(lines) @ (np.abs(driven) ** 2).sum(axis=3).sum(axis=0)
    strong = by_residuals > DISTORTION.first_order_limit * by_sources
    if strong.any():
        worst = forces[int(strong.any(axis=0).argmax())].dof
        raise InvalidInputError(
            f"the nonlinear force at {worst} is too strong at this level for expected spectra",
            field="route",
            value="expected or drawn",
            allowed="sampled, or a lower level",
        )


@dataclass(frozen=True, eq=False)
class ResidualSpectra:
    """Residual forces of the linearisation, (n_run, n_freq, r) each."""

    density: FloatArray
    """N^2/Hz, one-sided power spectral density."""
    feedback: ComplexArray
    """N/m, feedback from the motion to the force."""


def residual_spectra(
    runs: Sequence[Run],
    analyser: Analyser,
    source: Source,
    freq: FloatArray,
    finest: int = DISTORTION.max_points_per_line,
) -> ResidualSpectra:
    """Return the residual forces' spectra at `freq` (n_freq,) Hz.

    Parameters
    ----------
    finest
        Grid points a line at most where spectra are steep.
    """
    forces, shape_of_all = (
        [local.force for local in runs[0].local_forces],
        (len(runs), len(freq), len(runs[0].local_forces)),
    )
    if all(run.local_forces is runs[0].local_forces for run in runs):  # taken alike, left alike
        runs = runs[:1]
    lines, spectra = _spectra_on_uniform_grid(runs, forces, analyser, source, finest)
    shape = (len(runs), *shape_of_all[1:])
    density, line = np.empty(shape), np.empty(shape, complex)
    for r, (run, motion) in enumerate(zip(runs, spectra, strict=True)):
        for i, local in enumerate(run.local_forces):
            power, feedback = residual_spectrum(
                local, motion.spectrum[:, i], motion.receptance[:, i], lines[1]
            )
            density[r, :, i] = mean_about(freq, lines, power)
            line[r, :, i] = mean_about(freq, lines, feedback.real) + 1j * mean_about(
                freq, lines, feedback.imag
            )
    unit = np.where([force.of_velocity for force in forces], 2j * np.pi * freq[:, None], 1.0)
    return ResidualSpectra(np.broadcast_to(density, shape_of_all), np.broadcast_to(line * unit, shape_of_all))


def _spectra_on_uniform_grid(
    runs: Sequence[Run], forces: Sequence[LocalForce], analyser: Analyser, source: Source, finest: int
) -> tuple[FloatArray, list[LocalResponseSpectrum]]:
    """Return a uniform grid (n_lines,) Hz that resolves the resonances, and the motion spectra there."""
    spectra = [run.response_spectrum for run in runs if run.response_spectrum is not None]
    if source.continuous == 0 and len(spectra) == len(runs):
        return analyser.freq, spectra
    frequencies, widths = np.concatenate([run.resonances(analyser.frequency_max) for run in runs], axis=1)
    narrow = widths[frequencies < analyser.frequency_max].min(initial=analyser.spacing)
    finer = int(np.clip(np.ceil(analyser.spacing / max(narrow, DISTORTION.min_width)), 1, finest))
    lines = np.linspace(0.0, analyser.frequency_max, finer * (analyser.n_lines - 1) + 1)
    spectra = _local_spectra_of_runs(runs, forces, lines[1:], analyser)
    averages = CellAverages.near(lines[1], len(lines), frequencies.ravel(), widths.ravel())
    if len(averages.points):
        at_nodes = _local_spectra_of_runs(runs, forces, averages.nodes, analyser)
        spectra = [
            sampled.averaged(averages, of_run) for sampled, of_run in zip(spectra, at_nodes, strict=True)
        ]
    return lines, spectra


def _local_spectra_of_runs(
    runs: Sequence[Run], forces: Sequence[LocalForce], freq: FloatArray, analyser: Analyser
) -> list[LocalResponseSpectrum]:
    """Return the motion spectra at the forces of each run, at 0 Hz and at `freq` (n,) Hz."""
    parts = np.array_split(2 * np.pi * freq, np.ceil(len(freq) / DISTORTION.frequency_block))
    driven, fed_back = zip(*(local_receptances(runs, forces, omega) for omega in parts), strict=True)
    receptances = np.concatenate(driven, axis=1), np.concatenate(fed_back, axis=1)
    return _local_spectra(forces, *receptances, 2 * np.pi * freq, analyser)


def _power_of_lines(analyser: Analyser, lines: FloatArray) -> FloatArray:
    return analyser.source_density(lines) * analyser.spacing


def local_receptances(
    runs: Sequence[Run], forces: Sequence[LocalForce], omega: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return receptances at the nonlinear forces: per source (n_run, n, r, n_in), and per local force.

    The second is (n_run, n, r, r).
    """
    first = runs[0]
    if not all(
        run.drives == first.drives
        and run.acquisition_run.drives == first.acquisition_run.drives
        and _same_structure(run, first)
        for run in runs
    ):
        by_source, by_force = zip(*(local_receptances([run], forces, omega) for run in runs), strict=True)
        return np.concatenate(by_source), np.concatenate(by_force)
    n = len(first.drives)
    columns = first.system.selection((*first.acquisition_run.drives, *(force.dof for force in forces)))
    alpha = attached_variants([run.system for run in runs], omega, *2 * ([columns] * len(runs),))
    at_drives = alpha[:, :, :n, :n]
    driven = alpha[:, :, n:, :n] @ transmission(first.drives, omega, at_drives)
    exciter_reaction = reaction(first.drives, omega, at_drives) @ alpha[:, :, :n, n:]
    return driven, alpha[:, :, n:, n:] - alpha[:, :, n:, :n] @ exciter_reaction


def _same_structure(first: Run, second: Run) -> bool:
    """Return whether two runs share mass and stiffness matrices."""
    return first.system.mass is second.system.mass and first.system.stiffness is second.system.stiffness
