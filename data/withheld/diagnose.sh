#!/bin/sh
# Diagnoses every withheld case: two minutes each with one cycle, a quarter of an hour with three (one core).
# Three cycles with a looser tolerance of the time steps and fewer evaluations, to save time; the error goes into the noise model.
set -e
cd "$(dirname "$0")/../.."
mkdir -p data/withheld/reports
for case in data/withheld/*/P1.csv; do
    folder=$(dirname "$case")
    more=""
    [ "$(wc -l < "$case")" -gt 500 ] && more="--set solver.tolerance=1e-3 --max-evaluations 20"
    # shellcheck disable=SC2086
    target/release/runner diagnose "$folder/P1.csv" "$folder/P2.csv" --mesh coarse --quick $more --out "target/withheld/$(basename "$folder")"
    cp "target/withheld/$(basename "$folder")/diagnosis.json" "data/withheld/reports/$(basename "$folder").json"
done
python3 data/withheld/verdicts.py
