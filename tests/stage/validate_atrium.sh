#!/bin/sh
# validate_atrium.sh FILE.glb BUILD_FOLDER: the Khronos validator finds no error in the file. Exit 77 is a skip.
file=$1
folder=$2/gltf-validator
version=2.0.0-dev.3.10
for program in node npm; do
  command -v $program >/dev/null || { echo "skipped: no $program here"; exit 77; }
done
if [ ! -f "$folder/node_modules/gltf-validator/package.json" ]; then
  mkdir -p "$folder" && echo '{"private": true}' >"$folder/package.json"
  if ! (cd "$folder" && timeout 120 npm install --silent --no-audit --no-fund --ignore-scripts --fetch-retries=0 \
        gltf-validator@$version >install.log 2>&1); then
    rm -rf "$folder/node_modules"
    echo "skipped: npm cannot install gltf-validator@$version, see $folder/install.log"
    exit 77
  fi
fi
NODE_PATH=$folder/node_modules exec node "$(dirname "$0")/validate.js" "$file"
