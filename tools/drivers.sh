#!/bin/sh
# Runs the stability suite on three Vulkan drivers without a GPU, and prints their errors side by side:
# the system's lavapipe, the newer one of Debian's backports, and SwiftShader as Chromium ships it.
#
#   tools/drivers.sh [FOLDER]              default: target/drivers
#   DRIVERS="swiftshader" tools/drivers.sh  some of: system backports swiftshader
#   COMMAND="cargo test --release" tools/drivers.sh   runs this on each driver instead
#
# Packages are unpacked below FOLDER; nothing is installed. Debian 12 on x86-64. Every row is in FOLDER/results/rows.md, the
# worst of each kind is printed; exits with 1 if a row is out of bounds or a command fails.
set -eu
cd "$(dirname "$0")/.."
mkdir -p "${1:-target/drivers}"
folder=$(cd "${1:-target/drivers}" && pwd)
drivers=${DRIVERS:-system backports swiftshader}
set -- # from here on: the tables

# repository RELEASE: where this machine gets that release of Debian from.
repository() {
    apt-get indextargets --format '$(CODENAME) $(REPO_URI)' | sed -n "s/^$1 //p" | sort -u | head -n 1
}

# unpack NAME "REPOSITORY SUITE" PACKAGE...: the packages of that suite below FOLDER/NAME, once.
unpack() {
    name=$1 suite=$2
    shift 2
    root=$folder/$name
    [ -e "$root/done" ] && return
    rm -rf "$root" && mkdir -p "$root/apt/lists/partial" "$root/apt/cache/archives/partial" "$root/debs"
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $suite main" > "$root/apt/sources.list"
    set -- -o Dir::Etc::sourcelist="$root/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o Dir::State::lists="$root/apt/lists" -o Dir::Cache="$root/apt/cache" -o APT::Sandbox::User= -- "$@"
    options=""
    while [ "$1" != -- ]; do options="$options $1" && shift; done
    shift
    # shellcheck disable=SC2086 # options are words
    apt-get -qq $options update
    # shellcheck disable=SC2086
    (cd "$root/debs" && apt-get -qq $options download "$@")
    for package in "$root"/debs/*.deb; do dpkg -x "$package" "$root"; done
    touch "$root/done"
}

# icd NAME: the file that names the driver to Vulkan's loader, its library by full path.
icd() {
    case $1 in
        backports)
            sed "s|\"library_path\": \"[^\"]*\"|\"library_path\": \"$folder/backports/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so\"|" \
                "$folder"/backports/usr/share/vulkan/icd.d/lvp_icd*.json > "$folder/backports.json"
            echo "$folder/backports.json" ;;
        swiftshader)
            sed "s|\"library_path\": \"[^\"]*\"|\"library_path\": \"$folder/swiftshader/usr/lib/chromium/libvk_swiftshader.so\"|" \
                "$folder/swiftshader/usr/lib/chromium/vk_swiftshader_icd.json" > "$folder/swiftshader.json"
            echo "$folder/swiftshader.json" ;;
        system) echo /usr/share/vulkan/icd.d/lvp_icd.x86_64.json ;;
        *) echo "no such driver: $1" >&2 && exit 2 ;;
    esac
}

cargo build --release --locked
failed=0
for driver in $drivers; do
    case $driver in
        backports) unpack backports "$(repository bookworm) bookworm-backports" mesa-vulkan-drivers libdrm2 libdrm-amdgpu1 ;;
        swiftshader) unpack swiftshader "$(repository bookworm-security) bookworm-security" chromium-common ;;
    esac
    file=$(icd "$driver")
    export VK_DRIVER_FILES="$file" VK_ICD_FILENAMES="$file"
    [ "$driver" != backports ] || export LD_LIBRARY_PATH="$folder/backports/usr/lib/x86_64-linux-gnu"
    echo "== $driver"
    if [ -n "${COMMAND:-}" ]; then
        $COMMAND || { failed=1 && echo "== $driver: failed"; }
    else
        set -- "$@" "$folder/results/$driver/stability.csv"
        target/release/hemicube convergence --stability -q -o "$folder/results/$driver" || { failed=1 && echo "== $driver: rows out of bounds"; }
    fi
    unset LD_LIBRARY_PATH
done
if [ -z "${COMMAND:-}" ]; then
    python3 tools/side_by_side.py "$@" > "$folder/results/rows.md"
    python3 tools/side_by_side.py --short "$@"
fi
exit $failed
