"""Settings of project files."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ProjectSettings(Settings):
    """Limits of project files; bytes are limited as those of any upload."""

    max_things: int = setting(
        10_000, unit="objects", doc="most objects of a file", derived="memory and time of a hostile file"
    )
    max_json_bytes: int = setting(
        20_000_000,
        unit="bytes",
        doc="largest list of contents, and largest description of an object",
        derived="40,000 elements take 17 million; as empty lists they take 0.5 GB of memory",
    )
    overhead_bytes: int = setting(
        1_000,
        unit="bytes",
        doc="bytes of a zip for each of its files, and of a form for its one, beside the content",
        derived="two headers of 76 bytes at most and the name twice",
    )


PROJECT = ProjectSettings()
