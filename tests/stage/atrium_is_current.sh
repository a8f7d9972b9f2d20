#!/bin/sh
# atrium_is_current.sh ASSETS BUILD_FOLDER: the script gives the committed file, byte by byte. Exit 77 is a skip.
command -v python3 >/dev/null || { echo "skipped: no python3 here"; exit 77; }
fresh=$2/atrium_fresh.glb
python3 -B "$1/make_atrium.py" "$fresh" || exit 1
cmp "$1/atrium.glb" "$fresh" || { echo "assets/atrium.glb is not what assets/make_atrium.py writes: run it"; exit 1; }
