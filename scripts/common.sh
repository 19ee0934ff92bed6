# Shared by scripts/demo, scripts/test and scripts/run: installs what is missing, builds, enters the workspace.
# Sourced, not run. Works on Debian 12 (ROS from Debian itself) and on Ubuntu 20.04 (ROS Noetic).

set -euo pipefail

source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
# One workspace for each checkout, outside of the source tree.
workspace=${FRUGAL_NAV_WORKSPACE:-${XDG_CACHE_HOME:-$HOME/.cache}/frugal_nav/ws-$(printf '%s' "$source_dir" | cksum | cut -d' ' -f1)}

# ROS's CMake files run "python3": it must be the system's, not one of a version manager.
export PATH=/usr/bin:$PATH

say() { printf '\n==> %s\n' "$*" >&2; }
die() { printf 'error: %s\n' "$*" >&2; exit 1; }

debian_packages="
  build-essential ccache cmake pkg-config
  catkin rosbash ros-core ros-robot-state-publisher
  ros-actionlib-msgs ros-diagnostic-msgs ros-geometry-msgs ros-nav-msgs ros-rosgraph-msgs ros-sensor-msgs
  ros-std-msgs ros-visualization-msgs
  libactionlib-dev libcv-bridge-dev libdiagnostic-updater-dev libdynamic-reconfigure-config-init-mutex-dev
  libimage-transport-dev libmove-base-msgs-dev libnav-msgs-dev libnodelet-dev libnodeletlib-dev libnodeletlib-tools
  librosbag-dev libroscpp-dev libros-rosgraph-msgs-dev librostest-dev libstd-srvs-dev libtf2-geometry-msgs-dev
  libtf2-ros-dev libtopic-tools-dev libvisualization-msgs-dev pluginlib-dev
  python3-dynamic-reconfigure python3-matplotlib python3-rosbag python3-roslaunch python3-rosnode python3-rosservice python3-rostest
  python3-rostopic
  libassimp-dev libbenchmark-dev libbullet-dev libceres-dev libeigen3-dev libembree-dev libgmock-dev libgtest-dev
  libopencv-dev libpcl-dev opencv-data libsdformat-dev libtinyxml2-dev liburdfdom-dev libyaml-cpp-dev nlohmann-json3-dev"
debian_display_packages="rviz"
debian_test_packages="catkin-lint clang-format python3-numpy"

ubuntu_packages="
  build-essential ccache cmake pkg-config python3-catkin-pkg python3-matplotlib
  ros-noetic-ros-base ros-noetic-cv-bridge ros-noetic-diagnostic-updater ros-noetic-dynamic-reconfigure
  ros-noetic-image-transport ros-noetic-move-base-msgs ros-noetic-nodelet ros-noetic-robot-state-publisher
  ros-noetic-rostest ros-noetic-tf2-geometry-msgs ros-noetic-tf2-ros ros-noetic-topic-tools
  ros-noetic-visualization-msgs
  libassimp-dev libbenchmark-dev libbullet-dev libceres-dev libeigen3-dev libembree-dev libgmock-dev libgtest-dev
  libopencv-dev libpcl-dev opencv-data libsdformat9-dev libtinyxml2-dev liburdfdom-dev libyaml-cpp-dev nlohmann-json3-dev"
ubuntu_display_packages="ros-noetic-rviz"
ubuntu_test_packages="catkin-lint clang-format python3-numpy"

# Sets `distribution` and the package lists in use; refuses systems it knows nothing of.
choose_distribution() {
  # shellcheck disable=SC1091
  . /etc/os-release
  case "${ID:-}:${VERSION_ID:-}" in
    debian:12) distribution=debian ;;
    ubuntu:20.04) distribution=ubuntu ;;
    *) die "this is ${PRETTY_NAME:-an unknown system}; the scripts know Debian 12 and Ubuntu 20.04 with ROS Noetic's
       apt source. Elsewhere install the dependencies of package.xml and build with catkin_make." ;;
  esac
}

# as_root CMD ARGS...: runs a command as root, with sudo where that is needed.
as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; return; fi
  command -v sudo >/dev/null || die "this needs root, and there is no sudo: $*"
  sudo "$@"
}

# install_missing PACKAGE...: installs with apt what is not there yet; nothing is asked.
install_missing() {
  local missing
  missing=$(comm -23 <(printf '%s\n' "$@" | sort -u) \
    <(dpkg-query -W -f='${db:Status-Status} ${Package}\n' 2>/dev/null | sed -n 's/^installed //p' | sort -u))
  [ -n "$missing" ] || return 0
  say "installing $(wc -w <<<"$missing") missing packages"
  as_root apt-get update -qq
  # shellcheck disable=SC2086
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >&2
}

# install_for build|display|test: the packages of that use.
install_for() {
  choose_distribution
  local list="${distribution}_packages" extra="${distribution}_$1_packages"
  # shellcheck disable=SC2086
  install_missing ${!list} ${!extra:-}
  # A bare root file system has no /etc/hosts, and ROS asks for the address of localhost.
  getent hosts localhost >/dev/null || echo "127.0.0.1 localhost" | as_root tee -a /etc/hosts >/dev/null
}

# stay_local: ROS on this machine alone, also where its own host name has no address.
stay_local() {
  export ROS_IP=127.0.0.1
  unset ROS_HOSTNAME
}

# Settings that the build and every command of the workspace need.
ros_environment() {
  # setup scripts read unset variables
  set +u
  # shellcheck disable=SC1091
  if [ -f /opt/ros/noetic/setup.bash ]; then . /opt/ros/noetic/setup.bash; fi
  # shellcheck disable=SC1091
  if [ -f "$workspace/devel/setup.bash" ]; then . "$workspace/devel/setup.bash"; fi
  set -u
}

# build [TARGET...]: configures when needed and builds, Release, with ccache. Quiet when all goes well.
build() {
  mkdir -p "$workspace/src"
  ln -sfn "$source_dir" "$workspace/src/frugal_nav"
  ros_environment
  # Paths relative to the workspace: another checkout of the same sources finds what this one compiled.
  export CCACHE_BASEDIR=$workspace CCACHE_NOHASHDIR=1
  say "building in $workspace"
  local log=$workspace/build.log
  if ! catkin_make -C "$workspace" -j"$(nproc)" --cmake-args -DCMAKE_BUILD_TYPE=Release \
      -DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCATKIN_ENABLE_TESTING=ON --make-args "$@" >"$log" 2>&1; then
    tail -n 60 "$log" >&2
    die "the build failed; all of its output is in $log"
  fi
  ros_environment
}
