"""HTTP transport: addresses, keys, repeats and errors, whatever the content."""

import ipaddress
from collections.abc import AsyncGenerator, Mapping
from typing import Any
from urllib.parse import urlsplit

import httpx
from httpx_sse import aconnect_sse

from modallab_client import _retry, _wire
from modallab_client._embedded import ServiceProcess
from modallab_client._waiting import async_closing, async_run, async_sleep
from modallab_client.errors import UnreachableError
from modallab_client.settings import CONNECTION


class AsyncTransport:
    """One service, reached through one `httpx` client."""

    def __init__(
        self,
        base_url: str,
        *,
        api_key: str | None = None,
        http: httpx.AsyncClient | None = None,
        timeout: float = 60.0,
    ) -> None:
        self._base = base_url.rstrip("/")
        self._headers = {"Authorization": f"Bearer {api_key}"} if api_key else {}
        self._timeout = timeout
        self._owned = http is None
        # a proxy set up for the network must not catch what is meant for this machine
        self._http = http or httpx.AsyncClient(timeout=timeout, trust_env=not _on_this_machine(base_url))
        self._service: ServiceProcess | None = None
        self._ready = True

    def accompany(self, service: ServiceProcess) -> None:
        """Wait for this service before the first request, and end it in `aclose`."""
        self._service, self._ready = service, False

    async def wait_until_ready(self) -> None:
        """Return when the service answers.

        Raises
        ------
        ServiceStartError
            If an embedded service does not start.
        """
        while self._service is not None and not self._ready:
            try:
                reply = await self._http.get(f"{self._base}/v1/health")
                self._ready = reply.is_success
            except httpx.TransportError:
                self._ready = False
            if not self._ready:
                self._service.check_start()
                await async_sleep(CONNECTION.start_polling)

    async def aclose(self) -> None:
        """Close the connections, and end an embedded service."""
        if self._owned:
            await self._http.aclose()
        if self._service is not None:
            await async_run(self._service.stop)

    async def request(
        self,
        method: str,
        path: str,
        *,
        json: Any = None,
        files: Any = None,
        data: Mapping[str, Any] | None = None,
        params: Mapping[str, Any] | None = None,
    ) -> Any:
        """Return the reply's JSON, or its bytes where it is not JSON.

        Raises
        ------
        ClientError
            The class that the problem's `code` names.
        """
        await self.wait_until_ready()
        attempt = 0
        while True:
            try:
                reply = await self._http.request(
                    method,
                    self._base + path,
                    json=_wire.plain(json),
                    files=files,
                    data=data,
                    params=params,
                    headers=self._headers,
                )
                pause = _retry.pause_after_reply(method, attempt, reply.status_code, reply.headers)
                if pause is None:
                    return _content(reply)
            except httpx.TransportError as error:
                pause = _retry.pause_after_failure(method, attempt)
                if pause is None:
                    raise await self._unreachable(error) from error
            await async_sleep(pause)
            attempt += 1

    async def npz(self, path: str, params: Mapping[str, Any] | None = None) -> _wire.Arrays:
        """Return the arrays of an npz reply, read-only."""
        return _wire.read(_wire.arrays, await self.request("GET", path, params=params))

    async def events(self, path: str, *, patience: float) -> AsyncGenerator[_wire.Json]:
        """Yield the JSON of server-sent events; end quietly where the stream breaks or is silent too long.

        Raises
        ------
        ClientError
            If the service refuses the stream.
        """
        await self.wait_until_ready()
        timeout = httpx.Timeout(self._timeout, read=patience)
        headers = dict(self._headers)
        try:
            async with aconnect_sse(
                self._http, "GET", self._base + path, headers=headers, timeout=timeout
            ) as source:
                if source.response.is_error:
                    await source.response.aread()
                    _content(source.response)
                async with async_closing(source.aiter_sse()) as stream:
                    async for event in stream:
                        if event.data:
                            yield _wire.read(_wire.event, event.data)
        except httpx.TransportError:
            return

    async def _unreachable(self, error: httpx.TransportError) -> UnreachableError:
        if self._service is not None:
            await async_run(self._service.check_running)
        reason = str(error) or type(error).__name__
        return UnreachableError(f"no reply from {self._base}: {reason}", context={"url": self._base})


def _content(reply: httpx.Response) -> Any:
    kind = reply.headers.get("content-type", "")
    if reply.is_error:
        raise _wire.problem(reply.status_code, kind, reply.content)
    return _wire.payload(kind, reply.content)


def _on_this_machine(url: str) -> bool:
    host = urlsplit(url).hostname or ""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
