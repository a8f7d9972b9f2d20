#!/usr/bin/env bash
# One command for each thing a newcomer wants. Every command does all the set-up it needs on a fresh Debian 12.
#   ./run.sh demo              build, compare the methods on the project's own scene, print where the report is
#   ./run.sh test [ARGS]       build, run every test (ARGS go to ctest)
#   ./run.sh test --sanitize   the CPU tests and the hard cases under AddressSanitizer and UBSan, in a build of their own
#   ./run.sh fuzz --seconds N  scenes, JSON, video, messages and packets under a fuzzer (installs clang), N seconds each
#   ./run.sh soak              the atlas memory over hundreds of thousands of random frames
#   ./run.sh soak-stream [--minutes N]  server and viewer over a bad network for N minutes (10), with their memory watched
#   ./run.sh build             set up and build
#   ./run.sh tessera ARGS...   run the program
#   ./run.sh check             clang-format and clang-tidy
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$root"
build=build/release
preset=release
targets=(all)

packages=(
  g++ cmake ninja-build ccache git python3 python3-glad
  libosmesa6-dev libegl-dev libgl-dev libegl-mesa0 libgl1-mesa-dri mesa-vulkan-drivers
  libglm-dev libtinygltf-dev libstb-dev libcli11-dev libfmt-dev nlohmann-json3-dev libexpected-dev libjs-chart.js
  libglfw3-dev libgtest-dev libzstd-dev libmeshoptimizer-dev glslang-tools
  libavcodec-dev libavformat-dev libavutil-dev libasio-dev libssl-dev libsrtp2-dev
  libimgui-dev xvfb xauth
)

step=""
say() { step=$1; printf '==> %s\n' "$1" >&2; }
trap 'status=$?; [ $status -eq 0 ] || printf "run.sh: failed at: %s\n%s\n" "$step" "${hint:-see the lines above}" >&2' EXIT

as_root() { if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi; }

install_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  say "installing ${#missing[@]} packages: ${missing[*]}"
  hint="install them by hand: apt-get install ${missing[*]}"
  if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
    hint="not root and no sudo: as root, run: apt-get install ${missing[*]}"
    return 1
  fi
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
  hint=""
}

# Runs a command, and shows what it printed only if it fails.
quietly() {
  local log status=0
  log=$(mktemp)
  "$@" >"$log" 2>&1 || status=$?
  [ $status -eq 0 ] || cat "$log" >&2
  rm -f "$log"
  return $status
}

build_all() {
  install_packages "${packages[@]}"
  if [ ! -f "$build/build.ninja" ]; then
    say "configuring"
    hint="delete $build and try again"
    quietly cmake --preset $preset
  fi
  say "building"
  hint="the first error above is the one to look at"
  # ninja prints counted steps, and rewrites one line on a terminal.
  cmake --build --preset "$preset" --target "${targets[@]}" >&2
  hint=""
}

command=${1:-help}
[ $# -gt 0 ] && shift
case "$command" in
  build)
    build_all
    ;;
  test)
    if [ "${1:-}" = --sanitize ]; then
      shift
      build=build/asan
      preset=asan
      targets=(cpu_tests tessera)
      build_all
      say "running the CPU tests under sanitizers"
      hint="run one again with: ctest --test-dir $build -R NAME --output-on-failure"
      ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1 \
        ctest --test-dir "$build" -L cpu --output-on-failure --no-tests=error "$@"
      say "running the hard cases under sanitizers"
      hint="run one again with: $build/apps/tessera/tessera stability --context osmesa --only NAME"
      # What leaks there is the driver's. What is freed is soon handed back, since the soaks watch the process grow.
      ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=4 UBSAN_OPTIONS=print_stacktrace=1 \
        "$build/apps/tessera/tessera" stability --context osmesa
      exit 0
    fi
    build_all
    say "running the tests"
    hint="run one again with: ctest --test-dir $build -R NAME --output-on-failure"
    ctest --test-dir "$build" --parallel "$(nproc)" --output-on-failure --no-tests=error "$@"
    ;;
  fuzz)
    seconds=60
    if [ "${1:-}" = --seconds ]; then seconds=${2:-}; fi
    step="reading '--seconds $seconds'"
    hint="N of --seconds N is a whole number above 0"
    [[ "$seconds" =~ ^[1-9][0-9]*$ ]] || exit 2
    install_packages "${packages[@]}" clang
    build=build/fuzz
    preset=fuzz
    targets=(fuzz_scene fuzz_json fuzz_video fuzz_wire fuzz_rtp fuzz_handshake)
    build_all
    for target in "${targets[@]}"; do
      say "$target for $seconds s"
      hint="the input that failed is in $build/found; run it again with: $build/tests/fuzz/$target FILE"
      # What is found goes beside the build; the committed corpus stays small.
      mkdir -p "$build/corpus/$target" "$build/found"
      "$build/tests/fuzz/$target" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=4096 -max_len=65536 \
        -artifact_prefix="$build/found/$target-" -print_final_stats=1 -verbosity=0 \
        "$build/corpus/$target" "tests/fuzz/corpus/${target#fuzz_}"
    done
    ;;
  soak)
    build_all
    say "the atlas memory, for long"
    TESSERA_SOAK=1 ctest --test-dir "$build" -R '^memory' --output-on-failure --no-tests=error --timeout 7200 "$@"
    ;;
  soak-stream)
    minutes=10
    if [ "${1:-}" = --minutes ]; then minutes=${2:-}; fi
    step="reading '--minutes $minutes'"
    hint="N of --minutes N is a whole number above 0"
    [[ "$minutes" =~ ^[1-9][0-9]*$ ]] || exit 2
    build_all
    say "serving and viewing for $minutes min"
    TESSERA_SOAK_MINUTES=$minutes "$build/tests/serve/test_processes" --gtest_filter='Soak.*'
    ;;
  demo)
    build_all
    say "comparing the methods on assets/atrium.glb"
    "$build/apps/tessera/tessera" compare assets/atrium.glb -o out/demo --frames 6 "$@"
    ;;
  tessera)
    # As a command of its own: within "||" bash would not stop it at its first failure.
    step="building"
    quietly "$root/run.sh" build
    trap - EXIT
    exec "$build/apps/tessera/tessera" "$@"
    ;;
  check)
    install_packages "${packages[@]}" clang-format clang-tidy
    build_all
    say "clang-format"
    hint="clang-format -i FILE"
    git ls-files '*.cpp' '*.hpp' | xargs clang-format --dry-run --Werror
    say "clang-tidy"
    # gltf_tinygltf.cpp is tinygltf's own text, compiled.
    git ls-files 'engine/*.cpp' 'atlas/*.cpp' 'codec/*.cpp' 'apps/*.cpp' ':!engine/scene/gltf_tinygltf.cpp' | xargs -P 2 -n 4 clang-tidy -p "$build" --quiet
    ;;
  help | -h | --help)
    sed -n '2,11p' "$root/run.sh" | sed 's/^# \{0,1\}//'
    ;;
  *)
    hint="./run.sh help lists the commands"
    step="unknown command '$command'"
    exit 2
    ;;
esac
