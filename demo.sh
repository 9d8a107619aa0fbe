#!/usr/bin/env bash
# From a bare Debian 12 to pictures: installs what is missing, builds wry, and runs the bunny shot. Needs no terminal.
# Further options go to `wry run`, for example ./demo.sh --frames 1-48
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source .ci/common.sh

install_packages ""
configure demo
build demo wry

out=out/bunny-demo
say "simulating and drawing shots/bunny.toml: the soft micropolar bunny, a coarse mesh, its first second"
build/demo/wry run shots/bunny.toml --out "$out" --set body.bunny.resolution=0.06 --frames 1-25 "$@"

say "done"
echo "pictures: $PWD/$out/images"
