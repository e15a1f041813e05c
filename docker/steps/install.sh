#!/bin/sh
# Installs the wheel in the folder $1, with the service's packages in the versions of the lock $2, into
# a new environment $3. The environment has no pip of its own: nothing is installed into it later.
set -eu
for wheel in "$1"/modallab-*.whl; do
    python3 -m venv --without-pip "$3"
    python3 -m pip --python "$3/bin/python" --quiet --disable-pip-version-check \
        install --constraint "$2" "$wheel[service]"
    python3 -m pip --python "$3/bin/python" --disable-pip-version-check check
done
