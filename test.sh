#!/usr/bin/env bash
# Installs what is missing, builds and tests: on a bare Debian 12, from any folder, without a terminal.
#   ./test.sh                  what CI runs
#   ./test.sh --full           everything else besides: the long tests, all tests under sanitizers, clang-tidy on all files
#   ./test.sh --base REVISION  clang-tidy on the files changed since REVISION (default: the last 5 commits)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source .ci/common.sh

full=no
base=${WRY_BASE:-}
while [ $# -gt 0 ]; do
  case $1 in
  --full) full=yes ;;
  --base) base=${2:?--base needs a revision}; shift ;;
  -h | --help) sed -n '2,5p' "$0"; exit 0 ;;
  *) echo "unknown option $1; see --help" >&2; exit 2 ;;
  esac
  shift
done

# Under sanitizers go rotations, expressions and colliders, and the shot file's parser: what the time of a default run allows.
# --full takes the rest, the solvers with their kernels among it.
SANITIZED_TARGETS=(test_base test_scene test_shots)
TIDY_MOST_FILES=12
TIDY_MOST_SECONDS=420
results=()

# run_ctest PRESET [options...]: its closing line is kept for the end.
run_ctest() {
  local preset=$1 log=build/ctest-$1.log
  shift
  say "tests $preset: ctest $*"
  if ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(jobs_here)" "$@" >"$log" 2>&1 </dev/null; then
    results+=("$preset: $(grep -E 'tests passed' "$log" | tail -n 1)")
    say "tests ${results[-1]}"
    return 0
  fi
  grep -vE '^ *[0-9]+/[0-9]+ Test .* Passed|^ *Start +[0-9]+:' "$log" | tail -n 150
  say "tests $preset: FAILED (the log is $log)"
  return 1
}

check_format() {
  local files
  files=$(find sim shots render pipeline tests \( -name '*.cpp' -o -name '*.h' \) -not -path '*/build/*')
  # shellcheck disable=SC2086
  if ! clang-format --dry-run -Werror $files >build/format.log 2>&1; then
    grep -E 'error:' build/format.log | cut -d: -f1 | sort | uniq -c | head -n 20
    say "format: clang-format -i these files"
    return 1
  fi
  results+=("format: $(wc -w <<<"$files") files")
  say "${results[-1]}"
}

# The .cpp files to look at: changed since the base, or all of them with --full.
tidy_files() {
  if [ "$full" = yes ] || ! git rev-parse --git-dir >/dev/null 2>&1; then
    find sim shots render pipeline -name '*.cpp' | sort
    return
  fi
  local from=$base
  [ -n "$from" ] || from=$(git rev-parse -q --verify HEAD~5) || from=$(git rev-list --max-parents=0 HEAD | tail -n 1)
  git diff --name-only --diff-filter=d "$from" HEAD -- 'sim/**.cpp' 'shots/**.cpp' 'render/**.cpp' 'pipeline/**.cpp'
}

check_tidy() {
  local files=() listed began=$SECONDS done_files=0 file
  mapfile -t listed < <(tidy_files)
  for file in "${listed[@]}"; do
    # Only what this build compiles has a command line to check it with; kernels have one per instruction set.
    grep -q "/$file\"" build/release/compile_commands.json && [[ $file != *.kernel.cpp ]] && files+=("$file")
  done
  [ "$full" = yes ] || files=("${files[@]:0:TIDY_MOST_FILES}")
  for file in "${files[@]}"; do
    if [ "$full" = no ] && [ $((SECONDS - began)) -ge "$TIDY_MOST_SECONDS" ]; then
      break
    fi
    if ! clang-tidy -p build/release --quiet --extra-arg=-Wno-unknown-warning-option "$file" >build/tidy.log 2>/dev/null; then
      cat build/tidy.log
      say "tidy: $file"
      return 1
    fi
    done_files=$((done_files + 1))
  done
  results+=("tidy: $done_files of ${#listed[@]} changed files")
  say "${results[-1]}"
}

# run_sanitized PROGRAM [options...]
run_sanitized() {
  local program=$1 log=build/asan-$1.log
  shift
  if ! ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
    timeout 1200 "build/asan/tests/$program" --gtest_brief=1 "$@" >"$log" 2>&1 </dev/null; then
    tail -n 80 "$log"
    say "sanitized $program: FAILED (the log is $log)"
    return 1
  fi
  say "sanitized $program: $(grep -oE '[0-9]+ tests from .* ran' "$log" | tail -n 1)"
}

install_packages test
[ "$full" = no ] || install_packages full
mkdir -p build
check_format
configure release -DWRY_WARNINGS_AS_ERRORS=ON
build release
run_ctest release -LE long

configure bare -DWRY_WARNINGS_AS_ERRORS=ON
build bare
run_ctest bare -LE long
check_tidy

configure asan -DWRY_WARNINGS_AS_ERRORS=OFF
available=$(ninja -C build/asan -t targets all | grep -oE '^test_[a-z_]+: phony' | cut -d: -f1)
sanitized=()
for target in "${SANITIZED_TARGETS[@]}"; do
  grep -qx "$target" <<<"$available" && sanitized+=("$target")
done
build asan "${sanitized[@]}"
for target in "${sanitized[@]}"; do
  run_sanitized "$target"
done
results+=("sanitized: ${#sanitized[@]} programs, no finding")

if [ "$full" = yes ]; then
  run_ctest release -L long
  build asan
  for target in $available; do
    [[ " ${sanitized[*]} " == *" $target "* ]] || run_sanitized "$target"
  done
fi

say "everything passed:"
printf '  %s\n' "${results[@]}"
