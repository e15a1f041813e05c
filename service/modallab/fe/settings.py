"""Settings of the finite-element algorithms."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class EigensolutionSettings(Settings):
    """Undamped modes: dense solution, shift-invert Lanczos iteration and the count by Sylvester's law."""

    dense_dofs: int = setting(
        250,
        unit="DoFs",
        doc="system size below which all modes come from a dense eigensolution",
        tuned="timings of dense and sparse solutions: the dense one is faster below",
    )
    tolerances: tuple[float, ...] = setting(
        (1e-12, 1e-9, 1e-6),
        doc="relative accuracies of Lanczos eigenvalues, tried in turn until one converges",
        derived="from rounding of a well-conditioned matrix up to that of a very thin plate",
    )
    max_restarts: int = setting(
        100,
        unit="restarts",
        doc="restarts of the Lanczos iteration before the next tolerance is tried",
        tuned="chosen by judgement: beyond it the residual is rounding",
    )
    relative_gap: float = setting(
        1e-6,
        doc="relative distance of neighbouring eigenvalues between which a band may end",
        derived="the loosest tolerance of the eigenvalues",
    )
    random_start_fraction: float = setting(
        1e-2,
        doc="size of a random motion added to a start vector made of known modes",
        tuned="chosen by judgement: a mode that the known ones lack is found",
    )
    initial_shift: float = setting(
        1e-11,
        doc="first shift of a search, over an upper bound of the highest eigenvalue",
        derived="below most elastic eigenvalues of a fine mesh, above their rounding",
    )
    min_shift: float = setting(
        1e-14,
        doc="least shift of a search, over an upper bound of the highest eigenvalue",
        derived="rounding of a sum of many products",
    )
    band_shift: float = setting(
        1e-3,
        doc="shift of a search up to a frequency, over the eigenvalue at that frequency",
        derived="near the first elastic eigenvalues: regular, and low modes stay separated",
    )
    shift_margin: float = setting(
        10.0,
        doc="factor by which a lowered shift stays below the estimated lowest elastic eigenvalue",
        derived="one decade, as the estimate is an upper bound",
    )
    inverse_iterations: int = setting(
        3,
        unit="iterations",
        doc="inverse iterations whose Rayleigh quotient estimates the lowest elastic eigenvalues",
        tuned="test_lowest_modes.py and test_modes.py pass with 1 to 12, not with 18",
    )
    uncounted_modes: int = setting(
        20,
        unit="modes",
        doc="modes of the first search where rounding hides the count below a frequency",
        derived="only the cost depends on it: the search goes on until the band is complete",
    )
    spare_vectors: int = setting(
        10,
        unit="vectors",
        doc="least number of Lanczos vectors beside the modes, where these are nearly known",
        tuned="timings of updates of large models",
    )
    inertia_attempts: int = setting(
        5,
        unit="factorisations",
        doc="attempts at a count below an eigenvalue, each a little higher after a zero pivot",
        derived="only the cost depends on it: without a count the search goes on until the band is complete",
    )
    refined_eigenvalue_range: float = setting(
        1e3,
        doc="eigenvalues over the lowest elastic one up to which a dense solution is refined",
        derived="rounding of a step of inverse iteration grows by this ratio",
    )
    rigid_energy_rounding: float = setting(
        1e3,
        doc="strain energy of a rigid-body motion, in machine epsilons of the largest stiffness",
        derived="rounding of entries of K that cancel in the product",
    )
    band_growth: float = setting(
        1.25,
        doc="ratio of successive frequency limits of a system whose stiffness is scaled down",
        derived="few steps: systems that soften gradually share one solution",
    )
    band_margin: float = setting(
        2.0,
        doc="highest frequency of the modes solved for over the highest frequency of a response",
        derived="each term of the truncation series is then a quarter of the one before",
    )
    modal_damping_band: float = setting(
        2e3,
        unit="Hz",
        doc="frequency up to which modal damping of a large structure is written as an attachment",
        tuned="chosen by judgement; test_modes.py and test_rebuilding.py pass with half and with twice",
    )


EIGENSOLUTION = EigensolutionSettings()


@dataclass(frozen=True)
class FarModesSettings(Settings):
    """Modes far above a band, whose sum is a polynomial of the squared frequency there."""

    ratio: float = setting(
        4.0,
        doc="eigenvalue over the largest squared frequency, above which a mode is far",
        derived="terms of the series fall by 0.072 each",
    )
    terms: int = setting(13, unit="terms", doc="terms of the series", derived="0.072^13 is 1.4e-15")


FAR_MODES = FarModesSettings()


@dataclass(frozen=True)
class DampedModeSettings(Settings):
    """Modes that structural or viscous damping couples."""

    relative_coupling: float = setting(
        1e-9,
        doc="off-diagonal modal damping over the diagonal above which modes are coupled",
        derived="rounding of modal damping in proportion to mass and stiffness is less",
    )
    orthogonality_tolerance: float = setting(
        1e-8,
        doc="departure from v^T v = 1 that ends Newton's iteration",
        derived="convergence is quadratic: the last step leaves its square, 1e-16",
    )
    near_coupling: float = setting(
        0.1,
        doc="viscous coupling over a mode's own dynamic stiffness above which modes are solved together",
        derived="block Jacobi iteration gains a digit a round below",
    )
    max_iterations: int = setting(
        40,
        unit="iterations",
        doc="block Jacobi iterations before all modes are solved together",
        tuned="timings of damped plates against one full solution",
    )


