"""What runs the jobs, as the settings name it."""

from modallab.api.settings import ServiceSettings
from modallab.jobs.book import JobBook
from modallab.jobs.durable import DurableRunner
from modallab.jobs.retention import Retention
from modallab.store.place import engine_of


def job_book(settings: ServiceSettings) -> JobBook:
    """Return the book of jobs that the settings name."""
    return JobBook(
        engine_of(settings.store_place), queue_length=settings.queue_length, quotas=settings.queue_quotas
    )


def durable_runner(settings: ServiceSettings) -> DurableRunner:
    """Return the runner that the settings name; with role `api` it only submits."""
    book = job_book(settings)
    return DurableRunner(
        book,
        settings.store_place,
        settings.job_place,
        executor_id=settings.executor_id,
        runs=settings.role == "all",
        retention=Retention(book, settings.store_place, settings.retention_days),
    )
