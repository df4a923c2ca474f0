#!/usr/bin/env bash
# One run for a folder of workspace/: run.sh FOLDER. CASE is the case, quick by default.
set -euo pipefail
folder=workspace/${1:?a folder of workspace}
mapfile -t settings < <(python3 -c '
import json, sys
for key, value in json.load(open(sys.argv[1])).items():
    print(f"--set\n{key}={json.dumps(value)}")' "$folder/point.json")
out=$folder/results
resume=()
if [ -e "$out/run.json" ]; then resume=(--resume); fi
stosszahl run "${CASE:-quick}" --out "$out" --threads "${ACTION_THREADS_PER_PROCESS:-1}" --stop-after 11h50m "${resume[@]}" "${settings[@]}"
