"""Nonlinear forces in a run: the springs and dampers they amount to, and the power of what is left."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.attachment import Attachment
from modallab.fe.receptance import receptance
from modallab.rig.analyser import Analyser
from modallab.rig.drive import reaction, transmission
from modallab.rig.linearise import equivalents, residual_density
from modallab.rig.local_force import Linearised, LocalForce
from modallab.rig.run import Run
from modallab.rig.source import Source
from modallab.rig.view import refined

STRONG = 1.0  # mean square of the motion by residuals, over that by sources, at which first order ends
NARROWEST = 1e-6  # of a line, that quadrature takes a resonance to be
REFINEMENTS = 8  # of the quadrature towards resonances that nonlinear forces have moved
FINEST = 64  # grid points a line at most where a spectrum is steep


def with_equivalents(run: Run, forces: Sequence[LocalForce], analyser: Analyser, source: Source) -> Run:
    """Return the run with every nonlinear force in it: its straight line attached, the rest beside it.

    What repeats with the record has its power on the lines, what does not everywhere between them.
    """
    share = source.continuous
    known = run.resonances(analyser.frequency_max)
    for _ in range(REFINEMENTS):
        freq, hertz = [analyser.freq[1:]], [np.full(analyser.n_lines - 1, (1 - share) * analyser.spacing)]
        if share > 0:
            nodes, weights = refined(analyser, *known)
            freq, hertz = [*freq, nodes], [*hertz, share * weights]
        omega, power = 2 * np.pi * np.concatenate(freq), _density(analyser) * np.concatenate(hertz)
        driven, fed_back = motions(run, forces, omega)
        loaded = _with_lines(run, equivalents(forces, driven, fed_back, omega, power))
        if share == 0:
            break
        # Where a spring has moved a resonance, quadrature must be fine there as well.
        moved = loaded.resonances(analyser.frequency_max)
        if _resolved(moved, known, analyser):
            break
        known = np.concatenate([known[0], moved[0]]), np.concatenate([known[1], moved[1]])
    return loaded


def _resolved(
    moved: tuple[FloatArray, FloatArray], known: tuple[FloatArray, FloatArray], analyser: Analyser
) -> bool:
    """Return whether every resonance lies within its half bandwidth of one known to be as narrow."""
    (at, half), (there, width) = moved, known
    inside = at < analyser.frequency_max + analyser.spacing
    at, half = at[inside], np.maximum(half[inside], NARROWEST * analyser.spacing)
    near = np.abs(at[:, None] - there) <= half[:, None]
    return bool((near & (width <= 2 * half[:, None])).any(axis=1).all())


def _with_lines(run: Run, found: tuple[Linearised, ...]) -> Run:
    system = run.system
    for one in found:
        column, line = system.selection((one.force.dof,)), np.array([[one.slope]])
        of_velocity = one.force.of_velocity
        equal = Attachment(column, viscous=line) if of_velocity else Attachment(column, stiffness=line)
        system = system.attach(equal)
    return replace(run, system=system, local=found)


def check_first_order(runs: Sequence[Run], analyser: Analyser, source: Source) -> None:
    """Raise unless what straight lines leave moves the structure less than the sources do.

    The expected spectra take the residual of a nonlinear force for a source of its own that does not
    alter the motion: where it moves the structure as much as the true sources, they mean nothing.

    Raises
    ------
    InvalidInputError
        If they do not hold.
    """
    omega = 2 * np.pi * analyser.freq[1:]
    for run in runs:
        if not run.local:
            return
        driven, fed_back = motions(run, [one.force for one in run.local], omega)
        left = residual_densities(run, analyser, source, analyser.freq[1:])
        by_residuals = (np.abs(fed_back) ** 2 * left[:, None, :]).sum(axis=(0, 2))
        by_sources = _density(analyser) * (np.abs(driven) ** 2).sum(axis=(0, 2))
        if (by_residuals > STRONG * by_sources).any():
            worst = run.local[int((by_residuals / by_sources).argmax())].force.dof
            raise InvalidInputError(
                f"the nonlinear force at {worst} is too strong at this level for expected spectra",
                field="route",
                value="expected or drawn",
                allowed="sampled, or a lower level",
            )


def residual_densities(run: Run, analyser: Analyser, source: Source, freq: FloatArray) -> FloatArray:
    """Return the one-sided densities of the residuals of a run's nonlinear forces, (n_freq, r) N^2/Hz."""
    finer = 1
    if source.continuous > 0:
        frequencies, widths = run.resonances(analyser.frequency_max)
        narrow = widths[frequencies < analyser.frequency_max].min(initial=analyser.spacing)
        finer = int(np.clip(np.ceil(analyser.spacing / max(narrow, 1e-9)), 1, FINEST))
    lines = np.linspace(0.0, analyser.frequency_max, finer * (analyser.n_lines - 1) + 1)
    omega = 2 * np.pi * lines[1:]
    driven, _ = motions(run, [one.force for one in run.local], omega)
    size = _density(analyser) * (np.abs(driven) ** 2).sum(axis=2)
    out = np.empty((len(freq), len(run.local)))
    for i, one in enumerate(run.local):
        spectrum = size[:, i] * (omega**2 if one.force.of_velocity else 1.0)
        density = residual_density(one, np.concatenate([[0.0], spectrum]), lines[1])
        out[:, i] = np.interp(freq, lines, density)
    return out


def _density(analyser: Analyser) -> float:
    return analyser.excitation.level**2 / analyser.frequency_max


def motions(run: Run, forces: Sequence[LocalForce], omega: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return displacement at the forces per source (n, r, n_in) and per force there (n, r, r), m/N."""
    n = len(run.drives)
    columns = run.system.selection((*run.shot.drives, *(force.dof for force in forces)))
    alpha = receptance(run.system, omega / (2 * np.pi), columns, columns)
    at_drives = alpha[None, :, :n, :n]
    driven = alpha[:, n:, :n] @ transmission(run.drives, omega, at_drives)[0]
    held = reaction(run.drives, omega, at_drives)[0] @ alpha[:, :n, n:]
    return driven, alpha[:, n:, n:] - alpha[:, n:, :n] @ held
