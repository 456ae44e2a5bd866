# SPDX-License-Identifier: MIT
# What ./dev needs from Debian 12, and how it gets it. Sourced by ./dev, which sets `install` to yes or no.

build_packages=(
  cmake ninja-build g++                            # compiling
  libglm-dev libtbb-dev libfmt-dev libhwy-dev libxxhash-dev libpugixml-dev  # octree
  libopenimageio-dev openimageio-tools libopenexr-dev libgdal-dev libnova-dev  # pictures
  libfreetype-dev fonts-dejavu-core                # legends
  nlohmann-json3-dev libcli11-dev libedit2         # the program
  libsqlite3-dev libpq-dev libzstd-dev             # databases
  pybind11-dev python3-dev python3-numpy           # the module for Python
  libgtest-dev                                     # tests
)
# libembree-dev: the test that compares hits with Embree's spheres. gdal-bin: gdalinfo, which is asked where orthophotos lie. clang: libFuzzer. chromium: opens reports. doxygen: the API pages.
# ccache: several builds compile the same. postgresql: the extension alidade_pg, left out of a build without them.
# From pytest on: the module for Python, and the libraries it works with.
test_packages=(ccache libembree-dev clang libclang-rt-14-dev clang-format gdal-bin chromium doxygen
               postgresql-15 postgresql-server-dev-15 python3-pytest python3-hypothesis python3-scipy python3-matplotlib
               python3-pandas python3-rasterio python3-geopandas python3-xarray python3-open3d mypy)
# Beside libbenchmark-dev: what the benchmarks compare with, and their plots.
bench_packages=(libbenchmark-dev libembree-dev libnanoflann-dev libboost-dev libpcl-dev python3-matplotlib)
package_packages=(debhelper dh-python dpkg-dev fakeroot lintian debootstrap postgresql-server-dev-15 patchelf python3-venv)
lint_packages=(libembree-dev clang-tidy)

# need PACKAGE...: installs those that are missing, or explains why it cannot.
need() {
  local missing=() package
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "dev: this is not a Debian system; what follows may fail unless the equivalents of these packages are here:" >&2
    echo "  $*" >&2
    return 0
  fi
  for package in "$@"; do
    if [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then missing+=("$package"); fi
  done
  if ((${#missing[@]} == 0)); then return 0; fi

  echo "dev: these Debian packages are needed to build and test Alidade and are not installed:"
  echo "  ${missing[*]}"
  local as_root=()
  if ((EUID != 0)); then as_root=(sudo); fi
  if [[ $install == no ]] || { ((EUID != 0)) && ! command -v sudo >/dev/null; }; then
    echo "dev: error: install them as root: apt-get install ${missing[*]}" >&2
    return 2
  fi
  echo "dev: installing them with ${as_root[*]:+sudo }apt-get (./dev --no-install rejects this)"
  as_root+=(env DEBIAN_FRONTEND=noninteractive)
  local get=("${as_root[@]}" apt-get -y --no-install-recommends install "${missing[@]}")
  # The lists of packages are fetched only if they are absent or too old for what they name to be there still.
  if ! "${get[@]}" </dev/null; then
    "${as_root[@]}" apt-get update </dev/null
    "${get[@]}" </dev/null
  fi
}
