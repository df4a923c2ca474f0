#!/usr/bin/env bash
# Tests reports in a browser: study/report/browser.sh [arguments of pytest]. With SCREENSHOTS=1 it renews docs/screenshots.
# Needs Python 3.10 or later with venv, a package index that pip reaches, Chromium, and the program built in release mode. As root on
# Debian or Ubuntu it installs Chromium. Exit code 77: there is none.
set -euo pipefail
cd "$(dirname "$0")/../.."
work="$PWD/target/browser"
if [ ! -x target/release/stosszahl ]; then
    echo "browser.sh: target/release/stosszahl is missing; cargo build --release makes it" >&2
    exit 1
fi
browser="$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)"
if [ -z "$browser" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium >/dev/null || true
    browser="$(command -v chromium || true)"
fi
if [ -z "$browser" ]; then
    echo "browser.sh: no Chromium here; on Debian and Ubuntu: apt-get install chromium" >&2
    exit 77
fi
if [ ! -x "$work/venv/bin/python" ] && ! python3 -m venv "$work/venv"; then
    echo "browser.sh: python3 -m venv does not work; on Debian and Ubuntu: apt-get install python3-venv" >&2
    exit 1
fi
"$work/venv/bin/pip" install --quiet --disable-pip-version-check -r study/report/browser/requirements.txt
export BROWSER_PATH="$browser" STOSSZAHL="$PWD/target/release/stosszahl" RESULTS="$work/results" PYTHONDONTWRITEBYTECODE=1
# Most of the time pages are waited for.
exec "$work/venv/bin/python" -m pytest -p no:cacheprovider -n 2 study/report/browser "$@"
