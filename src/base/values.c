/* SPDX-License-Identifier: MIT */
/* The names of the values of all public enums. */
#include "base/values.h"

#include "base/check.h"
#include "fanal/fanal.h"

struct names {
    const char *type; /* in C */
    uint32_t count;
    const char *const *names;
    const char *const *helps; /* a line about each; NULL: none */
};
/* `number`, which must be that of the strings. */
#define AS_MANY_AS(number, ...)                                                                                                  \
    ((number) + 0 * sizeof(struct {                                                                                              \
         _Static_assert(COUNT_OF(((const char *const[]){__VA_ARGS__})) == (number), "each value has its name");                  \
         int unused;                                                                                                             \
     }))
#define NAMES(type, number, ...) {#type, AS_MANY_AS(number, __VA_ARGS__), (const char *const[number]){__VA_ARGS__}, NULL}

#define NAME_OF(name, help) name,
#define HELP_OF(name, help) help,

/* A row for each debug view: its name, and what it shows. */
#define DEBUG_VIEWS(ROW)                                                                                                        \
    ROW("none", "the picture itself")                                                                                           \
    ROW("albedo", "base colour")                                                                                                \
    ROW("normal", "world-space normal, 0 to 1 for -1 to 1")                                                                     \
    ROW("depth", "view depth z as 1 / (1 + 0.05 z): nearer is brighter")                                                        \
    ROW("roughness", "perceptual roughness")                                                                                    \
    ROW("lights", "heat map of the lights that each pixel visits, without directional ones, with a legend")                     \
    ROW("cells", "the tiles of the light list, or its depth slices in colours")                                                 \
    ROW("overdraw", "opaque fragments per pixel, occluded ones too, with a legend")                                             \
    ROW("tile-normals", "backface lists: the mean normal of each tile")                                                         \
    ROW("backfaces", "backface lists: heat map of the lights that each tile drops, with a legend")                              \
    ROW("overshading", "fragment shader invocations per pixel of visible surfaces, helper lanes too, with a legend")            \
    ROW("layers", "heat map of the blended surfaces in each pixel, with a legend")                                              \
    ROW("decals", "heat map of the box and volume decals that contain the surface, with a legend")                              \
    ROW("gbuffer-0", "the fields of the first render target of the G-buffer, a quarter of the picture each")                    \
    ROW("gbuffer-1", "those of the second render target")                                                                       \
    ROW("gbuffer-2", "those of the third")                                                                                      \
    ROW("gbuffer-3", "those of the fourth")                                                                                     \
    ROW("gbuffer-4", "those of the fifth")                                                                                      \
    ROW("material-id", "a colour for each material id in the G-buffer, with layouts that have them")                            \
    ROW("lit-forward", "white where the layout cannot hold the material, which is therefore shaded forward")                    \
    ROW("edges", "MSAA: pixels that show several things: blue one surface and sky, green 2 surfaces, yellow 3, red more")       \
    ROW("motion", "motion vectors: hue is direction, saturation is speed; grey stands still")                                   \
    ROW("halos", "metals blue; metalness from 0.1 to 0.9 red, brighter where the colour is bright: the cause of halos")         \
    ROW("coarse", "green where a block is shaded once")                                                                         \
    ROW("coarse-reason", "why other blocks are not: depth or triangle red, normal blue, material yellow")                       \
    ROW("dais-addresses", "a colour for each stored triangle; white where there was no room for it")                            \
    ROW("dais-triangles", "different triangles in a pixel: 1 grey, 2 green, 3 yellow, more red")                                \
    ROW("dais-failures", "red where a triangle was stored again because its cache bucket stayed locked")                        \
    ROW("clusters", "a colour for each cluster of triangles; grey what has none")                                               \
    ROW("atlas", "the base colours in the atlas of virtual texturing; hatched where it is empty")                               \
    ROW("pages", "a colour for each page of virtual texturing, darker where coarser, striped where a finer one was wanted")     \
    ROW("shadow-pages", "shadow maps: a colour for each page, of the light that gives most to the pixel; magenta: none")        \
    ROW("shadow-levels", "shadow maps: the level of that page, finer is brighter, with a legend")                               \
    ROW("shadow-texels", "shadow maps: a texel of that page over the pixel: at most 1 green to blue, more yellow to red")       \
    ROW("shadow-errors", "shadow maps against rays: red where light is that should not be, blue where it is missing")           \
    ROW("shadow-variance", "shadow.denoise: standard deviation of the light seen, before filtering in space; brightest: 0.5")   \
    ROW("shadow-history", "shadow.denoise: frames that a pixel has collected; brightest: 32, or exact")                          \
    ROW("probe-lookup", "cubemap shadows: texels looked up for the light that gives most, a hue for each face; grey: none")      \
    ROW("probe-levels", "cubemap shadows: the level of that look-up, finer is brighter, with a legend")                         \
    ROW("reflections", "reflection probes: a colour for each, by its part of the light from all around; grey: none")                            \
    ROW("shadow-rays", "shadow rays that each pixel sends, with rays, maps, hybrid or cubemap, with a legend")                   \
    ROW("shadow-age", "shadow maps: frames since that page was drawn; striped where a finer one is wanted and not there")        \
    ROW("shadow-classes", "shadow.classify: lights of tiles that left: blue; that light no pixel: orange, some: grey, all: white") \
    ROW("triangles", "each triangle in its own color; gray: points and lines")                                                    \
    ROW("depth-jumps", "tiles by the ratio of their largest to their smallest depth, with a legend; gray: below 1.5")        \
    ROW("light-volumes", "surfaces in the hues of the lights that reach them, with a line where a light's volume ends")

