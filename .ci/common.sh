# shellcheck shell=bash
# Shared by demo.sh and test.sh: sourced with bash, after `cd` to the top of the project.

WRY_BEGAN=$SECONDS

# say TEXT: a line with the time since the start.
say() {
  local seconds=$((SECONDS - WRY_BEGAN))
  printf '[%2d:%02d] %s\n' $((seconds / 60)) $((seconds % 60)) "$*"
}

# How many compilers at once: one per core, and 1.5 GB of memory for each.
jobs_here() {
  local cores memory_mb most
  cores=$(nproc)
  memory_mb=$(awk '/^MemAvailable:/ { print int($2 / 1024) }' /proc/meminfo)
  most=$((memory_mb / 1500))
  [ "$most" -ge 1 ] || most=1
  [ "$cores" -le "$most" ] && echo "$cores" || echo "$most"
}

# packages_for [test]: the names in packages.txt that the purpose needs.
packages_for() {
  awk -v purpose="${1:-}" '!/^[[:space:]]*(#|$)/ && (NF == 1 || $2 == purpose) { print $1 }' packages.txt
}

# install_packages [test]: installs what is missing of packages.txt; needs apt-get and root, but only if something is missing.
install_packages() {
  local missing=() name as_root=()
  if ! command -v dpkg-query >/dev/null; then
    say "not a Debian system: going on with what is there (see packages.txt)"
    return 0
  fi
  for name in $(packages_for "${1:-}"); do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
  done
  if [ ${#missing[@]} -eq 0 ]; then
    say "packages: all there"
    return 0
  fi
  say "packages: installing ${#missing[@]} (${missing[*]})"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { say "this needs root: apt-get install --no-install-recommends ${missing[*]}"; return 1; }
    as_root=(sudo -n)
  fi
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } \
    >"$log" 2>&1 </dev/null; then
    tail -n 30 "$log"
    rm -f "$log"
    say "packages: apt-get failed; by hand: apt-get install --no-install-recommends ${missing[*]}"
    return 1
  fi
  rm -f "$log"
  say "packages: done"
}

# configure PRESET [cmake options...]
configure() {
  local preset=$1 log
  shift
  local launcher=()
  if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  mkdir -p build
  log=build/configure-$preset.log
  if ! cmake --preset "$preset" "${launcher[@]}" "$@" >"$log" 2>&1 </dev/null; then
    tail -n 40 "$log"
    say "configure $preset: failed"
    return 1
  fi
}

# build PRESET [targets...]: with a line of progress about every half minute.
build() {
  local preset=$1 log last_line=$SECONDS
  shift
  log=build/build-$preset.log
  local targets=()
  [ $# -eq 0 ] || targets=(--target "$@")
  say "build $preset: $(jobs_here) at once"
  if ! NINJA_STATUS='[%f/%t] ' cmake --build "build/$preset" -j "$(jobs_here)" "${targets[@]}" 2>&1 </dev/null | tee "$log" |
    while IFS= read -r line; do
      case $line in
      \[*) if [ $((SECONDS - last_line)) -ge 30 ]; then
        say "build $preset: ${line%% *} files"
        last_line=$SECONDS
      fi ;;
      *) printf '%s\n' "$line" ;;
      esac
    done; then
    say "build $preset: failed (the log is $log)"
    return 1
  fi
  say "build $preset: done"
}
