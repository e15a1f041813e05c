"""A small beam on a rig, with drawn measurements: what the diagnosis tests share."""

from collections.abc import Sequence

import numpy as np

from modallab.core.dof import Dof
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra


def model() -> Structure:
    """Return a free beam of eight elements, five modes below 400 Hz."""
    return beam(
        length=1.2,
        n_elements=8,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(stiffness_coefficient=0.008, mass_coefficient=100.0),
    )


def rig(
    *,
    kind: str = "periodic_random",
    window: str = "rectangular",
    averages: int = 100,
    estimator: str = "h1",
    roving: bool = True,
    noise: float = 1e-4,
) -> RigSetup:
    """Return a rig with six responses and 161 lines to 400 Hz."""
    return RigSetup(
        drives=(Dof.parse("1:+Y"),),
        responses=tuple(Dof(n, "Y") for n in (1, 2, 4, 5, 7, 9)),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=roving),
        noise=Noise(noise, noise),
        analyser=Analyser(
            frequency_max=400.0,
            n_lines=161,
            window=window,
            averages=averages,
            estimator=estimator,
            excitation=ExcitationSetting(kind),
        ),
    )


def draw_measurement(setup: RigSetup, effects: Sequence[Effect] = (), *, seed: int = 0) -> Measurement:
    """Return a measurement drawn round the expected spectra."""
    spectra = expected_spectra(chain(assemble(model()), setup, effects))
    return measurement_of(wishart_spectra(spectra, np.random.default_rng(seed)), setup)


def exact(setup: RigSetup, effects: Sequence[Effect] = ()) -> Measurement:
    """Return a measurement without random error."""
    return measurement_of(expected_spectra(chain(assemble(model()), setup, effects)), setup)


def predicting(measurement: Measurement) -> tuple[SingleTestPredictor, Observed]:
    """Return a predictor of a measurement, nothing held out."""
    observed = observe(measurement, (), fraction=0.0)
    return SingleTestPredictor.of(model(), measurement.setup, observed), observed
