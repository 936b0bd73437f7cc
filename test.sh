#!/usr/bin/env bash
# Installs what is missing, builds and runs the tests; the last line is "N passed, N failed".
#   ./test.sh             the release build
#   ./test.sh --sanitize  the same tests with AddressSanitizer and UndefinedBehaviorSanitizer
source "$(dirname "${BASH_SOURCE[0]}")/cmake/prepare.sh"

preset=release
case "${1:-}" in
    "") ;;
    --sanitize) preset=asan ;;
    *) fail "test.sh: unknown argument \"$1\"; it takes none, or --sanitize." ;;
esac

install_missing $packages_build $packages_test
build "$preset" all

junit="$PWD/build/$preset/tests.xml"
rm -f "$junit"
ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" --output-junit "$junit" \
    --progress 2>&1 | grep -v -E '^\[.*\] +[0-9]+/[0-9]+|^ *[0-9]+/[0-9]+ Test .* (Passed|Skipped)|^ *Start ' || true
[ -f "$junit" ] || fail "ctest wrote no result; run: ctest --test-dir build/$preset"

count() { grep -o -m1 "$1=\"[0-9]*\"" "$junit" | grep -o '[0-9]*' | head -n 1; }
tests=$(count tests) failed=$(count failures) skipped=$(count skipped)
if [ "$skipped" != 0 ]; then
    say "$skipped skipped (LOOPLINE_DATA names the folder of downloaded logs):"
    grep -A 1 ': Skipped$' "$junit" | grep -v -e ': Skipped$' -e '^--$' | sort | uniq -c | sed 's/^ */  /'
fi
say "$((tests - failed - skipped)) passed, $failed failed"
[ "$failed" = 0 ]