static const struct names enums[] = {
    [FNL_ENUM_SHADING] = NAMES(fnl_shading, FNL_SHADING_COUNT, "forward", "forward-prepass", "deferred", "deferred-volumes", "light-prepass",
                               "pre-lighting", "low-res", "inferred", "light-indexed", "zioma", "visibility", "texturing",
                               "virtual-texturing", "coarse", "dais", "mobile", "auto"),
    [FNL_ENUM_LISTS] = NAMES(fnl_light_lists, FNL_LISTS_COUNT, "brute-force", "tiled", "clustered", "clustered-cpu", "mesh", "batches", "multipass",
                             "grid2d", "world", "halfz", "2.5d", "enhanced", "tree", "backface", "fine", "sparse", "bvh",
                             "raster", "zbin", "auto"),
    [FNL_ENUM_TILE_BOUNDS] = NAMES(fnl_tile_bounds, FNL_TILE_BOUNDS_COUNT, "planes", "box", "projected"),
    [FNL_ENUM_BACKFACE_AXIS] = NAMES(fnl_backface_axis, FNL_BACKFACE_AXIS_COUNT, "samples", "sum", "mips"),
    [FNL_ENUM_SLICES] = NAMES(fnl_slices, FNL_SLICES_COUNT, "exponential", "linear"),
    [FNL_ENUM_RASTER_PATH] = NAMES(fnl_raster_path, FNL_RASTER_COUNT, "auto", "hardware", "software"),
    [FNL_ENUM_RASTER_NODES] = NAMES(fnl_raster_nodes, FNL_RASTER_NODES_COUNT, "array", "links64", "links32"),
    [FNL_ENUM_VOLUME_SHAPE] =
        NAMES(fnl_volume_shape, FNL_VOLUME_SHAPE_COUNT, "solids", "quads", "fullscreen", "ellipse", "depth-bounds", "stencil"),
    [FNL_ENUM_LIGHT_BUFFER] = NAMES(fnl_light_buffer, FNL_LIGHT_BUFFER_COUNT, "auto", "rgba", "two", "four", "narrow"),
    [FNL_ENUM_LIGHT_PACKING] = NAMES(fnl_light_packing, FNL_LIGHT_PACKING_COUNT, "ids", "shift", "max", "stencil", "sets"),
    [FNL_ENUM_MSAA_METHOD] = NAMES(fnl_msaa_method, FNL_MSAA_METHOD_COUNT, "all", "tiles", "stencil", "compact", "coverage", "aggregate"),
    [FNL_ENUM_RAY_BACKEND] = NAMES(fnl_ray_backend, FNL_RAY_BACKEND_COUNT, "auto", "bvh", "ray-query"),
    [FNL_ENUM_SHADOW_FILTER] = NAMES(fnl_shadow_filter, FNL_SHADOW_FILTER_COUNT, "hard", "pcf", "pcss", "auto"),
    [FNL_ENUM_SHADOWS] = NAMES(fnl_shadows, FNL_SHADOWS_COUNT, "off", "rays", "maps", "sampled", "cubemap", "hybrid", "auto"),
    [FNL_ENUM_CUBEMAP_LOD] = NAMES(fnl_cubemap_lod, FNL_CUBEMAP_LOD_COUNT, "linear", "physical"),
    [FNL_ENUM_CUBEMAP_INSIDE] = NAMES(fnl_cubemap_inside, FNL_CUBEMAP_INSIDE_COUNT, "all", "moving", "none"),
    [FNL_ENUM_TRANSPARENCY] = NAMES(fnl_transparency, FNL_TRANSPARENCY_COUNT, "sorted", "weighted", "linked"),
    [FNL_ENUM_DECALS] = NAMES(fnl_decals, FNL_DECALS_COUNT, "lists", "gbuffer", "off"),
    [FNL_ENUM_CULLING] = NAMES(fnl_culling, FNL_CULLING_COUNT, "instances", "clusters", "triangles"),
    [FNL_ENUM_GEOMETRY] = NAMES(fnl_geometry, FNL_GEOMETRY_COUNT, "vertex", "mesh", "auto"),
    [FNL_ENUM_OCCLUSION] = NAMES(fnl_occlusion, FNL_OCCLUSION_COUNT, "off", "on", "auto"),
    [FNL_ENUM_MULTIVIEW] = NAMES(fnl_multiview, FNL_MULTIVIEW_COUNT, "auto", "off", "on"),
    [FNL_ENUM_STEREO_LISTS] = NAMES(fnl_stereo_lists, FNL_STEREO_LISTS_COUNT, "eye", "head", "auto"),
    [FNL_ENUM_STEREO_PATH] = NAMES(fnl_stereo_path, FNL_STEREO_PATH_COUNT, "auto", "eyes", "objects", "instances", "multiview"),
    [FNL_ENUM_ANTIALIASING] = NAMES(fnl_antialiasing, FNL_ANTIALIASING_COUNT, "none", "mlaa", "smaa", "taa", "auto"),
    [FNL_ENUM_GROUND] = NAMES(fnl_ground, FNL_GROUND_COUNT, "off", "on", "auto"),
    [FNL_ENUM_BACKGROUND] = NAMES(fnl_background, FNL_BACKGROUND_COUNT, "auto", "scene", "gradient", "blur"),
    [FNL_ENUM_ENERGY] = NAMES(fnl_energy, FNL_ENERGY_COUNT, "gltf", "conserving"),
    [FNL_ENUM_DEFERRED_PASS] = NAMES(fnl_deferred_pass, FNL_DEFERRED_PASS_COUNT, "compute", "fragment"),
    [FNL_ENUM_GBUFFER] = NAMES(fnl_gbuffer, FNL_GBUFFER_COUNT, "default", "siege", "killzone2", "frostbite2", "stalker", "clear-sky", "engel",
                               "destiny", "layers"),
    [FNL_ENUM_NORMALS] = NAMES(fnl_normal_encoding, FNL_NORMALS_COUNT, "layout", "octahedral", "xyz", "xy", "spherical", "sphere-map",
                               "stereographic", "view", "best-fit", "float"),
    [FNL_ENUM_GRADIENTS] = NAMES(fnl_gradients, FNL_GRADIENTS_COUNT, "stored", "derived"),
    [FNL_ENUM_VISIBILITY_SORT] = NAMES(fnl_visibility_sort, FNL_VISIBILITY_SORT_COUNT, "off", "class", "material"),
    [FNL_ENUM_COARSE_CRITERION] = NAMES(fnl_coarse_criterion, FNL_COARSE_CRITERION_COUNT, "z", "id", "minmax"),
    [FNL_ENUM_COARSE_SPLIT] = NAMES(fnl_coarse_split, FNL_COARSE_SPLIT_COUNT, "none", "albedo", "highlights", "sharp"),
    [FNL_ENUM_COARSE_FILTER] = NAMES(fnl_coarse_filter, FNL_COARSE_FILTER_COUNT, "mean", "sampled", "none"),
    [FNL_ENUM_DAIS_MODE] = NAMES(fnl_dais_mode, FNL_DAIS_MODE_COUNT, "target", "list"),
    [FNL_ENUM_MOBILE_LAYOUT] =
        NAMES(fnl_mobile_layout, FNL_MOBILE_LAYOUT_COUNT, "metallic-128", "specular-160", "metallic-256", "specular-256"),
    [FNL_ENUM_MOBILE_GAMMA] = NAMES(fnl_mobile_gamma, FNL_MOBILE_GAMMA_COUNT, "srgb", "sqrt", "power"),
    [FNL_ENUM_MOBILE_LIGHT] = NAMES(fnl_mobile_light, FNL_MOBILE_LIGHT_COUNT, "float", "unorm"),
    [FNL_ENUM_MOBILE_LIGHTS] = NAMES(fnl_mobile_lights, FNL_MOBILE_LIGHTS_COUNT, "lists", "volumes"),
    [FNL_ENUM_TONEMAP] = NAMES(fnl_tonemap, FNL_TONEMAP_COUNT, "none", "khronos-neutral", "aces", "agx"),
    [FNL_ENUM_EXPOSURE] = NAMES(fnl_exposure, FNL_EXPOSURE_NONE + 1, "auto", "ev", "none"),
    [FNL_ENUM_DEBUG_VIEW] = {"fnl_debug_view", AS_MANY_AS(FNL_DEBUG_COUNT, DEBUG_VIEWS(NAME_OF)),
                             (const char *const[FNL_DEBUG_COUNT]){DEBUG_VIEWS(NAME_OF)},
                             (const char *const[FNL_DEBUG_COUNT]){DEBUG_VIEWS(HELP_OF)}},
    [FNL_ENUM_SHADOW_UPDATE] = NAMES(fnl_shadow_update, FNL_SHADOW_UPDATE_COUNT, "always", "on-request"),
    [FNL_ENUM_LIGHT_KIND] = NAMES(fnl_light_kind, FNL_LIGHT_KIND_COUNT, "directional", "point", "spot", "capsule", "wedge", "box", "rectangle"),
    [FNL_ENUM_DECAL_KIND] = NAMES(fnl_decal_kind, FNL_DECAL_KIND_COUNT, "box", "volume", "mesh", "redraw", "baked"),
    [FNL_ENUM_DECAL_BLEND] = NAMES(fnl_decal_blend, FNL_DECAL_BLEND_COUNT, "alpha", "multiply", "add", "screen", "overlay"),
    [FNL_ENUM_DEVICE_TYPE] = NAMES(fnl_device_type, FNL_DEVICE_OTHER + 1, "discrete", "integrated", "virtual", "cpu", "other"),
    [FNL_ENUM_QUEUE] = NAMES(fnl_queue, FNL_QUEUE_COUNT, "graphics", "compute"),
    [FNL_ENUM_PASS_ROLE] = NAMES(fnl_pass_role, FNL_PASS_ROLE_COUNT, "rest", "geometry", "lists", "shadows", "shading", "read"),
};
_Static_assert(COUNT_OF(enums) == FNL_ENUM_COUNT, "each enum has its names");

const char *fnl_value_name(fnl_enum type, uint32_t value) {
    if ((uint32_t)type >= FNL_ENUM_COUNT || value >= enums[type].count) return NULL;
    return enums[type].names[value];
}

const char *fnl_value_help(fnl_enum type, uint32_t value) {
    if ((uint32_t)type >= FNL_ENUM_COUNT || value >= enums[type].count || !enums[type].helps) return NULL;
    return enums[type].helps[value];
}

uint32_t value_count(fnl_enum type) { return enums[type].count; }
const char *value_type(fnl_enum type) { return enums[type].type; }

bool fnl_value_find(fnl_enum type, const char *name, uint32_t *out) {
    const char *candidate;
    if (check_handle(__func__, "name", name) != FNL_OK) return false;
    if (type == FNL_ENUM_LISTS && strcmp(name, "all") == 0) name = fnl_value_name(type, FNL_LISTS_ALL); /* its name of old */
    for (uint32_t i = 0; (candidate = fnl_value_name(type, i)); i++) {
        if (strcmp(candidate, name) != 0) continue;
        if (out) *out = i;
        return true;
    }
    return false;
}
