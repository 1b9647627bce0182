#!/usr/bin/env bash
# Installs what hemicube needs besides Rust, says what and why, and skips what is there already.
#
#   tools/setup.sh            to build and to run
#   tools/setup.sh --test     also what the tests need
#   tools/setup.sh --peers    also what tools/peers/run.py needs to run other renderers
#
# On Debian 12 and Ubuntu 22.04 packages come from apt (through sudo unless you are root). Elsewhere it lists what to install.
set -euo pipefail
cd "$(dirname "$0")/.."

# package, and what it is for
build_packages=(
  "g++              compiles the C++ of the mesh decoder and links the program"
  "libshaderc-dev   compiles GLSL to SPIR-V while building (not needed by the built program)"
  "glslang-dev      part of shaderc: the GLSL front end"
  "spirv-tools      part of shaderc: the SPIR-V optimiser"
)
run_packages=(
  "libvulkan1            finds the Vulkan drivers"
  "mesa-vulkan-drivers   Vulkan for AMD and Intel, and lavapipe: Vulkan on the CPU, for machines without a GPU"
)
test_packages=(
  "vulkan-validationlayers   checks every Vulkan call: a single message fails a test"
)
peers_packages=(
  "python3-venv   the other renderers live in a Python environment of their own"
  "libllvm19      Mitsuba's vectorised variant compiles with it; without it Mitsuba runs many times slower"
)

say() { printf '%s\n' "$*"; }
die() { printf 'setup: %s\n' "$*" >&2; exit 1; }

# The comment at the top of this file, as help.
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; }

wanted=("${build_packages[@]}" "${run_packages[@]}")
for_tests=false
for argument in "$@"; do
  case $argument in
    --test) for_tests=true; wanted+=("${test_packages[@]}") ;;
    --peers) wanted+=("${peers_packages[@]}") ;;
    -h | --help) usage; exit 0 ;;
    *) die "unknown argument '$argument' (see tools/setup.sh --help)" ;;
  esac
done

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    die "no root and no sudo: have an administrator run: $*"
  fi
}

install_packages() {
  local line name missing=()
  for line in "${wanted[@]}"; do
    name=${line%% *}
    is_installed "$name" && continue
    missing+=("$name")
    say "setup: to install: $line"
  done
  [ ${#missing[@]} -gt 0 ] || { say "setup: all packages are there"; return; }
  as_root apt-get update -q || die "apt-get update failed: is the network reachable?"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" ||
    die "apt-get could not install: ${missing[*]}"
}

explain_packages() {
  say "setup: no apt here. Please install what these Debian 12 packages hold, then build with cargo:"
  printf '  %s\n' "${wanted[@]}"
  say "The static libraries of shaderc, glslang (up to 13) and SPIRV-Tools must be found by the linker."
  exit 1
}

# build.rs links glslang's libraries by name; glslang 14 dropped one of them.
check_glslang() {
  compgen -G '/usr/lib/*/libOGLCompiler.a' >/dev/null ||
    die "this system's glslang is newer than 13, which build.rs cannot link yet: build on Debian 12 (for example in the container rust:1-bookworm)"
}

check_rust() {
  command -v cargo >/dev/null || die "no cargo: install Rust from https://rustup.rs, then run this again"
  local needed have
  needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
  have=$(rustc --version | cut -d' ' -f2)
  [ "$(printf '%s\n' "$needed" "$have" | sort -V | head -n1)" = "$needed" ] ||
    die "Rust $needed or newer is needed, this is $have: run rustup update"
  $for_tests || return 0
  cargo fmt --version >/dev/null 2>&1 || die "the tests need rustfmt: run rustup component add rustfmt"
  cargo clippy --version >/dev/null 2>&1 || die "the tests need clippy: run rustup component add clippy"
}

# A missing driver is an error, not a reason to skip: the tests run on a Vulkan device or fail.
check_vulkan() {
  [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
  compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null || compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null ||
    die "no Vulkan driver is installed (no file in /usr/share/vulkan/icd.d)"
}

check_rust
command -v apt-get >/dev/null || explain_packages
install_packages
check_glslang
check_vulkan
say "setup: ready"
