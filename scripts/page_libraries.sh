#!/usr/bin/env bash
# Fetches the two libraries of the operator's page into src/forest_station/forest_station/web/vendor (needs npm).
# They lie in the repository, so that running the station needs neither npm nor a network.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
vendor=$PWD/src/forest_station/forest_station/web/vendor
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT

fetch() { # fetch NAME VERSION SHA512
    local file
    file=$(cd "$work" && npm pack --silent "$1@$2")
    [[ $(openssl dgst -sha512 -binary "$work/$file" | base64 --wrap=0) == "$3" ]] || {
        echo "page_libraries: error: $1 $2 is not the package whose SHA-512 stands here." >&2
        exit 1
    }
    mkdir "$work/$1"
    tar -xzf "$work/$file" -C "$work/$1" --strip-components=1
    cp "$work/$1/LICENSE" "$vendor/$1.LICENSE"
}

fetch three 0.187.0 "Qiu7R+Cmh8CstZsY1uJOSWnVlfo7ZtNLV7mF8Jltk3LB3AtDu9cRZlcnRKkAk8Y4z6KKw35z7Y7Urd7jWY8etA=="
# One file, without bare module names: a page without inline scripts has no import map.
cat >"$work/page.js" <<'PAGE'
export * from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { CSS2DObject, CSS2DRenderer } from "three/addons/renderers/CSS2DRenderer.js";
export { Line2 } from "three/addons/lines/Line2.js";
export { LineGeometry } from "three/addons/lines/LineGeometry.js";
export { LineMaterial } from "three/addons/lines/LineMaterial.js";
PAGE
mkdir "$work/node_modules"
mv "$work/three" "$work/node_modules"
(cd "$work" && npm exec --yes --silent -- esbuild@0.28.2 page.js --bundle --minify --format=esm \
    --log-level=warning --outfile="$vendor/three.js")

fetch uplot 1.6.32 "KIMVnG68zvu5XXUbC4LQEPnhwOxBuLyW1AHtpm6IKTXImkbLgkMy+jabjLgSLMasNuGGzQm/ep3tOkyTxpiQIw=="
# On a graphics process the page's thread would wait for the pictures of the scene: for up to a second where the processor
# draws them. A canvas that is read often is drawn by the page's own process.
sed 's/can\.getContext("2d")/can.getContext("2d", { willReadFrequently: true })/' "$work/uplot/dist/uPlot.esm.js" >"$vendor/uplot.js"
grep -q willReadFrequently "$vendor/uplot.js"
cp "$work/uplot/dist/uPlot.min.css" "$vendor/uplot.css"
