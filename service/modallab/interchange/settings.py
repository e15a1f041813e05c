"""Settings of file exchange: limits against hostile files, and layouts that formats prescribe."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

HOSTILE = "memory and time that a hostile file may cost"
UFF = "layout of universal files (I-deas Test Data Link)"


@dataclass(frozen=True)
class UniversalFileSettings(Settings):
    """Universal files (UFF): limits and layout."""

    max_bytes: int = setting(
        100_000_000,
        unit="bytes",
        doc="largest file",
        derived="120 FRFs of 12,801 lines with coherence take 90 million as text",
    )
    max_lines: int = setting(1_000_000, unit="lines", doc="longest function", derived=HOSTILE)
    max_datasets: int = setting(6_000, unit="datasets", doc="datasets of a file", derived=HOSTILE)
    max_small_bytes: int = setting(
        1_000,
        unit="bytes",
        doc="largest header or units; larger ones are ignored",
        derived=HOSTILE,
    )
    max_modes: int = setting(500, unit="modes", doc="modes of a file", derived=HOSTILE)
    max_dofs: int = setting(5_000, unit="DoFs", doc="degrees of freedom of a modal model", derived=HOSTILE)
    max_shape_entries: int = setting(
        500_000, unit="entries", doc="entries of all shapes together, padding zeros counted", derived=HOSTILE
    )
    max_shape_characters: int = setting(
        1_500_000,
        unit="characters",
        doc="longest dataset 55",
        derived="most nodes, 12 values each",
    )
    max_shape_nodes: int = setting(5_000, unit="nodes", doc="nodes of a dataset 55", derived=HOSTILE)
    max_header_bytes: int = setting(
        400, unit="bytes", doc="longest header line", derived="80 by the format; some programs write more"
    )
    max_row_bytes: int = setting(100, unit="bytes", doc="longest line of numbers", derived=UFF)
    header_lines: int = setting(12, unit="lines", doc="header of dataset 58, with mark", derived=UFF)
    shape_records: int = setting(8, unit="lines", doc="records of dataset 55 before nodes", derived=UFF)
    max_node: int = setting(999_999_999, doc="largest node number", derived="nine digits in ten columns")
    number_width: int = setting(13, unit="columns", doc="width of a number", derived=UFF)
    numbers_per_row: int = setting(6, unit="numbers", doc="numbers of a line", derived=UFF)
    text_width: int = setting(80, unit="characters", doc="longest line of text", derived=UFF)
    smallest_number: float = setting(
        1e-99,
        doc="magnitude below which zero is written",
        derived="exponents of two digits",
    )
    max_trace_nodes: int = setting(
        250, unit="nodes", doc="nodes of a trace line, pen lifts counted", derived=UFF
    )
    trace_nodes_per_row: int = setting(8, unit="nodes", doc="nodes of a line of dataset 82", derived=UFF)
    pen_lift: int = setting(0, doc="node number that stands for a pen lift", derived=UFF)
    axis_error: float = setting(
        1e-5, doc="relative error of the line spacing in a file", derived="six digits by the format"
    )


@dataclass(frozen=True)
class FrfTextSettings(Settings):
    """Text layout of the thesis program (`.FRF`, appendix E): limits and layout."""

    max_bytes: int = setting(
        100_000_000,
        unit="bytes",
        doc="largest file",
        derived="100 responses of 12,801 lines take 44 million, 120 million with all digits",
    )
    max_blocks: int = setting(6_000, unit="FRFs", doc="FRFs of a file", derived=HOSTILE)
    max_node: int = setting(999_999_999, doc="largest node number", derived="nine digits")
    max_frequency: float = setting(
        1e9, unit="Hz", doc="highest frequency and spacing", derived="beyond any test"
    )
    program_decimals: int = setting(3, unit="digits", doc="decimals of the program", derived="appendix E")
    all_decimals: int = setting(16, unit="digits", doc="decimals without loss", derived="double precision")
    values_per_row: int = setting(8, unit="numbers", doc="FRF numbers of a line", derived="appendix E")
    others_per_row: int = setting(
        10, unit="numbers", doc="coherences or frequencies of a line", derived="appendix E"
    )
    smallest_number: float = setting(
        1e-99,
        doc="magnitude below which zero is written",
        derived="exponents of two digits",
    )


@dataclass(frozen=True)
class ReadingSettings(Settings):
    """Measurements of any format."""

    head_bytes: int = setting(
        1_024, unit="bytes", doc="bytes that identify a format", derived="longest header"
    )
    model_head_bytes: int = setting(
        4_096, unit="bytes", doc="first bytes that identify a model's format", derived="longest header"
    )
    min_lines: int = setting(
        8, unit="lines", doc="least lines of an analyser", derived="bounds of the analyser"
    )
    max_lines: int = setting(
        1_000_000, unit="lines", doc="most lines of an analyser", derived="bounds of the analyser"
    )
    least_rounding: float = setting(
        1e-6,
        unit="lines",
        doc="rounding of frequencies beside their relative error",
        derived="double precision",
    )
    coherence_rounding: float = setting(
        1e-6, doc="amount by which a coherence of 1 may exceed it", derived="single precision"
    )
    max_files: int = setting(6_000, unit="files", doc="files of a test", derived=HOSTILE)
    max_listed: int = setting(
        20, unit="names", doc="variables or columns that a refusal lists", derived="readable"
    )
    max_depth: int = setting(8, unit="structures", doc="structures within structures", derived=HOSTILE)
    max_scale: float = setting(1e12, doc="largest factor to SI units", derived="nm and MN differ by 1e15")
    max_stated_averages: float = setting(1e9, doc="most effective averages", derived="beyond any test")
    max_averages: float = setting(100_000.0, doc="most averages", derived="bounds of `Analyser.averages`")
    max_magnitude: float = setting(
        1e30, doc="largest number of a file", derived="no unit gives larger ones, and their squares overflow"
    )
    axis_error: float = setting(
        1e-6, doc="relative error of frequencies, unless the format rounds more", derived="single precision"
    )


@dataclass(frozen=True)
class TableSettings(Settings):
    """Delimited text."""

    max_bytes: int = setting(
        100_000_000, unit="bytes", doc="largest text", derived="120 FRFs of 12,801 lines take 60 million"
    )
    max_header_lines: int = setting(400, unit="lines", doc="lines above the numbers", derived=HOSTILE)
    max_header_characters: int = setting(
        4_096, unit="characters", doc="characters that show whether it is text", derived="longest header"
    )
    min_rows: int = setting(
        3, unit="rows", doc="rows of equal columns that make a table", derived="a header has fewer"
    )
    rows_looked_at: int = setting(50, unit="rows", doc="rows that decide on the separator", derived="enough")
    name_lines: int = setting(2, unit="lines", doc="lines of names and units", derived="usual exports")
    header_looked_at: int = setting(
        40, unit="lines", doc="lines of the header that may tell points and kind", derived="usual exports"
    )
    axis_error: float = setting(
        1e-5, doc="relative error of frequencies in text", derived="six digits of usual exports"
    )
    coherence_digits: int = setting(
        7, unit="digits", doc="digits to which a coherence of 1 may be rounded", derived="single precision"
    )
    digit_error: float = setting(
        1e-6, unit="digits", doc="rounding of the last digit of a coherence", derived="double precision"
    )


@dataclass(frozen=True)
class ConfinementSettings(Settings):
    """The process that reads files of measurements."""

    max_bytes: int = setting(
        100_000_000,
        unit="bytes",
        doc="largest file, or files of a test together, and their arrays",
        derived="120 FRFs of 12,801 lines with coherence take 37 million, as text 90 million",
    )
    chunk_bytes: int = setting(1_000_000, unit="bytes", doc="bytes copied at a time", derived="memory")
    patience: float = setting(
        30.0, unit="s", doc="time beyond the processor time of the reader", derived="a busy computer"
    )
    processor_seconds: int = setting(
        3, unit="s", doc="processor time of the reader of a small file", derived=HOSTILE
    )
    bytes_per_second: float = setting(
        4e6, unit="bytes/s", doc="bytes for which it has one more second", derived="text of single columns"
    )
    memory_bytes: int = setting(
        300_000_000,
        unit="bytes",
        doc="data memory of the reader of a small file",
        derived="40 to 90 million for the program, 100 for arrays, twice",
    )
    memory_per_byte: int = setting(
        8, unit="bytes", doc="further memory for each byte of a file", derived="text, its rows, its numbers"
    )


@dataclass(frozen=True)
class Hdf5Settings(Settings):
    """HDF5 files."""

    max_datasets: int = setting(1_000, unit="datasets", doc="datasets of a group", derived=HOSTILE)
    max_depth: int = setting(8, unit="groups", doc="groups within groups", derived=HOSTILE)
    max_chunks: int = setting(20_000, unit="chunks", doc="chunks of a dataset", derived=HOSTILE)
    max_texts: int = setting(10_000, unit="strings", doc="strings of a dataset", derived=HOSTILE)
    max_text_length: int = setting(100, unit="characters", doc="longest string", derived=HOSTILE)


@dataclass(frozen=True)
class ModelFileSettings(Settings):
    """Files of models: matrices, Nastran bulk data, meshes."""

    sum_tolerance: float = setting(
        1e-6,
        doc="difference of assembled elements and whole matrices, relative to the largest entry",
        derived="single precision",
    )
    max_deck_bytes: int = setting(100_000_000, unit="bytes", doc="largest bulk data file", derived=HOSTILE)
    max_mesh_bytes: int = setting(200_000_000, unit="bytes", doc="largest mesh", derived=HOSTILE)
    max_coordinate: float = setting(
        1e12, unit="units of the mesh", doc="largest coordinate", derived="no structure is larger"
    )
    max_cells: int = setting(40_000, unit="cells", doc="cells of a mesh that become members", derived=HOSTILE)
    flatness: float = setting(
        1e-9, doc="depth of a mesh over its size, below which it is plane", derived="rounding of coordinates"
    )
    steepness: float = setting(
        1e-6, doc="deviation of a bar from Z, above which Z orients it", derived="rounding of coordinates"
    )
    min_bar_length: float = setting(1e-9, unit="m", doc="shortest bar", derived="rounding of coordinates")
    large_matrix_rows: int = setting(
        65_536,
        unit="rows",
        doc="rows from which an OUTPUT4 string has a word for its row",
        derived="2^16",
    )


UNIVERSAL = UniversalFileSettings()
FRF_TEXT_FILE = FrfTextSettings()
READING = ReadingSettings()
TABLE = TableSettings()
CONFINEMENT = ConfinementSettings()
HDF5 = Hdf5Settings()
MODEL_FILE = ModelFileSettings()
