# For scripts that work in a Debian of their own: sourced, not run. They call `read_arguments` and
# `own_mounts "$@"` before anything else. Everything runs as root on any Debian.

name=$(basename "$0")

fail() {
  echo "$name: $1" >&2
  exit 1
}

# 77: that Debian cannot be had here.
cannot_run() {
  trap - EXIT
  echo "$name: $1" >&2
  exit 77
}

# Says what comes next; should that fail, it is what the last line of the output names.
current=''
step() {
  current=$1
  echo "=== Debian $release: $current"
}
say_what_failed() {
  if [ $? -ne 0 ] && [ -n "$current" ]; then
    echo "$name: Debian $release: failed at: $current${root:+ (its system is in $root)}" >&2
  fi
}

# read_arguments OPTION "$@": sets `release`, 12 or 13, `root`, and `given` to the value of --OPTION.
read_arguments() {
  local option=--$1
  shift
  release='' root='' given=''
  while [ $# -gt 0 ]; do
    case "$1" in
      -h | --help) sed -n '2,/^set /{/^# /s/^# //p}' "$0"; exit 0 ;;
      12 | 13) release=$1; shift ;;
      --root) root=${2:-}; [ -n "$root" ] || fail "--root takes a directory"; shift 2 ;;
      "$option") given=${2:-}; [ -n "$given" ] || fail "$option takes a value; see --help"; shift 2 ;;
      *) fail "unknown argument '$1'; see --help" ;;
    esac
  done
  [ -n "$release" ] || fail "say which Debian, 12 or 13"
}

# In a mount namespace of its own nothing that is mounted here outlives the run, however it ends. Goes to
# the sources, and makes `root` absolute, by default in build.
own_mounts() {
  [ "$(id -u)" -eq 0 ] || cannot_run "run as root: a system of its own needs chroot and mounts"
  unshare --mount --propagation private true || cannot_run "mounts of its own are not permitted here"
  if [ -z "${RAYWALK_OWN_MOUNTS:-}" ]; then
    RAYWALK_OWN_MOUNTS=1 exec unshare --mount --propagation private "$0" "$@"
  fi
  # What apt-get goes through on this machine.
  local proxy_of_apt=''
  eval "$(apt-config shell proxy_of_apt Acquire::http::Proxy)"
  proxy=${http_proxy:-$proxy_of_apt}
  mirror=$(grep -rhoE 'https?://[^] ]+/debian/?( |$)' /etc/apt/sources.list \
    /etc/apt/sources.list.d 2>/dev/null | head -n 1 | tr -d ' ' || true)  # none: debootstrap's own
  if [ -n "${CCACHE_DIR:-}" ]; then
    CCACHE_DIR=$(realpath "$CCACHE_DIR")
    [ -d "$CCACHE_DIR" ] || fail "CCACHE_DIR is $CCACHE_DIR, which is no directory"
  fi
  root=$(realpath -m "${root:-$(dirname "$0")/../build/debian-$release}")
  cd "$(dirname "$0")/.."
  trap say_what_failed EXIT
}

# make_system ROOT: a minimal system.
make_system() {
  local root=$1 codename
  codename=$([ "$release" = 12 ] && echo bookworm || echo trixie)
  if ! command -v debootstrap >/dev/null; then
    apt-get update -qq && apt-get install -y -qq debootstrap >/dev/null ||
      cannot_run "debootstrap cannot be installed"
  fi
  rm -rf "$root.part"
  mkdir -p "$root.part"
  if ! http_proxy=$proxy debootstrap --variant=minbase "$codename" "$root.part" ${mirror:+"$mirror"} \
    >"$root.log" 2>&1; then
    tail -n 20 "$root.log" >&2
    cannot_run "debootstrap could not make Debian $release (its output is above)"
  fi
  rm "$root.log"
  mv "$root.part" "$root"
}

# kept_system ROOT: the one that an earlier run made, or a new one.
kept_system() {
  if [ -e "$1" ]; then
    grep -qs "^VERSION_ID=\"$release\"" "$1/etc/os-release" ||
      fail "$1 is there, but holds no Debian $release; name another directory by --root"
    return
  fi
  step "a clean system in $1"
  make_system "$1"
}

# mount_all ROOT
mount_all() {
  local root=$1
  mkdir -p "$root/ccache"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount --rbind /sys "$root/sys"
  if [ -n "${CCACHE_DIR:-}" ]; then mount --bind "$CCACHE_DIR" "$root/ccache"; fi
  # Whom npm trusts beyond its own list, as behind a proxy that reads along.
  if [ -n "${NODE_EXTRA_CA_CERTS:-}" ]; then cp "$NODE_EXTRA_CA_CERTS" "$root/certificates.pem"; fi
}

# copy_sources ROOT: those of the last commit.
copy_sources() {
  step "sources of $(git -c safe.directory='*' rev-parse --short HEAD)"
  rm -rf "$1/raywalk"
  mkdir "$1/raywalk"
  git -c safe.directory='*' archive HEAD | tar -x -C "$1/raywalk"
}

# inside ROOT COMMAND...: in the directory of the sources on that Debian.
inside() {
  local root=$1
  shift
  local variables=(HOME=/root LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
  if [ -n "$proxy" ]; then variables+=("http_proxy=$proxy"); fi
  if [ -n "${NODE_EXTRA_CA_CERTS:-}" ]; then
    variables+=(NODE_EXTRA_CA_CERTS=/certificates.pem)
  fi
  if [ -n "${SOURCE_DATE_EPOCH:-}" ]; then variables+=("SOURCE_DATE_EPOCH=$SOURCE_DATE_EPOCH"); fi
  if [ -n "${CCACHE_DIR:-}" ]; then
    variables+=(CCACHE_DIR=/ccache CCACHE_BASEDIR=/raywalk CCACHE_NOHASHDIR=true
      CCACHE_SLOPPINESS=pch_defines,time_macros
      CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi
  # shellcheck disable=SC2016
  chroot "$root" /usr/bin/env -i "${variables[@]}" \
    bash -c 'cd /raywalk && exec "$@"' inside "$@"
}
