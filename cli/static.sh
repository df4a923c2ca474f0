#!/usr/bin/env bash
# Builds a program that needs no library of the system, for Linux on x86-64: cli/static.sh [folder]. It checks that the
# program is static and runs, and copies it, its manual pages and completions, and the licences into FOLDER
# (target/static). As root on Debian or Ubuntu it installs the compiler for C that a dependency needs.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/static}
target=x86_64-unknown-linux-musl
if ! command -v musl-gcc >/dev/null; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -qq && apt-get install -y -qq musl-tools >/dev/null
    else
        echo "cli/static.sh: needs musl-gcc; on Debian and Ubuntu: apt-get install musl-tools" >&2
        exit 1
    fi
fi
rustup target add "$target"
cargo build --release --target "$target"
built=target/$target/release/stosszahl
if ldd "$built" 2>/dev/null | grep -q '=>'; then
    echo "cli/static.sh: $built is not static:" >&2
    ldd "$built" >&2
    exit 1
fi
mkdir -p "$out"
cp "$built" LICENSE-APACHE LICENSE-MIT CITATION.cff "$out"
"$out/stosszahl" manual "$out/man"
for shell in bash zsh fish; do
    "$out/stosszahl" completions "$shell" >"$out/stosszahl.$shell"
done
"$out/stosszahl" --version
"$out/stosszahl" check quick --no-timing >/dev/null
echo "$out: $(du -sh "$out" | cut -f1)"
