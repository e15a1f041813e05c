"""A hammer test with close modes: forty struck points, three accelerometers, an exponential window."""

import io
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.fe.assembly import assemble
from modallab.fe.blocks import Blocks
from modallab.fe.damping import ModalDamping
from modallab.fe.members import MatrixElement
from modallab.fe.structure import Structure
from modallab.interchange.reading import read_measurement
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra, noise_free
from modallab.rig.hardware import Exciter, Noise, NoiseDensity
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup

FREQUENCY_MAX = 1600.0  # Hz
AVERAGES = 5
SIGNAL_TO_NOISE = 1e4  # 40 dB, of mean spectra
SINGLES = np.array([60.0, 112.0, 310.0, 395.0, 560.0, 640.0, 880.0, 1190.0, 1500.0])  # Hz
PAIRS = np.array([205.0, 745.0, 1040.0])  # Hz, lower mode of each
SPREAD = 0.02  # of these frequencies from test to test
APART = (0.003, 0.005)  # of the frequency of a pair
LOSS_FACTORS = (0.002, 0.005)
ABOVE = (1.15, 3.0)  # frequencies of all other modes over the last line
N_REFERENCES = 3
MASS = 0.1  # kg, of every point
ALIKE = 0.5  # largest MAC of a pair at the references


@dataclass(frozen=True)
class Size:
    """Size of a test."""

    n_points: int = 40
    n_lines: int = 12_801


