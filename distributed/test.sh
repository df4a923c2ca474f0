#!/usr/bin/env bash
# Builds stosszahl-mpi and tests it over several processes: distributed/test.sh [arguments of the tests]. Those
# that kill processes are run with --include-ignored.
# Needs an MPI library with its compiler wrapper, and libclang. As root on Debian or Ubuntu it installs them. Exit code
# 77: there are none.
set -euo pipefail
cd "$(dirname "$0")/.."
is_there() { command -v mpicc >/dev/null && command -v mpirun >/dev/null && ls /usr/lib/llvm-*/lib/libclang*.so* >/dev/null 2>&1; }
if ! is_there && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq && apt-get install -y -qq libopenmpi-dev openmpi-bin libclang-dev clang >/dev/null || true
fi
if ! is_there; then
    echo "distributed/test.sh: needs mpicc, mpirun and libclang; on Debian and Ubuntu: apt-get install libopenmpi-dev openmpi-bin libclang-dev clang" >&2
    exit 77
fi
cargo clippy -p stosszahl-mpi --features mpi --all-targets -- -D warnings
cargo test -p stosszahl-mpi --features mpi -- --test-threads 1 "$@"
