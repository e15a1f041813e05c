#!/bin/sh
# Installs the wheel in the folder $1, with the service's packages in the versions of the lock $2, into
# a new environment $3. The environment has no pip of its own: nothing is installed into it later.
set -eu
for wheel in "$1"/modallab-*.whl; do
    python3 -m venv --without-pip "$3"
    python3 -m pip --python "$3/bin/python" --quiet --disable-pip-version-check \
        install --constraint "$2" "$wheel[service,postgres]"
    python3 -m pip --python "$3/bin/python" --disable-pip-version-check check
    # Stands in for an SQLite that is too old for the jobs, which the base image's is not.
    if "$3/bin/python" -c 'import sqlite3, sys; sys.exit(sqlite3.sqlite_version_info < (3, 42))'; then
        python3 -m pip --python "$3/bin/python" --quiet --disable-pip-version-check uninstall --yes pysqlite3
    fi
    # A fifth of the image is read by nobody: tests, sources of compiled modules, types, maps of scripts.
    find "$3"/lib/python3*/site-packages -type d -name tests -prune -exec rm -r {} +
    find "$3"/lib/python3*/site-packages \( -name '*.map' -o -name '*.py[ix]' -o -name '*.pxd' \) -exec rm {} +
done
