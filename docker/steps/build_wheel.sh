#!/bin/sh
# Builds the wheel of the source folder $1 into the folder $2.
set -eu
python3 -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir "$2" "$1"
