#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# docs/gallery.md and its pictures: gallery.sh FANAL SAMPLES. SAMPLES is a folder with the files of Khronos' glTF-Sample-Assets that the page names, at any depth, and with .hdr panoramas.
set -euo pipefail
fanal=$(realpath "$1") samples=$(realpath "$2")
cd "$(dirname "$0")/.."
page=docs/gallery.md

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

put() { printf '%s\n' "$@" >>"$page"; }

# NAME, WHAT IT SHOWS, SCENE, OPTIONS…: a picture, and the command that makes it.
show() {
    local name=$1 text=$2 scene=$3 file option options=()
    shift 3
    file=$scene
    case $scene in builtin:*) ;; *) file=$(find -L "$samples" -name "$scene" | head -n 1) ;; esac
    for option in "$@"; do
        case $option in *.hdr) option=$(find -L "$samples" -name "$option" | head -n 1) ;; esac
        options+=("$option")
    done
    [ -n "$file" ] || { echo "gallery: no $scene in $samples" >&2; exit 1; }
    echo "gallery: $name"
    "$fanal" render "$file" "${options[@]}" --size 400x225 -q -o "$work/$name.png"
    pngquant --force --output "docs/images/gallery-$name.png" 224 "$work/$name.png"
    case $scene in *[\&?]*) scene="\"$scene\"" ;; esac
    put "### $name" '' "$text" '' "![$name](images/gallery-$name.png)" '' "    fanal render $scene${*:+ $*} -o $name.png" ''
}

: >"$page"
put '<!-- SPDX-License-Identifier: MIT -->' '# Gallery' '' \
    'Every built-in scene, and sample models of the extensions that Fanal reads, each with the command that made the picture (400x225 here; written by `tools/gallery.sh`).' \
    'Models are of [Khronos'"'"' glTF-Sample-Assets](https://github.com/KhronosGroup/glTF-Sample-Assets).' '' '## Built-in scenes' ''
show city 'Night streets: lamps, cars, signals, shops, lanterns, windows.' builtin:city
show city-by-day 'The same by a sun, in an analytic sky.' 'builtin:city?lights=0&blocks=2&sun=60000' --camera above
show hall 'A colonnade with curtains, plants, candles and 512 lights.' 'builtin:hall?lights=512'
show interior 'Few, large, overlapping lights of all five shapes.' builtin:interior
show wall 'Lights behind a wall, which tiles with depth alone keep.' 'builtin:wall?test=2'
show room 'A sun and lamps shine into a room through coloured glass.' 'builtin:room?sun=40000' --shadows cubemap
show spheres 'Roughness to the right, metalness upwards.' builtin:spheres
show pole 'A thin pole before a far background: a jump in depth in every tile.' builtin:pole
show lamps 'A row of lamps straight along the view axis.' builtin:lamps
show grass 'Alpha-masked tufts: jumps in depth everywhere.' builtin:grass
show onetile 'All lights in a single tile.' builtin:onetile
show nearplane 'Lights on and behind the near plane and around the eye.' builtin:nearplane
show sky 'Most pixels and most lights have nothing to light.' builtin:sky
show glass 'Panes that cross and balls that reach into one another, blended exactly.' 'builtin:glass?crossing=1' --transparency linked
put '## Sample models' ''
show FlightHelmet 'Core materials, on [the stage](techniques/stage.md).' FlightHelmet.gltf
show ClearCoatCarPaint '`KHR_materials_clearcoat`.' ClearCoatCarPaint.glb --environment spiaggia_di_mondello_1k.hdr --environment-hidden
show SheenChair '`KHR_materials_sheen`, `_variants`.' SheenChair.gltf --variant 1
show IridescenceSuzanne '`KHR_materials_iridescence`: on plastic, on metal, on glass.' IridescenceSuzanne.glb
show AnisotropyStrengthTest '`KHR_materials_anisotropy`.' AnisotropyStrengthTest.glb
show SpecularTest '`KHR_materials_specular`.' SpecularTest.glb
show TransmissionTest '`KHR_materials_transmission`: [smooth, rough, metallic](techniques/transmission.md).' TransmissionTest.glb
show TransmissionRoughnessTest 'Roughness to the right, five indices of refraction.' TransmissionRoughnessTest.glb
show AttenuationTest '`KHR_materials_volume`: thickness and attenuation.' AttenuationTest.glb
show AlphaBlendModeTest 'Opaque, cut out, blended.' AlphaBlendModeTest.glb
show CesiumMan 'A skin, in motion.' CesiumMan.glb --time 0.6
