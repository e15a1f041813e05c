"""Settings of nonlinear forces: linearisation, distortion and time integration."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class DistortionSettings(Settings):
    """Nonlinear forces in expected spectra."""

    first_order_limit: float = setting(
        1.0,
        unit="1",
        doc="mean square of the motion by residual forces over that by sources",
        derived="first-order theory needs it below one",
    )
    min_half_width: float = setting(
        1e-6,
        unit="lines",
        doc="narrowest half bandwidth that quadrature resolves",
        derived="far below any resonance that a line shows",
    )
    max_refinements: int = setting(
        40,
        unit="rounds",
        doc="refinements of the quadrature towards shifted resonances",
        tuned="test_distortion.py passes with 2 and more, not with 1: a margin of 20",
    )
    initial_panels: int = setting(
        8, unit="panels", doc="panels of the band before refinement", derived="only the cost depends on it"
    )
    frequency_block: int = setting(
        512, unit="frequencies", doc="frequencies of all runs solved for in one call", derived="cache size"
    )
    max_points_per_line: int = setting(
        32,
        unit="points",
        doc="grid points of a line where a spectrum is steep",
        tuned="test_distortion.py and test_expected.py pass from a quarter to eight times the value; of a "
        "measured test residuals change by 0.03 standard deviations",
    )
    resolved_half_width: float = setting(
        3.0,
        unit="cells",
        doc="half bandwidth from which samples of the grid resolve a resonance",
        derived="the sum of samples of a Lorentz curve errs by 2 exp(-2 pi half bandwidth / cell), 1e-8",
    )
    averaged_cells: int = setting(
        16,
        unit="cells",
        doc="cells to either side of a narrow resonance in which spectra are averaged",
        derived="beyond, samples and averages differ by 1/(2 n^2), 0.2 %, of the flanks",
    )
    min_width: float = setting(
        1e-9,
        unit="Hz",
        doc="half bandwidth below which the grid is not refined for it",
        derived="guards a division",
    )


@dataclass(frozen=True)
class LinearisationSettings(Settings):
    """Equivalent linearisation of nonlinear forces."""

    rms_tolerance: float = setting(
        1e-10,
        unit="1",
        doc="relative change of a root mean square at convergence",
        derived="Newton's method converges quadratically, so the last step is below it",
    )
    max_rounds: int = setting(
        100, unit="rounds", doc="iterations at most", derived="several times what bisection needs"
    )
    trial_range: tuple[float, float] = setting(
        (0.01, 8.0),
        unit="1",
        doc="trial motions over the motion without the force",
        derived="only the cost depends on it: the range is extended until it brackets the motion",
    )
    n_trials: int = setting(
        28,
        unit="motions",
        doc="trial motions in that range",
        tuned="test_equivalent_linearisation.py passes with 7 to 56, not with 3: the least motion",
    )
    extension_range: float = setting(
        100.0,
        unit="1",
        doc="factor by which the range is extended while no solution lies in it",
        derived="only the cost depends on it",
    )
    n_extension_trials: int = setting(
        8, unit="motions", doc="trial motions in an extension", derived="four a decade"
    )
    log_bracket: float = setting(
        0.5,
        unit="1",
        doc="half width of the bracket about a known motion, of its logarithm",
        tuned="test_distortion.py passes from a quarter to four times the value",
    )
    oversampling: int = setting(
        4,
        unit="1",
        doc="samples of an autocorrelation over those of a signal in the band",
        derived="third harmonics of the band",
    )


@dataclass(frozen=True)
class HermiteSettings(Settings):
    """Hermite series of a nonlinear force under Gaussian motion."""

    n_orders: int = setting(
        200,
        unit="orders",
        doc="orders of the series that are kept",
        derived="2 % of the residual power of dry friction lies beyond",
    )
    upper_limit: float = setting(
        9.0,
        unit="standard deviations",
        doc="end of the quadrature",
        derived="the normal density is rounding there",
    )
    n_points: int = setting(
        2000, unit="points", doc="points of the quadrature", derived="resolves the highest order kept"
    )
    n_angles: int = setting(
        1001,
        unit="angles",
        doc="angles at which a long series is summed",
        derived="interpolation within 1e-6 of the series",
    )


@dataclass(frozen=True)
class TimeSteppingSettings(Settings):
    """Time integration of nonlinear forces."""

    rigid_body_rate: float = setting(
        1e-3,
        unit="rad/s",
        doc="natural frequency below which a mode is a rigid body",
        derived="far below any elastic mode",
    )
    newton_iterations: int = setting(
        16,
        unit="iterations",
        doc="Newton iterations on the forces of some steps, before half as many steps are solved for",
        tuned="cubic springs, friction and rattle: fewer steps at a time converge in fewer",
    )
    bracketed_iterations: int = setting(
        60,
        unit="iterations",
        doc="Newton iterations or bisections of the motion at the end of one step",
        derived="bisections alone would gain 2^-50, the rounding of the motion, in 50",
    )
    force_tolerance: float = setting(
        1e-10,
        unit="1",
        doc="change of forces, over the largest one of their block, at which iterations end",
        derived="far below the error of straight lines between steps, 1e-3",
    )
    loud_ratio: float = setting(
        7.0,
        unit="1",
        doc="motion over its root mean square at which stability is checked",
        derived="7 sigma: no record of Gaussian noise has it",
    )
    growth_tolerance: float = setting(
        1e-6,
        unit="1",
        doc="growth rate over the highest natural frequency that is rounding",
        derived="rounding of eigenvalues of undamped modes",
    )
    block_steps: int = setting(
        64, unit="steps", doc="time steps between two propagations of the modes", derived="computing time"
    )


@dataclass(frozen=True)
class NonlinearRecordSettings(Settings):
    """Time records with nonlinear forces."""

    oversampling: int = setting(
        4,
        unit="1",
        doc="time steps over samples of the analyser",
        derived="third harmonics of half the band; 1 % of the force at its top",
    )
    decay_threshold: float = setting(
        0.05,
        unit="1",
        doc="share of the response to a residual force that may be missing where a record begins",
        derived="the residual force is small against the force itself",
    )
    max_lead_in: int = setting(12, unit="records", doc="lead-in before a record", derived="computing time")
    parallel_samples: int = setting(
        2**23,
        unit="samples",
        doc="samples of all records stepped in parallel, lead-in included",
        derived="memory",
    )
    min_half_width: float = setting(
        1e-12,
        unit="Hz",
        doc="half bandwidth below which a mode counts as undamped",
        derived="guards a division",
    )


@dataclass(frozen=True)
class DistortionEvidenceSettings(Settings):
    """Suspicion of nonlinear forces."""

    unmeasured: float = setting(
        0.2,
        unit="1",
        doc="suspicion without a measured response spectrum",
        tuned="chosen by judgement; test_suspicion.py passes with half and with twice the value",
    )
    misfit_only: float = setting(
        0.1,
        unit="1",
        doc="suspicion where the incoherent spectrum is wrong, but no larger on the whole",
        tuned="chosen by judgement; test_suspicion.py passes with half and with twice the value",
    )
    misfit_limit: float = setting(
        1.2,
        unit="1",
        doc="mean squared residual up to which a spectrum agrees",
        tuned="chosen by judgement; test_suspicion.py passes with half and with twice the value",
    )
    least_distortion: float = setting(
        0.02,
        unit="1",
        doc="incoherent power of a nonlinear force over that of its equivalent linearisation, at least",
        tuned="a hundredth of the least of 18 cases of the blind trial, which have 2 to 45",
    )


DISTORTION = DistortionSettings()
LINEARISATION = LinearisationSettings()
HERMITE = HermiteSettings()
TIME_STEPPING = TimeSteppingSettings()
NONLINEAR_RECORDS = NonlinearRecordSettings()
DISTORTION_EVIDENCE = DistortionEvidenceSettings()
