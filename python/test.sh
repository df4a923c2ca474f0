#!/usr/bin/env bash
# Builds the wheel, installs it into an empty environment, and tests it there: python/test.sh [arguments of pytest].
# Needs Rust, Python 3.10 or later with venv, and a package index that pip reaches.
set -euo pipefail
cd "$(dirname "$0")"
work="$PWD/../target/python"
if ! python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))'; then
    echo "python/test.sh: needs Python 3.10 or later; found $(python3 --version 2>&1)" >&2
    exit 1
fi
rm -rf "$work"
if ! python3 -m venv "$work/build" || ! python3 -m venv "$work/empty"; then
    echo "python/test.sh: python3 -m venv does not work; on Debian and Ubuntu: apt-get install python3-venv" >&2
    exit 1
fi
quiet=(--quiet --disable-pip-version-check)
"$work/build/bin/pip" install "${quiet[@]}" "maturin>=1.9,<2"
"$work/build/bin/maturin" build --quiet --release --out "$work/wheels"
du -h "$work"/wheels/*.whl
"$work/empty/bin/pip" install "${quiet[@]}" "$work"/wheels/*.whl
"$work/empty/bin/pip" install "${quiet[@]}" -r tests/requirements.txt
# From another folder, so that the package is the one that was installed.
cd "$work"
"$work/empty/bin/python" -m pytest -n 2 --dist worksteal -c ../../python/pyproject.toml --rootdir ../../python "../../python/tests" "$@"
