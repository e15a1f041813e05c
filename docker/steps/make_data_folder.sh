#!/bin/sh
# Makes the data folder $1, for the user and group $2 alone.
set -eu
install -d -m 0700 -o "$2" -g "$2" "$1"
