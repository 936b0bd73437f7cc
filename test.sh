#!/usr/bin/env bash
# Installs what is missing, builds and runs the tests; the last line is "N passed, N failed".
#   ./test.sh             the release build
#   ./test.sh --sanitize  tests/unit, tests/property and tests/fuzz, with a program that has AddressSanitizer and
#                         UndefinedBehaviorSanitizer
source "$(dirname "${BASH_SOURCE[0]}")/cmake/prepare.sh"

preset=release
case "${1:-}" in
    "") ;;
    --sanitize) preset=asan ;;
    *) fail "test.sh: unknown argument \"$1\"; it takes none, or --sanitize." ;;
esac

install_missing $packages_build $packages_test
build release loopline_tests
[ $preset = release ] || build "$preset" loopline_tests

# Each shard of a test program leaves what its tests gave, or nothing if it crashed.
results="$PWD/build/$preset/test_results"
rm -rf "$results"
log="build/$preset/tests.log"
shards=$(ctest --test-dir "build/$preset" -N | sed -n 's/^ *Test *#[0-9]*: *//p')
sound=yes
ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" >"$log" 2>&1 || sound=no
[ $sound = yes ] || grep -v -E '^\[ +(RUN|OK) +\]|^ *Start |^\[-+\]' "$log"

passed=0 failed=0 skipped=0
count() { grep -c "$1" "$results/$shard.xml" || true; }
for shard in $shards; do
    if [ ! -f "$results/$shard.xml" ]; then
        say "The tests of $shard did not come to their end; run: ctest --test-dir build/$preset -R $shard -V"
        failed=$((failed + 1))
        continue
    fi
    run=$(count '<testcase .*status="run"') omitted=$(count '<testcase .*result="skipped"')
    bad=$(awk '/<testcase /{seen=0} /<failure /{if(!seen) n++; seen=1} END{print n+0}' "$results/$shard.xml")
    passed=$((passed + run - bad - omitted)) failed=$((failed + bad)) skipped=$((skipped + omitted))
done
if [ "$skipped" != 0 ]; then
    say "$skipped skipped (LOOPLINE_DATA names the folder of downloaded logs):"
    sed -n 's/.*<skipped message="[^&]*&#x0A;\([^"]*\)".*/\1/p' "$results"/*.xml |
        sed 's/&#x0A;//g; s/&apos;/'"'"'/g; s/&quot;/"/g; s/&lt;/</g; s/&gt;/>/g; s/&amp;/\&/g' | sort | uniq -c | sed 's/^ */  /'
fi
if [ $sound = no ] && [ $failed = 0 ]; then
    say "A test program ended badly after its tests; see $log."
    failed=1
fi
say "$passed passed, $failed failed"
[ "$failed" = 0 ]
