# Sourced by demo.sh and test.sh: installs what is missing, configures and builds. Debian 12, as root or with sudo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*"; }
fail() { printf '%s\n' "$*" >&2; exit 1; }

# What each use needs, and nothing else. "build" makes the program, "demo" adds the sample log, "test" GoogleTest, the
# MRPT programs that tests compare with or load our plugins into, and a cache of what was compiled before.
packages_build="g++ cmake ninja-build libmrpt-maps-dev libembree-dev zlib1g-dev libisal-dev libssl-dev libcli11-dev nlohmann-json3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev libfreetype-dev fonts-dejavu-core"
packages_demo="mrpt-common"
packages_test="ccache mrpt-common libgtest-dev mrpt-apps libmrpt-hwdrivers-dev libgeographiclib-dev gdal-bin"

install_missing() {
    local missing="" package
    for package in "$@"; do
        [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    local root=""
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || fail "These packages are missing:$missing. Run this script as root, or install sudo."
        root=sudo
    fi
    say "Installing$missing ..."
    local log; log=$(mktemp)
    if ! { $root apt-get update -qq && DEBIAN_FRONTEND=noninteractive \
           $root apt-get install -y -qq --no-install-recommends $missing; } >"$log" 2>&1; then
        tail -n 20 "$log" >&2
        fail "apt-get could not install$missing; its last lines are above, all of them in $log."
    fi
    rm -f "$log"
}

# Jobs: as many as there are processors, but no more than the memory carries (an MRPT source takes up to 0.8 GB).
jobs() {
    local cores memory_gb
    cores=$(nproc)
    memory_gb=$(awk '/MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo)
    [ "$memory_gb" -ge 1 ] || memory_gb=1
    [ "$cores" -le "$memory_gb" ] && echo "$cores" || echo "$memory_gb"
}

# build PRESET TARGET...
build() {
    local preset=$1 log; shift
    mkdir -p "build/$preset"
    log="build/$preset/build.log"
    [ -f "build/$preset/CMakeCache.txt" ] && say "Building ($preset) ..." ||
        say "Building ($preset); the first time takes a few minutes ..."
    if ! { cmake --preset "$preset" && cmake --build "build/$preset" -j "$(jobs)" --target "$@"; } >"$log" 2>&1; then
        tail -n 40 "$log" >&2
        fail "The build failed; its last lines are above, all of them in $log."
    fi
}