@dataclass(frozen=True, eq=False)
class Truth:
    """The structure of a test."""

    loss_factor: FloatArray
    """(15,) of the modes in the band."""
    frequencies: FloatArray
    """(n_points,) Hz, ascending, also of modes above the band."""
    shapes: FloatArray
    """(n_points, n_points) 1/sqrt(kg), of all modes."""
    references: tuple[int, ...]
    """Points with an accelerometer."""

    @property
    def frequency(self) -> FloatArray:
        """(15,) Hz, of the modes in the band."""
        return self.frequencies[: len(self.loss_factor)]

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Neighbouring modes closer than any others."""
        ratio = np.diff(self.frequency) / self.frequency[:-1]
        return [(int(n), int(n) + 1) for n in np.flatnonzero(ratio < 2 * APART[1])]

    @property
    def constants(self) -> FloatArray:
        """(n_points, n_points, n_references) 1/kg, modal constants by mode, struck point and reference."""
        return np.asarray(self.shapes.T[:, :, None] * self.shapes.T[:, None, list(self.references)])


@dataclass(frozen=True, eq=False)
class HammerTest:
    """A simulated test with what is true of it."""

    measured: Measurement
    true: FloatArray
    """(n_lines, n_references, n_points) E|error|^2 of its FRFs, given its forces."""
    variance: FloatArray
    """(n_lines, n_references, n_points) E|error|^2 of its FRFs if there were no window."""


def truth_of(seed: int, size: Size) -> Truth:
    """Return a structure drawn with a seed; pairs have different shapes at the references."""
    rng = np.random.default_rng([seed, 1])
    n = size.n_points
    lower = PAIRS * rng.uniform(1 - SPREAD, 1 + SPREAD, len(PAIRS))
    upper = lower * (1 + rng.uniform(*APART, len(PAIRS)))
    singles = SINGLES * rng.uniform(1 - SPREAD, 1 + SPREAD, len(SINGLES))
    inside = np.sort(np.concatenate([singles, lower, upper]))
    above = FREQUENCY_MAX * np.sort(rng.uniform(*ABOVE, n - len(inside)))
    loss_factor = rng.uniform(*LOSS_FACTORS, len(inside))
    while True:
        shapes = np.linalg.qr(rng.standard_normal((n, n)))[0] / np.sqrt(MASS)
        references = tuple(sorted(rng.choice(n, N_REFERENCES, replace=False).tolist()))
        truth = Truth(loss_factor, np.append(inside, above), shapes, references)
        at_references = shapes[list(references)]
        if all(mac(at_references[:, a], at_references[:, b]) < ALIKE for a, b in truth.pairs):
            return truth


def mac(first: FloatArray | ComplexArray, second: FloatArray | ComplexArray) -> float:
    """Return the modal assurance criterion of two shapes."""
    return float(np.abs(first.conj() @ second) ** 2 / (np.linalg.norm(first) * np.linalg.norm(second)) ** 2)


def structure_of(truth: Truth) -> Structure:
    """Return the structure as one element given by its matrices."""
    n = len(truth.frequencies)
    weighted = MASS * truth.shapes
    stiffness = weighted * (2 * np.pi * truth.frequencies) ** 2 @ weighted.T
    dofs = tuple(Dof(point + 1, "Z") for point in range(n))
    matrices = (MASS * np.eye(n)[None], (stiffness + stiffness.T)[None] / 2)
    places = {point + 1: (0.1 * (point % 8), 0.1 * (point // 8), 0.0) for point in range(n)}
    return Structure(
        places,
        (),
        damping=ModalDamping(tuple(truth.loss_factor.tolist())),
        non_bar_members=(MatrixElement(1, tuple(places), 0),),
        blocks=Blocks(dofs, np.arange(n)[None], *matrices, None, np.zeros((n, 0))),
    )


def rig_of(truth: Truth, size: Size) -> RigSetup:
    """Return the rig of a test, without noise."""
    excitation = ExcitationSetting("impact", level_scatter=0.2)
    analyser = Analyser(
        FREQUENCY_MAX, size.n_lines, window="exponential", averages=AVERAGES, excitation=excitation
    )
    return RigSetup(
        drives=tuple(Dof(point + 1, "Z") for point in range(size.n_points)),
        responses=tuple(Dof(point + 1, "Z") for point in truth.references),
        exciter=Exciter("hammer"),
        analyser=analyser,
    )


def test_of(truth: Truth, seed: int, size: Size) -> HammerTest:
    """Return a test of a structure; noise is white, equal in all force and in all response channels."""
    structure, setup = assemble(structure_of(truth)), rig_of(truth, size)
    plain = replace(setup, analyser=replace(setup.analyser, window="rectangular"))
    power = noise_free(chain(structure, plain)).real
    force, response = power[:, :, 0], power[:, :, 1 + N_REFERENCES :]
    densities = force.mean() / SIGNAL_TO_NOISE, response.mean() / SIGNAL_TO_NOISE
    noise = Noise(*(NoiseDensity(float(density)) for density in densities))
    noisy = chain(structure, replace(setup, noise=noise))
    spectra = sampled_spectra(noisy, np.random.default_rng([seed, 2]), silent)
    measured, expected = measurement_of(spectra, setup), measurement_of(expected_spectra(noisy), setup)
    assert measured.force_spectrum is not None
    assert expected.force_spectrum is not None
    # the blows of a test are not those of the mean
    blows = AVERAGES * measured.force_spectrum.mean(axis=0) / expected.force_spectrum.mean(axis=0)
    gain = response.transpose(1, 2, 0) / force.T[:, None]
    variance = (densities[1] + gain * densities[0]) / (AVERAGES * force.T[:, None])
    return HammerTest(measured, incoherent_power(expected) / blows, variance)


def incoherent_power(test: Measurement) -> FloatArray:
    """Return the power of the response that the force does not explain over that of the force."""
    assert test.coherence is not None
    return np.asarray(np.abs(test.frf.values) ** 2 * (1 - test.coherence) / test.coherence)


def imported(test: Measurement) -> Measurement:
    """Return the measurement of a file that states FRFs, coherence and points."""
    file = io.BytesIO()
    np.savez(
        file,
        freq=test.frf.freq,
        values=test.frf.values,
        coherence=np.asarray(test.coherence),
        outputs=[str(dof) for dof in test.frf.outputs],
        inputs=[str(dof) for dof in test.frf.inputs],
        kind=str(test.frf.kind),
    )
    file.seek(0)
    return read_measurement(file, None, largest=10**9)