DAMPED_MODES = DampedModeSettings()


@dataclass(frozen=True)
class ReceptanceSettings(Settings):
    """Choice between the Woodbury identity and folding attachments into the matrices."""

    woodbury_columns: int = setting(
        8,
        unit="columns",
        doc="attached columns up to which the Woodbury identity costs less than new modes",
        tuned="timings of receptances",
    )
    woodbury_products_per_dof: float = setting(
        50.0,
        doc="attached columns times frequencies over DoFs up to which modes are not solved for again",
        tuned="timings of receptances",
    )
    truncation_terms: int = setting(
        4,
        unit="terms",
        doc="terms of the power series of the truncated modes",
        derived="ratio 1/4 of successive terms at a band margin of 2: a remainder below 1 %",
    )
    dense_assembly_dofs: int = setting(
        250,
        unit="DoFs",
        doc="system size up to which attachments are added to full matrices",
        tuned="timings of dense and sparse assembly",
    )


RECEPTANCE = ReceptanceSettings()


@dataclass(frozen=True)
class CacheSettings(Settings):
    """Entries of the caches of a system and its modes; the least recently used are dropped."""

    variants: int = setting(
        16, unit="systems", doc="rebuilt systems with other matrices", derived="memory of their modes"
    )
    member_factors: int = setting(
        2,
        unit="systems",
        doc="systems with other factors of members",
        derived="a fit asks for each in succession and never again; each caches variants of its own",
    )
    attachments: int = setting(
        64,
        unit="attachments",
        doc="attachments of one set of matrices",
        derived="every run of a test attaches the same ones; memory",
    )
    attachment_rows: int = setting(
        1_000_000,
        unit="rows",
        doc="rows of all cached attachments of one set of matrices",
        derived="memory: 8 MB a column",
    )
    folded_systems: int = setting(
        3,
        unit="systems",
        doc="systems with attachments folded into the matrices",
        derived="memory of their modes",
    )
    frequency_axes: int = setting(
        6,
        unit="axes",
        doc="frequency axes of an attachment's dynamic stiffness",
        derived="memory; all runs of a test share the blocks of one axis",
    )
    dynamic_stiffness_values: int = setting(
        8192,
        unit="values",
        doc="size of a cached dynamic stiffness",
        derived="two columns at a block of frequencies; memory: 128 KB",
    )
    modal_responses: int = setting(
        6, unit="axes", doc="frequency axes of modal responses", derived="memory of their denominators"
    )
    bases_with_responses: int = setting(
        16,
        unit="bases",
        doc="bases of modes whose responses are cached",
        derived="a run of a drifting test has its own; memory",
    )
    response_values: int = setting(
        125_000, unit="values", doc="size of a cached response, lines times modes", derived="memory: 2 MB"
    )
    modal_forces: int = setting(
        8, unit="forces", doc="modal forces whose coupled responses are cached", derived="memory"
    )
    receptance_map_values: int = setting(
        2**22, unit="values", doc="receptances from all DoFs", derived="memory: 64 MB"
    )
    element_matrices: int = setting(
        512, unit="elements", doc="bar elements with their matrices", derived="memory"
    )


CACHE = CacheSettings()


@dataclass(frozen=True)
class ReductionSettings(Settings):
    """Reduction to master DoFs and expansion of measured shapes."""

    max_condition: float = setting(
        1e13,
        doc="condition number of the slaves' stiffness beyond which it counts as singular",
        derived="hardly a digit of a solution is left in double precision",
    )
    min_master_motion: float = setting(
        1e-6,
        doc="least motion of the masters in a rigid-body mode, over its largest entry",
        tuned="chosen by judgement; tests of reductions pass with half and with twice the value",
    )
    serep_distinct_condition: float = setting(
        10.0,
        doc="condition number of modes at the masters up to which a mode is taken by default",
        derived="one digit of a measured shape is lost",
    )
    serep_max_condition: float = setting(
        1e6,
        doc="condition number of modes at the masters up to which requested modes are accepted",
        derived="six digits of a shape are lost",
    )
    serep_band_margin: float = setting(
        1.1,
        doc="highest frequency of default modes over the highest measured one",
        derived="a model may have a frequency 10 % too low",
    )
    serep_max_modes: int = setting(
        100, unit="modes", doc="elastic modes solved for by default", derived="time of an eigensolution"
    )
    doubtful_expansion: float = setting(
        0.1,
        doc="residual, or relative error of the Rayleigh quotient, above which an expanded shape is flagged",
        tuned="chosen by judgement; test_expansion.py passes with half and with twice the value",
    )


REDUCTION = ReductionSettings()
