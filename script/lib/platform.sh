# What the machine must have before a build, found and installed where that is allowed.
# Sourced by script/run and script/test.

say() { printf '%s\n' "defocus: $*" >&2; }

# Packages by distribution family, for the headless part and for a window.
debian_headless="libvulkan1 mesa-vulkan-drivers"
debian_window="libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2"

# Reads the list to its end (grep -q would break the pipe, which `pipefail` reports as "not
# there"), and finds ldconfig where only root has it in the path.
has_library() { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -F "$1" >/dev/null; }

has_vulkan_driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] && return 0
    local folder
    for folder in /usr/share /etc /usr/local/share /usr/local/nvidia/share; do
        compgen -G "$folder/vulkan/icd.d/*.json" >/dev/null && return 0
    done
    return 1
}

print_commands() {
    say "missing: $*. Install with the command of your distribution:"
    say "  Debian, Ubuntu:  sudo apt-get install $debian_headless $debian_window"
    say "  Fedora:          sudo dnf install vulkan-loader mesa-vulkan-drivers libxkbcommon-x11 libXcursor libXi libXrandr"
    say "  Arch:            sudo pacman -S vulkan-icd-loader vulkan-swrast libxkbcommon-x11 libxcursor libxi libxrandr"
    say "  openSUSE:        sudo zypper install libvulkan1 Mesa-vulkan-device-select libvulkan_lvp libxkbcommon-x11-0 libXcursor1 libXi6 libXrandr2"
}

# apt_install PACKAGE...: installs as root or through a password-less sudo; fails otherwise.
apt_install() {
    command -v apt-get >/dev/null 2>&1 || return 1
    local as=""
    if [ "$(id -u)" != 0 ]; then
        sudo -n true 2>/dev/null || return 1
        as="sudo"
    fi
    say "installing through apt: $*"
    $as apt-get update -qq >/dev/null && DEBIAN_FRONTEND=noninteractive $as apt-get install -y -qq "$@" >/dev/null
}

# need_libraries [window]: a Vulkan loader and driver and, for a window, X client libraries.
need_libraries() {
    # macOS and Windows bring Metal and Direct3D 12: nothing is missing there.
    [ "$(uname -s)" = Linux ] || return 0
    local missing="" packages=""
    if ! has_library libvulkan.so.1; then missing="$missing Vulkan loader"; packages="$packages libvulkan1"; fi
    if ! has_vulkan_driver; then missing="$missing Vulkan driver"; packages="$packages mesa-vulkan-drivers"; fi
    if [ "${1:-}" = window ] && ! { has_library libxkbcommon-x11.so && has_library libXcursor.so && has_library libXi.so; }; then
        missing="$missing X client libraries"; packages="$packages $debian_window"
    fi
    [ -n "$missing" ] || return 0
    # shellcheck disable=SC2086  # a list of package names
    if ! apt_install $packages; then
        print_commands "$missing"
        exit 1
    fi
}

need_rust() {
    command -v cargo >/dev/null 2>&1 && return 0
    say "missing: Rust. Install it from https://rustup.rs, then run this again."
    exit 1
}
