"""Settings of the service, read from `MODALLAB_*` in the environment once, when a process starts."""

import ipaddress
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, SecretStr
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from modallab.jobs.durable import JobPlace
from modallab.store.place import StorePlace
from modallab.store.quotas import Quotas

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "[::1]")


def _names(value: Any) -> Any:
    return [name.strip().lower() for name in value.split(",")] if isinstance(value, str) else value


class ServiceSettings(BaseSettings):
    """Address, storage and limits of the service."""

    model_config = SettingsConfigDict(env_prefix="MODALLAB_", frozen=True)

    data: Path = Field(
        default=Path.home() / ".modallab", description="folder for arrays and the embedded database"
    )
    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=1, le=65535)
    open: bool = Field(
        default=False,
        description="answer everybody on an address that others reach, although there are no keys",
    )
    allowed_hosts: Annotated[tuple[str, ...] | None, NoDecode, BeforeValidator(_names)] = Field(
        default=None,
        description="names, separated by commas, by which a service without keys is asked for; else those of "
        "this machine where it listens to this machine only",
    )
    embedding_key: SecretStr | None = Field(
        default=None,
        description="key of the program that embeds the service: it may do everything, as without keys",
    )
    database_url: str | None = Field(default=None, description="postgresql://...; else SQLite in `data`")
    database_schema: str = Field(default="modallab", pattern=r"^[a-z][a-z0-9_]{0,40}$")
    role: Literal["all", "api"] = Field(default="all", description="`api` leaves jobs to `modallab worker`")
    executor_id: str | None = Field(
        default=None,
        min_length=1,
        max_length=128,
        description="a name for this process among those that run jobs; else from host and process",
    )
    queue_length: int = Field(default=1000, ge=1, description="jobs that may wait")
    key_queue_length: int = Field(default=100, ge=1, description="jobs of one key that may wait")
    class_queue_length: int = Field(default=500, ge=1, description="jobs of one class that may wait")
    key_stored_bytes: int = Field(
        default=5_000_000_000, ge=1, description="bytes stored for one key, above which nothing is added"
    )
    class_stored_bytes: int = Field(
        default=100_000_000_000, ge=1, description="bytes stored for one class, above which nothing is added"
    )
    job_seconds: float = Field(
        default=3600.0, gt=0, description="s, estimated duration above which a job is refused"
    )
    retention_days: float | None = Field(
        default=None, gt=0, description="days after which ended jobs and unnamed results are removed"
    )
    body_limit: int = Field(default=5_000_000, ge=1, description="bytes of a JSON request")
    upload_limit: int = Field(default=200_000_000, ge=1, description="bytes of an import, unpacked too")

    @property
    def embedded(self) -> bool:
        """True where the database is a file of this service alone."""
        return self.database_url is None or self.database_url.startswith("sqlite")

    @property
    def is_loopback(self) -> bool:
        """True where nobody but this machine reaches the service."""
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    @property
    def host_names(self) -> tuple[str, ...] | None:
        """Names by which a service without keys is asked for; None: any."""
        if self.allowed_hosts is None and not self.is_loopback:
            return None
        return (*LOOPBACK_NAMES, *(self.allowed_hosts or ()))

    @property
    def store_place(self) -> StorePlace:
        """Database URL, schema and array folder of the store."""
        url = self.database_url or f"sqlite:///{self.data / 'modallab.sqlite'}"
        return StorePlace(url, self.database_schema, self.data / "arrays")

    @property
    def queue_quotas(self) -> Quotas:
        """Jobs of a key, and of a class, that may wait."""
        return Quotas(self.key_queue_length, self.class_queue_length)

    @property
    def storage_quotas(self) -> Quotas:
        """Bytes that may be stored for a key, and for a class."""
        return Quotas(self.key_stored_bytes, self.class_stored_bytes)

    @property
    def job_place(self) -> JobPlace:
        """Database URL and schema of the job engine's tables."""
        url = self.database_url
        if url is None or self.embedded:
            url = f"sqlite:///{self.data / 'jobs.sqlite'}"
        return JobPlace(url, f"{self.database_schema}_jobs")
