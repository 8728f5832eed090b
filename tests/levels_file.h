/* SPDX-License-Identifier: MIT */
/** For tests: a file with levels of detail. */
#ifndef FNL_TESTS_LEVELS_FILE_H
#define FNL_TESTS_LEVELS_FILE_H

#include "tests/gltf_test_file.h"

/** A square of 2 by 2 metres that faces +Z; its sphere has the radius sqrt(2). */
static const float levels_square[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};

/* Materials 0 to 4 are red, green, blue, white and black, unlit, and so are meshes. */
#define LEVELS_COLOR(r, g, b, more)                                                                                                   \
    "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[" #r "," #g "," #b ",1]},\"doubleSided\":true" more "\"extensions\":{"
#define LEVELS_UNLIT "\"KHR_materials_unlit\":{}"
#define LEVELS_MESH(material) "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":" #material "}]}"
/** `white`: what stands in material 3 besides, `white_extension` in its extensions. */
#define LEVELS_FILE(white, white_extension, nodes)                                                                                    \
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"MSFT_lod\",\"KHR_materials_unlit\"],\"buffers\":[{\"byteLength\":72}],"    \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":72}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\","    \
    "\"count\":6,\"min\":[-1,-1,0],\"max\":[1,1,0]}],\"materials\":[" LEVELS_COLOR(1, 0, 0, ",") LEVELS_UNLIT "}},"                    \
    LEVELS_COLOR(0, 1, 0, ",") LEVELS_UNLIT "}}," LEVELS_COLOR(0, 0, 1, ",") LEVELS_UNLIT "}}," LEVELS_COLOR(1, 1, 1, "," white)      \
    white_extension LEVELS_UNLIT "}}," LEVELS_COLOR(0, 0, 0, ",") LEVELS_UNLIT "}}],\"meshes\":[" LEVELS_MESH(0) "," LEVELS_MESH(1) "," \
    LEVELS_MESH(2) "," LEVELS_MESH(3) "," LEVELS_MESH(4) "],\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" nodes "]}"
#define LEVELS_IDS(ids) "\"extensions\":{\"MSFT_lod\":{\"ids\":[" ids "]}}"
#define LEVELS_COVERAGE(values) "\"extras\":{\"MSFT_screencoverage\":[" values "]}"

/** From so far in front of the square, 90 degrees high: its sphere takes sqrt(2 / (d^2 - 2)) of the height. */
static inline fnl_camera levels_camera(float distance) {
    fnl_camera camera = fnl_camera_default();
    camera.position = (fnl_vec3){0, 0, distance};
    camera.target = (fnl_vec3){0, 0, 0};
    camera.vertical_fov = PI / 2;
    return camera;
}

#endif
