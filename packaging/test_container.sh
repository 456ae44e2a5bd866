#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# test_container.sh FOLDER: builds packaging/Containerfile from the packages in FOLDER with buildah, as root, and tries the image. No
# registry is asked: its base is made by debootstrap from the mirror of this machine. All of it is removed again.
set -euo pipefail
folder=$(readlink -f -- "$1")
file=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/Containerfile
if ((EUID != 0)); then
  echo "test_container.sh: error: debootstrap needs the rights of root; expected: run as root" >&2
  exit 2
fi
scratch=$(mktemp -d)
trap 'rm -rf --one-file-system -- "$scratch"' EXIT
# Neither a runtime of containers nor a file system of layers is needed.
export BUILDAH_ISOLATION=chroot
images() { buildah --root "$scratch/images" --runroot "$scratch/run" --storage-driver vfs "$@"; }

mirror=$(apt-cache policy | sed -n 's/^ *[0-9]* \(https\?:[^ ]*\) bookworm\/main .*/\1/p' | head -n 1)
debootstrap --variant=minbase bookworm "$scratch/root" "$mirror" >"$folder/debootstrap.log"
cp /etc/apt/apt.conf.d/*proxy* "$scratch/root/etc/apt/apt.conf.d/" 2>/dev/null || true
base=$(images from scratch)
images copy --quiet "$base" "$scratch/root" / >/dev/null
images commit --quiet --rm "$base" localhost/debian:12 >/dev/null
rm -rf --one-file-system -- "$scratch/root"

images build --pull=never --build-arg BASE=localhost/debian:12 --file "$file" --tag alidade "$folder" >"$folder/container.log" 2>&1 ||
  { tail -n 30 "$folder/container.log" >&2 && exit 1; }
container=$(images from --pull=never localhost/alidade)
within() { images run "$container" -- "$@"; }
within alidade --version
within alidade generate courtyard --points 2e4 -o yard.laz -q
within alidade info yard.laz --json | grep '"points": *20000' >/dev/null
within alidade render yard.laz -o yard.png --size 120x80 --samples 2 -q
within alidade visibility viewshed yard.laz --observer 690000,5325000 --resolution 1 -o seen.tif -q
within python3 -c 'import alidade; assert len(alidade.open("yard.laz").index()) == 20000'
mounted=$(images mount "$container")
cp "$mounted/data/yard.png" "$folder/container.png"
echo "the container works: $(du -sm "$mounted" | cut -f 1) MB; its picture is $folder/container.png"
