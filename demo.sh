#!/usr/bin/env bash
# Installs what is missing, builds, and maps the Telecom Faculty: the real log that Debian's mrpt-common ships.
source "$(dirname "${BASH_SOURCE[0]}")/cmake/prepare.sh"

install_missing $packages_build $packages_demo
build release loopline_product

out=runs/telecom_faculty_lines
build/release/bin/loopline run ini/real/telecom_faculty_lines.ini --out "$out"

say ""
say "Pictures:  $PWD/$out/snapshots"
say "Report:    $PWD/$out/report.html"
