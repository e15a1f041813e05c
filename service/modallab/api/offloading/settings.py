"""Settings of heavy requests: what is heavy, and what one may cost."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class OffloadingSettings(Settings):
    """Requests that worker processes answer, and the limits of these."""

    light: int = setting(
        64_000,
        unit="bytes",
        doc="stored description up to which a request about it is answered in a thread of the service",
        derived="600 degrees of freedom, whose modes take 40 ms: less than another process is worth",
    )
    array_bytes: int = setting(
        25,
        unit="bytes",
        doc="bytes of stored arrays that cost as much as one of a description",
        derived="130,000 values of FRFs are drawn, or written as text, in 0.1 s",
    )
    element_bytes: int = setting(
        400,
        unit="bytes",
        doc="description of one element of a beam or plate that a request describes by their number",
        derived="measured: 340 of a plate, 430 of a beam",
    )
    resident_bytes: int = setting(
        900_000_000,
        unit="bytes",
        doc="resident memory above which a process that answers is ended",
        derived="no process above 1 GB; 220 million are its libraries, 80 between two looks",
    )
    watch_interval: float = setting(
        0.05, unit="s", doc="time between two looks at it", derived="a core fills 100 million bytes in 0.05 s"
    )
    data_bytes: int = setting(
        3_000_000_000,
        unit="bytes",
        doc="data memory, resident or not, of a process that answers",
        derived="a factorisation asks for three times what it fills",
    )
    processor_seconds: float = setting(
        6.0,
        unit="s",
        doc="processor time of a request, that of the reader of its file not counted",
        derived="beside `seconds`, which pass on a busy machine, too: those are no fault of the request",
    )
    seconds: float = setting(
        9.0,
        unit="s",
        doc="time until the answer of a request without a file, the start of a process included",
        derived="the caller waits, and all are answered within 10 s",
    )
    file_seconds: float = setting(
        60.0,
        unit="s",
        doc="time until the answer of a request with a file",
        derived="the largest text takes 30 s of processor time",
    )
    waiting_seconds: float = setting(
        2.0,
        unit="s",
        doc="time that a request waits for a free process before it is refused",
        derived="whom another process may still answer in time hears of it early",
    )
    chunk_bytes: int = setting(
        1_000_000, unit="bytes", doc="bytes of a body copied at a time", derived="memory"
    )
    arenas: int = setting(
        2,
        unit="arenas",
        doc="arenas of the allocator that the threads of the service share",
        tuned="a class of 100: 265 MB, flat; by default 315 MB and growing",
    )


OFFLOADING = OffloadingSettings()
