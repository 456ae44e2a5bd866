#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# test_packages.sh FOLDER: installs the packages in FOLDER into a minimal Debian 12 of their own, as root, tries them there, and
# prints what they take. The root is made by debootstrap from the mirror of this machine, and removed again.
set -euo pipefail
folder=$(readlink -f -- "$1")
if ((EUID != 0)); then
  echo "test_packages.sh: error: making a root of its own needs the rights of root; expected: run as root" >&2
  exit 2
fi
mirror=$(apt-cache policy | sed -n 's/^ *[0-9]* \(https\?:[^ ]*\) bookworm\/main .*/\1/p' | head -n 1)
root=$folder/root
trap 'rm -rf --one-file-system -- "$root"' EXIT
rm -rf -- "$root"
debootstrap --variant=minbase bookworm "$root" "$mirror" >"$folder/debootstrap.log"
cp /etc/apt/apt.conf.d/*proxy* "$root/etc/apt/apt.conf.d/" 2>/dev/null || true
cp "$folder"/*.deb "$root/root/"

within() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
megabytes() { du -sm --exclude="$root/root" --exclude="$root/proc" "$root" | cut -f 1; }
# install NAME...: these packages with what they depend on, nothing that they only recommend
install() { within apt-get -qq -y --no-install-recommends install "${@/#//root/}" >>"$folder/apt.log"; within apt-get clean; }

within apt-get clean
bare=$(megabytes)
install "$(cd "$folder" && echo alidade_*.deb)"
echo "alidade takes $(($(megabytes) - bare)) MB beyond a minimal Debian"
within sh -euc 'cd /root
  alidade generate courtyard --points 2e4 -o yard.las -q
  alidade info yard.las --stats >/dev/null
  alidade convert yard.las -o yard.laz -q
  alidade index yard.laz -o yard.alidade -q
  alidade query yard.alidade --ray 690000,5325000,640,0,0,-1 --radius 0.5 >/dev/null
  alidade sql load yard.laz yard.db -q
  alidade sql yard.db "SELECT count(*) FROM points" >/dev/null
  alidade visibility summary yard.alidade --observer 690000,5325000,602 -o seen.csv -q'
if within sh -c 'cd /root && alidade render yard.las -o yard.png -q' 2>"$folder/render.log"; then
  echo "test_packages.sh: error: a picture was written without what the package only recommends" >&2
  exit 1
fi
grep -q 'image files and legends require OpenImageIO' "$folder/render.log"

install "$(cd "$folder" && echo python3-alidade_*.deb)" "$(cd "$folder" && echo alidade-sqlite_*.deb)"
echo "with the modules for Python and SQLite $(($(megabytes) - bare)) MB"
within python3 -c 'import alidade
index = alidade.open("/root/yard.laz").index()
assert len(index) == 20000 and index.nearest_points(index.xyz[:5]).index[:, 0].tolist() == [0, 1, 2, 3, 4]
assert alidade.render(index, size=(30, 20), samples=1)["image"].shape == (20, 30, 3)'
within python3 -c 'import sqlite3
database = sqlite3.connect("/root/yard.db")
database.enable_load_extension(True)
database.load_extension("/usr/lib/'"$(dpkg-architecture -qDEB_HOST_MULTIARCH)"'/alidade/libalidade_sqlite")
assert database.execute("SELECT count(*) FROM points").fetchone() == (20000,)'

# What the package recommends, as apt would install by itself.
mapfile -t recommended < <(dpkg-deb --field "$folder"/alidade_*.deb Recommends | sed 's/([^)]*)//g; s/|[^,]*//g' | tr ',' '\n' | sed 's/ //g; /^$/d')
within apt-get -qq -y --no-install-recommends install "${recommended[@]}" >>"$folder/apt.log"
within sh -euc 'cd /root && alidade render yard.las -o yard.png --size 60x40 --samples 1 -q && test -s yard.png
  alidade visibility viewshed yard.alidade --observer 690000,5325000 --resolution 1 -o seen.tif -q && test -s seen.tif'
within apt-get clean
echo "with what pictures and maps need $(($(megabytes) - bare)) MB"

install "$(cd "$folder" && echo libalidade-dev_*.deb)" "$(cd "$folder" && echo postgresql-15-alidade_*.deb)"
within sh -euc 'test -s /usr/share/postgresql/15/extension/alidade_pg.control && test -s /usr/lib/postgresql/15/lib/alidade_pg.so'
echo "alidade, python3-alidade and alidade-sqlite were tried; libalidade-dev and postgresql-15-alidade were installed"
