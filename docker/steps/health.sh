#!/bin/sh
# Succeeds while the service on this machine answers /v1/health.
exec python3 -c '
import os, urllib.request
url = "http://127.0.0.1:" + os.environ.get("MODALLAB_PORT", "8000") + "/v1/health"
direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
try:
    direct.open(url, timeout=4).close()
except OSError as error:
    raise SystemExit(f"{url}: {error}") from None
'
