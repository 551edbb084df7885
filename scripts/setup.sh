# shellcheck shell=bash
# Sourced by scripts/run, scripts/test and benchmarks/gpu_check: puts a machine in a state to build and run, then builds.
#   install_packages build|tests  what scripts/packages.txt lists; needs no network when all of it is there
#   build TARGET...             configure once, then ninja, into build/ or the folder that RESTIRPG_BUILD names
# RESTIRPG_SKIP_SETUP=1 leaves the machine's packages alone. Errors: one line, exit code 2.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build_folder=${RESTIRPG_BUILD:-$root/build}
[[ $build_folder == /* ]] || build_folder=$PWD/$build_folder
[[ -z ${RESTIRPG_BUILD:-} ]] || export RESTIRPG_BUILD=$build_folder  # for programs started in another folder
python=/usr/bin/python3  # the distribution's own: its packages do not belong to another python3 that comes first on PATH
apt_folder=${RESTIRPG_APT_FOLDER:-/etc/apt}  # the tests point it at samples
may_lack='chromium|chromium-driver'  # not in Ubuntu's archive: the tests that need them skip
from_backports='mesa-vulkan-drivers|python3-scikit-build-core'  # what Debian 12 has too old or not; all else is the release's own
least_mesa=25  # lavapipe 22 of Debian 12 lacks ray query and shader features that the kernels use

# The comment at the head of the script that sources this.
print_help()
{
    sed -n '2,${/^#/!q;/shellcheck/!s/^# \{0,1\}//p}' "$0"
}

stop()
{
    echo "setup: $*" >&2
    exit 2
}

# The names listed in packages.txt; without the argument "tests", those before the line "# tests only".
package_names()
{
    awk -v role="$1" '/^# tests only/ && role != "tests" {exit} /^[^#]/ {print $1}' "$root/scripts/packages.txt"
}

# Of the names on standard input, those not installed. One query for all: a start with nothing to do stays fast.
not_installed()
{
    local names
    names=$(cat)
    # shellcheck disable=SC2086  # one name a word
    { dpkg-query -W -f '${Package} ${db:Status-Status}\n' $names 2>/dev/null || true; } |
        awk '$2 == "installed" {print $1}' | sort -u | comm -13 - <(sort <<<"$names")
}

mesa_is_old()
{
    local version
    version=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null) || return 0
    dpkg --compare-versions "$version" lt "$least_mesa"
}

# The machine's own apt entry of suite $1, as one for $1-backports: mirror, keyring and options carry over. Other vendors have
# entries of that suite, too: one whose address ends in /debian comes first, as those of Debian's mirrors do.
# Prints the file's extension (sources or list) on the first line, then its text; nothing when there is no such entry.
backports_entry()
{
    local suite=$1 address entry
    for address in '[^ \n]*/debian/?' '[^ \n]+'; do
        entry=$(awk 'FNR == 1 {print ""} !/^#/' "$apt_folder"/sources.list.d/*.sources 2>/dev/null |
            awk -v suite="$suite" -v address="${address//\\/\\\\}" '
            BEGIN {RS = ""}
            $0 ~ "(^|\n)URIs:[^\n]* " address "( |\n|$)" && /(^|\n)Components:([^\n]* )?main( |\n|$)/ &&
            /(^|\n)Types:[^\n]*deb( |\n|$)/ && $0 ~ "(^|\n)Suites:([^\n]* )?" suite "( |\n|$)" && !/(^|\n)Enabled: *no/ {
                sub(/(^|\n)Types:[^\n]*/, "\nTypes: deb")
                sub(/\nSuites:[^\n]*/, "\nSuites: " suite "-backports")
                sub(/\nComponents:[^\n]*/, "\nComponents: main")
                sub(/^\n/, "")
                print
                exit
            }') || true
        if [[ -n $entry ]]; then
            printf 'sources\n%s\n' "$entry"
            return
        fi
        entry=$(cat "$apt_folder"/sources.list "$apt_folder"/sources.list.d/*.list 2>/dev/null | grep -v 'cdrom:' |
            sed -nE "s#^deb[[:space:]]+(\[[^]]*\][[:space:]]+)?(${address//\\n/})[[:space:]]+${suite}[[:space:]]+([^\#]*[[:space:]])?main([[:space:]].*)?\$#deb \1\2 $suite-backports main#p" |
            head -n 1) || true
        if [[ -n $entry ]]; then
            printf 'list\n%s\n' "$entry"
            return
        fi
    done
}

# Run as root, quietly: what it said is shown only when it failed.
as_root()
{
    local log sudo=()
    if [[ $(id -u) != 0 ]]; then
        command -v sudo >/dev/null || stop "needs root to run: $*"
        sudo=(sudo)
    fi
    log=$(mktemp)
    if ! "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive "$@" >"$log" 2>&1 </dev/null; then
        tail -n 20 "$log" >&2
        rm -f "$log"
        stop "failed: $*"
    fi
    rm -f "$log"
}

apt_install()
{
    as_root apt-get -q -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@"
}

update_packages()
{
    as_root apt-get -q -o DPkg::Lock::Timeout=300 update
}

add_backports()
{
    local suite=$1 entry file
    entry=$(backports_entry "$suite")
    [[ -n $entry ]] || stop "no apt entry of suite $suite to take a mirror from; add the suite $suite-backports and start again"
    file=$apt_folder/sources.list.d/restirpg-backports.${entry%%$'\n'*}
    as_root sh -c "printf '%s\n' \"\$1\" > \"\$2\"" sh "${entry#*$'\n'}" "$file"
    (update_packages) || { as_root rm -f "$file"; exit 2; }  # apt would stumble over it from now on
}

install_debian()
{
    local role=$1 suite=$2 missing newer backports=() unknown lacking
    missing=$(package_names "$role" | not_installed)
    if mesa_is_old; then
        missing=$(printf '%s\nmesa-vulkan-drivers\n' "$missing" | sort -u | sed '/^$/d')
    fi
    newer=$(grep -xE "$from_backports" <<<"$missing" || true)
    [[ -z $newer || $suite != bookworm ]] || backports=(-t bookworm-backports)
    [[ -n $missing ]] || return 0
    echo "setup: installing $(tr '\n' ' ' <<<"$missing")" >&2
    if [[ -n ${backports[*]} ]]; then
        add_backports "$suite"
    else
        update_packages
    fi
    # shellcheck disable=SC2086
    unknown=$(comm -13 <({ apt-cache --no-all-versions show $missing 2>/dev/null || true; } | sed -n 's/^Package: //p' | sort -u) <(sort <<<"$missing"))
    lacking=$(grep -xE "$may_lack" <<<"$unknown" || true)
    [[ -z $lacking ]] || echo "setup: this system's package archive lacks ${lacking//$'\n'/ }: tests that need it will skip" >&2
    missing=$(comm -23 <(sort <<<"$missing") <(sort <<<"$lacking"))
    unknown=$(comm -23 <(sort <<<"$unknown") <(sort <<<"$lacking"))
    [[ -z $unknown ]] || stop "this system's package archive lacks: ${unknown//$'\n'/ }"
    [[ -n $missing ]] || return 0
    # shellcheck disable=SC2046
    apt_install $(grep -vxE "$from_backports" <<<"$missing" || true)
    if [[ -n $newer ]]; then
        # shellcheck disable=SC2086
        apt_install "${backports[@]}" $newer
        ! mesa_is_old || stop "mesa-vulkan-drivers $least_mesa or newer is needed, the archive has only an older one"
    fi
}

# On other systems: name what the probes of packages.txt do not find.
probe()
{
    local kind=$1 what=$2 prefix
    case $kind in
        command) command -v "$what" >/dev/null ;;
        module) "$python" -c "import $what" 2>/dev/null ;;
        header) what=include/$what ;&
        file)
            for prefix in /usr /usr/local; do
                compgen -G "$prefix/$what" >/dev/null && return 0
            done
            return 1 ;;
    esac
}

# One of several that the line of packages.txt has.
probe_one_of()
{
    local kind=$1 what
    set -f  # patterns are for the probe
    for what in $2; do
        set +f
        probe "$kind" "$what" && return 0
    done
    set +f
    return 1
}

check_elsewhere()
{
    local names name kind what missing=() lacking=()
    names=" $(package_names "$1" | tr '\n' ' ')"
    while read -r name kind what; do
        if [[ $names != *" $name "* ]] || probe_one_of "$kind" "$what"; then
            continue
        elif [[ $name =~ ^($may_lack)$ ]]; then
            lacking+=("$name")
        else
            missing+=("$name")
        fi
    done < <(grep -v '^#' "$root/scripts/packages.txt")
    [[ ${#lacking[@]} == 0 ]] || echo "setup: this system lacks ${lacking[*]}: tests that need it will skip" >&2
    [[ ${#missing[@]} == 0 ]] ||
        stop "not Debian or Ubuntu: install what these Debian packages hold, then start again: ${missing[*]}"
}

install_packages()
{
    [[ ${RESTIRPG_SKIP_SETUP:-0} == 0 ]] || return 0
    local system
    system=$(. /etc/os-release 2>/dev/null && echo "${ID:-} ${ID_LIKE:-} ${VERSION_CODENAME:-}") || true
    if [[ " $system " == *" debian "* ]] && command -v apt-get >/dev/null; then
        install_debian "$1" "${system##* }"
    else
        check_elsewhere "$1"
    fi
}

# For this source and this folder: a clone that was copied or moved with its build would build the other one.
is_configured()
{
    local source folder
    source=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build_folder/CMakeCache.txt" 2>/dev/null) || return 1
    folder=$(sed -n 's/^CMAKE_CACHEFILE_DIR:INTERNAL=//p' "$build_folder/CMakeCache.txt")
    [[ -f $build_folder/build.ninja && $source -ef $root && $folder -ef $build_folder ]]
}

# What is timed must be the build that users have.
check_build_type()
{
    local type
    type=$(sed -n 's/^CMAKE_BUILD_TYPE:[A-Z]*=//p' "$build_folder/CMakeCache.txt")
    [[ $type == Release ]] ||
        stop "$build_folder: its build type is '$type', not Release; remove the folder, or name another one in RESTIRPG_BUILD"
}

build()
{
    mkdir -p "$MESA_SHADER_CACHE_DIR"
    is_configured ||
        cmake --fresh -S "$root" -B "$build_folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DPython3_EXECUTABLE="$python" >&2 ||
        stop "cmake could not configure $build_folder; its message is above"
    check_build_type
    ninja -C "$build_folder" "$@" >&2 || stop "the build failed; its message is above"
}

# lavapipe compiles a kernel for a second at its first dispatch: keep what it compiled with the build.
export MESA_SHADER_CACHE_DIR=${MESA_SHADER_CACHE_DIR:-$build_folder/cache/mesa}
export PYTHONPATH=$build_folder/python${PYTHONPATH:+:$PYTHONPATH}
