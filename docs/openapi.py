"""Write the OpenAPI document of the service: `python -m docs.openapi`."""

import tempfile
from pathlib import Path

from modallab.api.app import create_app
from modallab.api.document import written
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.jobs.inline import InlineRunner

TARGET = Path(__file__).with_name("openapi.json")


def current() -> str:
    """Return the document of the running code, as its file has it."""
    with tempfile.TemporaryDirectory() as folder:
        settings = ServiceSettings(data=Path(folder))
        settings.store_place.prepare()
        app = create_app(settings, InlineRunner(job_book(settings), settings.store_place))
        return written(app.openapi())


if __name__ == "__main__":
    TARGET.write_text(current(), encoding="utf-8")
