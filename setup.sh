#!/bin/sh
# Installs what Telamon needs on Debian 12 or 13: Embree, libclang (bindgen reads Embree's header with
# it), a C compiler, and Rust unless there is one that is recent enough. Run it as root
# or as somebody who may use sudo; where nothing is missing it does nothing and says nothing.
#
# With --peers it also makes what `cargo test --features peers` compares with: tests/peers/venv, a
# Python environment with the engine and the renderer that tests/peers/requirements.txt pins.
set -eu

packages='ca-certificates gcc libc6-dev libclang-dev libembree-dev'
peers=
case "$*" in
'') ;;
--peers)
    peers=yes
    packages="$packages python3-venv"
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

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

have_rust() {
    version=$(cargo --version 2>/dev/null | cut -d ' ' -f 2)
    [ -n "$version" ] && dpkg --compare-versions "$version" ge "$needed"
}

# The version of a package that apt would install.
candidate() {
    apt-cache policy "$1" | sed -n 's/^  Candidate: //p'
}

missing=
for package in $packages; do
    installed "$package" || missing="$missing $package"
done

if [ -n "$missing" ] || ! have_rust; then
    as_root apt-get update -q
    if ! have_rust; then
        if dpkg --compare-versions "$(candidate rustc)" ge "$needed"; then
            missing="$missing cargo rustc"
        else
            # Debian 12 keeps the Rust that its web browsers are built with beside its own.
            missing="$missing cargo-web rustc-web"
        fi
    fi
    # shellcheck disable=SC2086 # a list of words
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends $missing
fi

if ! have_rust; then
    echo "setup.sh: \`cargo\` is $(cargo --version 2>&1), and Telamon needs $needed or newer." >&2
    echo "Another cargo comes before /usr/bin in PATH ($(command -v cargo)): update or remove that one." >&2
    exit 1
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
