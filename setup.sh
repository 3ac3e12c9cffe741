#!/bin/sh
# Installs what Telamon needs on Debian 12 or 13: Embree, libclang (bindgen reads Embree's header with
# it), a C compiler, and Rust unless there is one that is recent enough. Run it as root
# or as somebody who may use sudo; where nothing is missing it does nothing and says nothing.
# Of what is there it takes away nothing but an older Rust of apt's, and says so before.
#
# With --peers it also makes what `cargo test --features peers` compares with: tests/peers/venv, a
# Python environment with the engine and the renderer that tests/peers/requirements.txt pins. It
# installs Chromium for the test of the page that shows a render.
set -eu

packages='ca-certificates gcc libc6-dev libclang-dev libembree-dev'
peers=
case "$*" in
'') ;;
--peers)
    peers=yes
    packages="$packages chromium python3-venv"
    ;;
*)
    echo "usage: setup.sh [--peers]" >&2
    exit 2
    ;;
esac

if ! command -v apt-get >/dev/null; then
    echo "setup.sh: there is no apt-get here. Telamon needs Embree 3 or 4 with its headers, libclang," >&2
    echo "a C compiler and Rust; without the first three: cargo run --no-default-features ..." >&2
    exit 1
fi

root=$(dirname "$0")

# The version that Cargo.toml asks for.
needed=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' "$root/Cargo.toml")

fail() {
    printf 'setup.sh: %s\n' "$@" >&2
    exit 1
}

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

recent() {
    [ -n "$1" ] && dpkg --compare-versions "$1" ge "$needed"
}

cargo_version() {
    cargo --version 2>/dev/null | cut -d ' ' -f 2
}

# The cargo that would be found before one of apt's, if there is any.
cargo_in_front() (
    IFS=:
    for folder in $PATH; do
        if [ "$(readlink -f "$folder")" = /usr/bin ]; then return; fi
        if [ -x "$folder/cargo" ]; then
            echo "$folder/cargo"
            return
        fi
    done
)

# The version of a package that apt would install.
candidate() {
    LC_ALL=C apt-cache policy "$1" | sed -n 's/^  Candidate: \([^(]\)/\1/p'
}

missing=
for package in $packages; do
    installed "$package" || missing="$missing $package"
done

rust=
if ! recent "$(cargo_version)"; then
    rust=needed
    front=$(cargo_in_front)
    [ -z "$front" ] ||
        fail "Telamon needs cargo $needed or newer, but $front says: $(cargo --version 2>&1)" \
            "It comes before /usr/bin in PATH, so apt's would not be found: update or remove that one."
fi

if [ -n "$missing$rust" ]; then
    [ "$(id -u)" = 0 ] || command -v sudo >/dev/null ||
        fail "something is to be installed, and there is no sudo here: run this as root." \
            "Missing:$missing${rust:+ Rust $needed or newer}"
    as_root apt-get update -q
    if [ -n "$rust" ]; then
        # Debian keeps the Rust that its web browsers are built with beside its own.
        if recent "$(candidate rustc)"; then
            missing="$missing cargo rustc"
        elif recent "$(candidate rustc-web)"; then
            missing="$missing cargo-web rustc-web"
        else
            fail "Telamon needs Rust $needed or newer, but apt has rustc $(candidate rustc) and rustc-web" \
                "$(candidate rustc-web). Debian's security updates have a newer one (are they among apt's" \
                "sources?), and so has https://rustup.rs."
        fi
    fi

    # shellcheck disable=SC2086 # a list of words, here and below
    plan=$(apt-get install -s --no-install-recommends $missing) || fail "apt cannot install:$missing" "$plan"
    removed=$(echo "$plan" | sed -n 's/^Remv \([^ ]*\).*/\1/p' | sort | paste -s -d ' ')
    for package in $removed; do
        case $rust:$package in
        needed:cargo | needed:rustc) ;;
        needed:rustup) fail "apt's rustup is here, but without Rust $needed or newer: rustup default stable" ;;
        *)
            fail "apt would remove $removed for that, so nothing was installed. If that is all right:" \
                "apt-get install --no-install-recommends$missing"
            ;;
        esac
    done
    if [ -n "$removed" ]; then
        echo "setup.sh: Telamon needs Rust $needed or newer, so these packages of apt's older one are replaced: $removed."
        echo "setup.sh: In their place come cargo-web and rustc-web $(candidate rustc-web). Nothing else is removed, but an"
        echo "setup.sh: older clippy may not work with them: rust-web-clippy and rustfmt-web are theirs."
    fi
    # shellcheck disable=SC2086
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends $missing
fi

# The copy of the requirements comes last: a venv without it is not whole.
venv=$root/tests/peers/venv
pins=$root/tests/peers/requirements.txt
if [ -n "$peers" ] && ! cmp -s "$pins" "$venv/requirements.txt"; then
    # Debian's own Python: that of the package above, whatever comes first in PATH.
    /usr/bin/python3 -m venv --clear "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps --only-binary :all: \
        --require-hashes --requirement "$pins"
    cp "$pins" "$venv/requirements.txt"
fi
