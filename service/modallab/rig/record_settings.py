"""Settings of simulated time records and their spectra, with unit, meaning and origin."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class RecordSettings(Settings):
    """Simulated time records."""

    decay_threshold: float = setting(
        1e-6,
        unit="1",
        doc="amplitude at which a free decay has ended",
        derived="below the rounding of a measured spectrum",
    )
    max_samples: int = setting(
        2**26, unit="samples", doc="samples of all channels of one stretch", derived="memory: 0.5 GB"
    )
    noise_block: int = setting(
        2**18, unit="samples", doc="noise samples generated in one call", derived="cache size"
    )
    record_block: int = setting(
        2**15, unit="samples", doc="samples of the records in one batch", derived="cache size"
    )
    parallel_samples: int = setting(
        2**24, unit="samples", doc="samples of all channels of runs stepped in parallel", derived="memory"
    )
    kept_samples: int = setting(
        2**21,
        unit="samples",
        doc="samples of all channels of the time records that one test keeps",
        derived="a download of 16 MB in double precision",
    )
    kept_estimate_values: int = setting(
        2**19,
        unit="lines x FRFs",
        doc="FRF values of all estimates of one test that are kept, beside the last",
        derived="a download of 13 MB in double precision",
    )
    most_estimates: int = setting(
        100, unit="estimates", doc="estimates of one test that are kept", derived="frames of a slow film"
    )
    records_per_stretch: int = setting(
        32,
        unit="records",
        doc="length of a stretch of stationary signals",
        derived="the lead that is discarded costs little beside it",
    )


@dataclass(frozen=True)
class FreeDecaySettings(Settings):
    """Impulse responses of the channels."""

    solution_block: int = setting(
        2**22, unit="samples", doc="samples of all channels of runs that share a solution", derived="memory"
    )


@dataclass(frozen=True)
class RingingSettings(Settings):
    """Modes that ring on beyond a record."""

    widest: float = setting(
        4.4,
        unit="lines",
        doc="half bandwidth up to which a mode rings on beyond its record",
        derived="exp(-pi 4.4) = 1e-6 is left of others half a record after the blow, the latest one",
    )
    reach: float = setting(
        2.0,
        unit="lines",
        doc="distance from a resonance up to which spectra are fitted",
        derived="several times the width of a mode that matters: wider ones have all but died out",
    )
    spare_poles: int = setting(
        2, unit="poles", doc="poles of a fit beyond those in its region", derived="the nearest neighbours"
    )
    background: int = setting(
        6,
        unit="1",
        doc="degree of the polynomial beside the poles",
        derived="falls by half or more a degree, neighbours being modelled: 1e-2 of what is smooth already",
    )
    nodes_per_unknown: int = setting(
        1,
        unit="1",
        doc="frequencies for each complex unknown of a fit",
        derived="all channels share the poles",
    )
    aperiodic: float = setting(
        1e-6,
        unit="1",
        doc="frequency of a motion without oscillation over the region it is found in",
        derived="rounding of the root of a polynomial",
    )


@dataclass(frozen=True)
class BurstSettings(Settings):
    """Expected spectra of burst random."""

    n_impulses: int = setting(
        512,
        unit="impulses",
        doc="impulse times of a burst",
        derived="exact up to as many samples; resonances are resolved beyond",
    )
    record_block: int = setting(
        2**20, unit="samples", doc="samples of the records in one batch", derived="memory"
    )
    golden_ratio: float = setting(
        0.6180339887498949,
        unit="1",
        doc="step of the low-discrepancy sequence of impulse times",
        derived="(sqrt(5) - 1)/2",
    )


RECORDS = RecordSettings()
FREE_DECAY = FreeDecaySettings()
RINGING = RingingSettings()
BURST = BurstSettings()
