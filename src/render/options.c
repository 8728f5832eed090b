/* SPDX-License-Identifier: MIT */
#include "render/options.h"

#include "base/values.h"
#include "fanal/options.h"

#include <ctype.h>
#include <errno.h>

struct row {
    fnl_option option;
    size_t offset;
    const char *member; /* of fnl_frame, in C */
};

/* ---- who heeds what ---- */

#define PATH(name) (1u << FNL_SHADING_##name)
#define LISTS(name) (1u << FNL_LISTS_##name)
#define EVERY UINT32_MAX

enum {
    PATHS_GBUFFER = PATH(DEFERRED) | PATH(DEFERRED_VOLUMES), /* with a choice of layouts */
    PATHS_PREPASS = PATHS_GBUFFER | PATH(LIGHT_PREPASS) | PATH(PRE_LIGHTING) | PATH(LOW_RES) | PATH(COARSE) | PATH(TEXTURING) |
                    PATH(VIRTUAL_TEXTURING) | PATH(MOBILE),
    PATHS_MULTIVIEW = PATH(FORWARD_PREPASS) | PATH(DEFERRED) | PATH(VISIBILITY), /* those with the trait SHADING_MULTIVIEW */
    PATHS_LIGHT_BUFFER = PATH(LIGHT_PREPASS) | PATH(LOW_RES) | PATH(INFERRED),
    TILES = LISTS(TILED) | LISTS(HALFZ) | LISTS(25D) | LISTS(ENHANCED) | LISTS(TREE) | LISTS(BACKFACE) | LISTS(FINE) | LISTS(ZBIN),
    TILES_WITH_BOUNDS = LISTS(TILED) | LISTS(HALFZ) | LISTS(25D) | LISTS(BACKFACE),
    CLUSTERS = LISTS(CLUSTERED) | LISTS(CLUSTERED_CPU) | LISTS(SPARSE) | LISTS(BVH) | LISTS(RASTER)
};

/* ---- the rows ---- */

/* Behind the help, where needed: .choices, .multiple, .exact and so on. */
#define AT(field) offsetof(fnl_frame, field), #field
#define SWITCH(key_, field, paths, kinds, ...)                                                                                \
    {{.key = key_, .kind = FNL_OPTION_SWITCH, .unit = "", .shadings = paths, .lists = kinds, .help = __VA_ARGS__}, AT(field)}
#define NAME(key_, field, type, paths, kinds, ...)                                                                            \
    {{.key = key_, .kind = FNL_OPTION_NAME, .names = type, .unit = "", .shadings = paths, .lists = kinds, .help = __VA_ARGS__}, \
     AT(field)}
#define NUMERIC(kind_, key_, field, low_, high_, unit_, paths, kinds, ...)                                                    \
    {{.key = key_, .kind = kind_, .low = low_, .high = high_, .unit = unit_, .shadings = paths, .lists = kinds,               \
      .help = __VA_ARGS__},                                                                                                   \
     AT(field)}
#define COUNT(...) NUMERIC(FNL_OPTION_COUNT, __VA_ARGS__)
#define NUMBER(...) NUMERIC(FNL_OPTION_NUMBER, __VA_ARGS__)
#define ONLY(...)                                                                                                             \
    .choices = (const uint32_t[]){__VA_ARGS__}, .choice_count = sizeof((const uint32_t[]){__VA_ARGS__}) / sizeof(uint32_t)
#define EXACT .exact = true

static const struct row rows[] = {
    /* every frame */
    COUNT("width", width, 1, 16384, "pixels", EVERY, EVERY, "width of the picture"),
    COUNT("height", height, 1, 16384, "pixels", EVERY, EVERY, "height of the picture"),
    NAME("shading", shading, FNL_ENUM_SHADING, EVERY, EVERY, "shading path: how visible surfaces are shaded"),
    NAME("lists", lists, FNL_ENUM_LISTS, EVERY, EVERY, "light list: how a pixel finds the lights that reach it", EXACT),
    NAME("shadows", shadows, FNL_ENUM_SHADOWS, EVERY, EVERY, "how shadows are found"),
    COUNT("shadow.memory", shadow.memory, 1, 1024, "MiB", EVERY, EVERY, "shadows=maps and hybrid: memory of the image that holds all maps of a view"),
    COUNT("shadow.texels-max", shadow.texels_max, 8, 1920, "texels", EVERY, EVERY, "shadows=maps and hybrid: maximum face width of a local light's shadow map"),
    NAME("shadow.filter", shadow.filter, FNL_ENUM_SHADOW_FILTER, EVERY, EVERY, "shadows=maps and hybrid: how the edges of shadows are filtered"),
    SWITCH("shadow.classify", shadow.classify, EVERY, EVERY, "shadows=maps and hybrid: lights that are in shadow all over a tile leave its list", EXACT),
    NUMBER("shadow.page-rays", shadow.page_rays, 0, 1e6, "rays", EVERY, EVERY, "shadows=hybrid: how many take as long as drawing a page of shadow maps; 0: measured"),
    COUNT("shadow.samples", shadow.samples, 1, 1024, "rays", EVERY, EVERY, "shadow rays to a light with a radius; 1: shadows are hard"),
    NUMBER("shadow.light-radius", shadow.light_radius, 0, (double)FLT_MAX, "metres", EVERY, EVERY,
           "radius of lights that have none of their own, for soft shadows"),
    NUMBER("shadow.sun-degrees", shadow.sun_degrees, 0, 57, "degrees", EVERY, EVERY,
           "half the angle that directional and box lights fill which have none of their own; the sun 0.27"),
    NAME("shadow.ray-backend", shadow.ray_backend, FNL_ENUM_RAY_BACKEND, EVERY, EVERY,
         "what shadow rays go through: the library's own trees, or what the device builds for its ray queries"),
    COUNT("shadow.rays", shadow.rays, 1, 16, "rays", EVERY, EVERY, "shadows=sampled: rays from each surface, besides those to directional lights"),
    COUNT("shadow.seed", shadow.seed, 0, 999999, "", EVERY, EVERY, "shadows=sampled: frames with the same seed have the same noise"),
    SWITCH("shadow.denoise", shadow.denoise, PATH(DEFERRED), EVERY,
           "shadows=sampled: filters their noise over time and space; needs 1 sample per pixel"),
    SWITCH("shadow.guide", shadow.guide, PATH(DEFERRED), EVERY,
           "shadows=sampled: rays go to lights that earlier frames saw rather than to hidden ones; needs 1 sample per pixel"),
    NUMBER("shadow.contact-length", shadow.contact_length, 0, 1000, "meters", EVERY, EVERY,
           "contact shadows: length of the march to each light; 0: off"),
    NAME("shadow.cubemap-lod", shadow.cubemap_lod, FNL_ENUM_CUBEMAP_LOD, EVERY, EVERY, "shadows=cubemap: what shadows are as soft as"),
    NAME("shadow.cubemap-inside", shadow.cubemap_inside, FNL_ENUM_CUBEMAP_INSIDE, EVERY, EVERY,
         "shadows=cubemap: what casts shadows in a room besides its walls"),
    SWITCH("shadow.cubemap-tint", shadow.cubemap_tint, EVERY, EVERY, "shadows=cubemap: coloured glass colours the light"),
    SWITCH("shadow.cubemap-correct", shadow.cubemap_correct, EVERY, EVERY,
           "shadows=cubemap: looks up where light enters the box; off: in the direction of the light, which is wrong"),
    SWITCH("shadow.cubemap-compress", shadow.cubemap_compress, EVERY, EVERY, "shadows=cubemap: keeps cube maps in a quarter of the memory, as BC3"),
    COUNT("msaa", msaa, 1, 8, "samples", EVERY, EVERY, "samples per pixel; auto: 4 if the path and the device support it, otherwise 1", ONLY(1, 2, 4, 8), .has_auto = true),
    SWITCH("studio", studio, EVERY, EVERY, "lights scenes without light, adds fill to scenes with lights only"),
    NAME("ground", ground, FNL_ENUM_GROUND, EVERY, EVERY, "a floor under the scene that catches its shadows"),
    NAME("background", background, FNL_ENUM_BACKGROUND, EVERY, EVERY, "what is seen where no surface is"),
    NUMBER("background-blur", background_blur, 0, (double)3.14159274f, "radians", EVERY, EVERY, "background=blur: the angle over which the environment is blurred"),
    NAME("material.energy", energy, FNL_ENUM_ENERGY, EVERY, EVERY, "energy model: glTF's formulas, or white surfaces that reflect all light"),
    NAME("transparency", transparency, FNL_ENUM_TRANSPARENCY, ~PATH(INFERRED), EVERY,
         "how blended surfaces that overlap are composited"),
    COUNT("transmission-layers", transmission_layers, 1, 8, "layers", EVERY, EVERY,
          "most surfaces in a pixel that show what is behind them (glTF's transmission)"),
    NAME("aa", aa, FNL_ENUM_ANTIALIASING, EVERY, EVERY, "antialiasing in addition to MSAA; auto: smaa with 1 sample per pixel"),
    NUMBER("jitter.x", jitter.x, -8, 8, "pixels", EVERY, EVERY, "moves the sample of each pixel to the right"),
    NUMBER("jitter.y", jitter.y, -8, 8, "pixels", EVERY, EVERY, "moves the sample of each pixel down"),
    SWITCH("reset-history", reset_history, EVERY, EVERY, "forgets earlier frames, as after a camera cut"),
    NAME("tonemap", tonemap, FNL_ENUM_TONEMAP, EVERY, EVERY, "tone mapping curve"),
    NAME("exposure", exposure, FNL_ENUM_EXPOSURE, EVERY, EVERY, "how the exposure is found"),
    NUMBER("ev", ev, -64, 64, "EV100", EVERY, EVERY, "the exposure, with exposure=ev"),
    NAME("debug", debug, FNL_ENUM_DEBUG_VIEW, EVERY, EVERY, "debug view shown instead of the picture"),
    SWITCH("count-lights", count_lights, EVERY, EVERY, "counts light evaluations exactly, which is slower", EXACT),
    SWITCH("timers", timers, EVERY, EVERY, "measures each pass on the GPU", EXACT),
    SWITCH("pin-choice", pin_choice, EVERY, EVERY, "auto keeps its choice and measures nothing", EXACT),
    SWITCH("choose-close", choose_close, EVERY, EVERY, "shading=auto also measures visibility, whose picture is close, not equal"),
    COUNT("record-threads", record_threads, 0, 1024, "threads", EVERY, EVERY,
          "threads that record commands; 0: as many as there are jobs", EXACT),
    NUMBER("light-lod", light_lod, 0, (double)FLT_MAX, "pixels", EVERY, EVERY,
           "lights whose radius on the screen is smaller are drawn as points and light nothing; 0: off"),
    COUNT("shade-cost", shade_cost, 0, 100000, "iterations", ~PATH(INFERRED), EVERY,
          "extra loop iterations each time a surface is lit, to imitate a more expensive material; light-prepass, pre-lighting, low-res "
          "and zioma: blended surfaces alone", EXACT),

    /* what is drawn */
    NAME("culling", culling, FNL_ENUM_CULLING, EVERY, EVERY, "what is culled: instances, clusters or triangles", EXACT),
    NAME("geometry", geometry, FNL_ENUM_GEOMETRY, EVERY, EVERY, "what draws the clusters that culling leaves"),
    NAME("multiview", multiview, FNL_ENUM_MULTIVIEW, PATHS_MULTIVIEW, EVERY,
         "which views of a frame with several, that are not eyes, are drawn at once", EXACT),
    COUNT("stereo.eyes", stereo.eyes, 0, 6, "views", EVERY, EVERY, "views that are the eyes of one viewer, and share what they can; 0: none are"),
    NAME("stereo.lists", stereo.lists, FNL_ENUM_STEREO_LISTS, EVERY,
         LISTS(CLUSTERED) | LISTS(CLUSTERED_CPU) | LISTS(BVH) | LISTS(ZBIN) | LISTS(RASTER), "whether eyes have light lists of their own", EXACT),
    NAME("stereo.path", stereo.path, FNL_ENUM_STEREO_PATH, PATHS_MULTIVIEW, EVERY,
         "how what needs no lists is drawn for the eyes of a viewer", EXACT),
    NUMBER("stereo.margin", stereo.margin, 0, 20, "degrees", EVERY, EVERY,
           "how much wider on each side the frustum is that eyes are culled with", EXACT),
    NUMBER("stereo.mono-distance", stereo.mono_distance, 0, 1e6, "metres", PATHS_MULTIVIEW, EVERY,
           "what is farther away is drawn once for all eyes, from the middle between them; 0: for each"),
    NAME("occlusion", occlusion, FNL_ENUM_OCCLUSION, ~(PATH(LOW_RES) | PATH(INFERRED)), EVERY, "culls occluded surfaces too", EXACT),
    SWITCH("front-to-back", front_to_back, EVERY, EVERY, "draws opaque instances nearest first (culling=instances)"),
    NUMBER("prepass-pixels", prepass_pixels, 0, 100000, "pixels", PATH(FORWARD), EVERY,
           "prepass for instances at least this wide or high; 0: none"),
    NAME("decals", decals, FNL_ENUM_DECALS, EVERY, EVERY, "how decals are applied to surfaces"),
    SWITCH("decal-mip-fix", decal_mip_fix, PATHS_GBUFFER, EVERY, "decals=gbuffer: no fringes where depth jumps"),

    /* reflection probes */
    COUNT("reflections.refresh", reflections.refresh, 0, 1024, "probes", EVERY, EVERY, "reflection probes captured anew for each frame, in turn; 0: once"),
    COUNT("reflections.bounces", reflections.bounces, 1, 8, "captures", EVERY, EVERY,
          "how often a new reflection probe is captured, so that mirrors show what mirrors show"),
    SWITCH("reflections.parallax", reflections.parallax, EVERY, EVERY, "follows reflections to the walls of a probe's box"),

    /* light lists */
    SWITCH("list.frustum-cull", list.frustum_cull, EVERY,
           ((TILES & ~LISTS(TREE)) | LISTS(CLUSTERED) | LISTS(MESH) | LISTS(BATCHES) | LISTS(MULTIPASS) | LISTS(SPARSE) | LISTS(BVH) | LISTS(RASTER)),
           "culls lights outside the view first"),
    SWITCH("list.cone-tests", list.cone_tests, EVERY, TILES_WITH_BOUNDS | LISTS(ENHANCED) | LISTS(CLUSTERED) | LISTS(SPARSE) | LISTS(BVH),
           "tests spot lights as cones, not as spheres"),
    NAME("list.backface-axis", list.backface_axis, FNL_ENUM_BACKFACE_AXIS, EVERY, LISTS(BACKFACE),
         "where the axis of a tile's normal cone comes from"),
    SWITCH("list.tree-hybrid", list.tree_hybrid, EVERY, LISTS(TREE), "no tree where a plain list is cheaper"),
    SWITCH("list.normal-cones", list.normal_cones, EVERY, LISTS(SPARSE),
           "drops lights behind all surfaces of a cluster (deferred paths)"),
    COUNT("tiles.size", tiles.size, 8, 64, "pixels", EVERY, TILES, "side of a tile", ONLY(8, 16, 32, 64)),
    NAME("tiles.bounds", tiles.bounds, FNL_ENUM_TILE_BOUNDS, EVERY, TILES_WITH_BOUNDS, "what bounds a tile"),
    SWITCH("tiles.min-depth", tiles.min_depth, EVERY, LISTS(TILED) | LISTS(BACKFACE), "drops lights in front of a tile's nearest pixel"),
    SWITCH("tiles.max-depth", tiles.max_depth, EVERY, LISTS(TILED) | LISTS(BACKFACE), "drops lights behind a tile's farthest pixel"),
    COUNT("clusters.size", clusters.size, 8, 256, "pixels", EVERY, CLUSTERS, "side of a cluster on the screen"),
    COUNT("clusters.slices", clusters.slices, 1, 1024, "", EVERY, CLUSTERS | LISTS(ZBIN), "depth slices"),
    NAME("clusters.distribution", clusters.distribution, FNL_ENUM_SLICES, EVERY, CLUSTERS | LISTS(ZBIN),
         "how depth is divided into slices"),
    NUMBER("clusters.near", clusters.near, 0, (double)FLT_MAX, "metres", EVERY, CLUSTERS | LISTS(ZBIN),
           "view depth where the first slice ends; auto: from the scene", .above_low = true, .has_auto = true),
    NUMBER("clusters.far", clusters.far, 0, (double)FLT_MAX, "metres", EVERY, CLUSTERS | LISTS(ZBIN),
           "view depth where the last slice begins; auto: from the scene", .above_low = true, .has_auto = true),
    SWITCH("fine.pruning", fine.pruning, EVERY, LISTS(FINE), "tests each pixel against the lights' volumes"),
    COUNT("fine.masks", fine.masks, 0, 2, "pixels", EVERY, LISTS(FINE),
          "side of the squares that share a light mask; 0: no masks"),
    SWITCH("fine.packed", fine.packed, EVERY, LISTS(FINE), "32 bytes per tile, for at most 24 of 1024 lights"),
    NAME("raster.path", raster.path, FNL_ENUM_RASTER_PATH, EVERY, LISTS(RASTER),
         "what rasterises the light volumes"),
    NAME("raster.nodes", raster.nodes, FNL_ENUM_RASTER_NODES, EVERY, LISTS(RASTER), "how clusters store lights"),

    /* shading paths */
    NAME("volume-shape", volume_shape, FNL_ENUM_VOLUME_SHAPE, PATH(DEFERRED_VOLUMES) | PATH(MOBILE), EVERY,
         "the shape drawn for each light"),
    COUNT("volume-batch", volume_batch, 1, 64, "lights", PATH(DEFERRED_VOLUMES), EVERY,
          "volume-shape=fullscreen: lights added per draw"),
    NAME("light-buffer.kind", light_buffer.kind, FNL_ENUM_LIGHT_BUFFER, PATHS_LIGHT_BUFFER, EVERY,
         "which sums of light a pixel keeps"),
    COUNT("light-buffer.scale", light_buffer.scale, 2, 4, "pixels", PATH(LOW_RES) | PATH(INFERRED), EVERY,
          "side of the squares that are lit once", ONLY(2, 4)),
    NAME("light-indexed.packing", light_indexed.packing, FNL_ENUM_LIGHT_PACKING, PATH(LIGHT_INDEXED), EVERY,
         "how a pixel stores the ids of its lights"),
    COUNT("light-indexed.layers", light_indexed.layers, 1, 16, "", PATH(LIGHT_INDEXED) | PATH(ZIOMA), EVERY,
          "layers of lights per pixel; zioma takes 8 at most"),
    NAME("gbuffer.layout", gbuffer.layout, FNL_ENUM_GBUFFER, PATHS_GBUFFER, EVERY, "layout of the G-buffer"),
    NAME("gbuffer.normals", gbuffer.normals, FNL_ENUM_NORMALS, PATHS_GBUFFER, EVERY, "encoding of normals in the G-buffer"),
    SWITCH("gbuffer.chroma", gbuffer.chroma, PATHS_GBUFFER, EVERY, "default layout: luma and half of the chroma in each pixel"),
    SWITCH("gbuffer.prepass", gbuffer.prepass, PATHS_PREPASS, EVERY, "draws depth first, so that occluded surfaces read no textures", EXACT),
    NAME("deferred.pass", deferred.pass, FNL_ENUM_DEFERRED_PASS, PATH(DEFERRED), EVERY, "what runs the lighting pass", EXACT),
    COUNT("deferred.class-blocks", deferred.class_blocks, 0, 8, "pixels", PATH(DEFERRED), EVERY,
          "side of the blocks that are sorted by shader variant; 0: one shader for all", ONLY(0, 4, 8), EXACT),
    NAME("deferred.msaa-method", deferred.msaa_method, FNL_ENUM_MSAA_METHOD, PATH(DEFERRED), EVERY, "which samples are shaded"),
    COUNT("deferred.msaa-groups", deferred.msaa_groups, 2, 3, "", PATH(DEFERRED), EVERY,
          "msaa-method=aggregate: surfaces per pixel at most", ONLY(2, 3)),
    NUMBER("deferred.msaa-tolerance", deferred.msaa_tolerance, 0, 1, "", PATH(DEFERRED), EVERY,
           "samples that differ by no more are one surface"),
    NAME("visibility.sort", visibility.sort, FNL_ENUM_VISIBILITY_SORT, PATH(VISIBILITY), EVERY,
         "what pixels are sorted by before shading"),
    SWITCH("visibility.barycentrics", visibility.barycentrics, PATH(VISIBILITY), EVERY,
           "stores barycentrics, so that shading fetches no positions; 1 sample"),
    SWITCH("visibility.grid", visibility.grid, PATH(VISIBILITY), EVERY,
           "draws ids at half the size with 4 samples: a quarter of the fragments; 1 sample"),
    NAME("texturing.gradients", texturing.gradients, FNL_ENUM_GRADIENTS, PATH(TEXTURING), EVERY, "where texture gradients come from"),
    COUNT("texturing.atlas-size", texturing.atlas_size, 256, 8192, "texels", PATH(VIRTUAL_TEXTURING), EVERY, "greatest side of the atlas",
          .multiple = 256),
    COUNT("coarse.size", coarse.size, 1, 4, "pixels", PATH(COARSE), EVERY, "side of a block", ONLY(1, 2, 4)),
    NAME("coarse.criterion", coarse.criterion, FNL_ENUM_COARSE_CRITERION, PATH(COARSE), EVERY,
         "what shows that a block is one surface"),
    NUMBER("coarse.depth-factor", coarse.depth_factor, 0, (double)FLT_MAX, "", PATH(COARSE), EVERY,
           "how far depths may differ from the slope of the first pixel"),
    NUMBER("coarse.normal-degrees", coarse.normal_degrees, 0, 180, "degrees", PATH(COARSE), EVERY,
           "how far normals may differ"),
    NUMBER("coarse.tolerance", coarse.tolerance, 0, 1, "", PATH(COARSE), EVERY, "how far material parameters may differ"),
    NUMBER("coarse.albedo-tolerance", coarse.albedo_tolerance, 0, 1, "", PATH(COARSE), EVERY,
           "how far base colours may differ"),
    NAME("coarse.split", coarse.split, FNL_ENUM_COARSE_SPLIT, PATH(COARSE), EVERY, "what a block does not share"),
    NAME("coarse.filter", coarse.filter, FNL_ENUM_COARSE_FILTER, PATH(COARSE), EVERY, "where a block's base colour comes from"),
    SWITCH("coarse.gather", coarse.gather, PATH(COARSE), EVERY, "writes what blocks share in a pass of its own", EXACT),
    NUMBER("coarse.ao-radius", coarse.ao_radius, 0, (double)FLT_MAX, "metres", PATH(COARSE), EVERY,
           "radius of ambient occlusion at the coarse rate; 0: off"),
    NUMBER("coarse.fovea", coarse.fovea, 0, 180, "degrees", PATH(COARSE), EVERY, "foveation: how far from the gaze each pixel is shaded, and only there; 0: off"),
    NUMBER("coarse.fovea-far", coarse.fovea_far, 0, 180, "degrees", PATH(COARSE), EVERY,
           "foveation, size=4: how far from the gaze blocks of 2x2 are shaded once; beyond it those of 4x4"),
    NAME("dais.mode", dais.mode, FNL_ENUM_DAIS_MODE, PATH(DAIS), EVERY, "where references to triangles are stored"),
    COUNT("dais.cache-buckets", dais.cache_buckets, 1, 1 << 22, "", PATH(DAIS), EVERY,
          "buckets of the triangle cache, two triangles each", .power_of_two = true),
    SWITCH("dais.multirate", dais.multirate, PATH(DAIS), EVERY, "ambient light once for four pixels of a triangle"),
    NAME("mobile.layout", mobile.layout, FNL_ENUM_MOBILE_LAYOUT, PATH(MOBILE), EVERY, "what tile memory holds per pixel"),
    NAME("mobile.gamma", mobile.gamma, FNL_ENUM_MOBILE_GAMMA, PATH(MOBILE), EVERY, "how 8-bit colours are encoded"),
    NAME("mobile.light", mobile.light, FNL_ENUM_MOBILE_LIGHT, PATH(MOBILE), EVERY, "format in which light is summed up"),
    NAME("mobile.lights", mobile.lights, FNL_ENUM_MOBILE_LIGHTS, PATH(MOBILE), EVERY, "how a pixel finds its lights"),
    NUMBER("mobile.range", mobile.range, 0, (double)FLT_MAX, "", PATH(MOBILE), EVERY,
           "light=unorm: the greatest exposed radiance", .above_low = true),
    SWITCH("mobile.separate", mobile.separate, PATH(MOBILE), EVERY, "separate passes, as on devices that cannot merge them"),
    SWITCH("mobile.recycle", mobile.recycle, PATH(MOBILE), EVERY, "the picture reuses the memory of the normals"),
};

static const struct row *find(const char *key) {
    for (uint32_t i = 0; key && i < COUNT_OF(rows); i++)
        if (strcmp(rows[i].option.key, key) == 0) return &rows[i];
    return NULL;
}

bool fnl_option_query(uint32_t index, fnl_option *out) {
    if (check_handle(__func__, "out", out) != FNL_OK || index >= COUNT_OF(rows)) return false;
    *out = rows[index].option;
    out->multiple = MAX(out->multiple, 1u);
    out->exact = out->exact || out->lists != EVERY; /* no list changes the picture */
    return true;
}

/* ---- checks ---- */

static fnl_result check_row(const struct call *call, const struct row *row, const char *name, const void *field) {
    const fnl_option *o = &row->option;
    char unit[32];
    uint32_t count;
    float number;
    double high;
    switch (o->kind) {
    case FNL_OPTION_SWITCH:
        return FNL_OK;
    case FNL_OPTION_COUNT:
        memcpy(&count, field, sizeof count);
        if (o->has_auto && count == 0) return FNL_OK;
        if (o->choice_count) return check_choice(call, name, count, o->choices, o->choice_count);
        TRY(check_count(call, name, count, (uint64_t)o->low, (uint64_t)o->high));
        if (o->multiple && count % o->multiple) return misuse(call, "%s is %u, must be a multiple of %u", name, count, o->multiple);
        if (o->power_of_two && (count & (count - 1))) return misuse(call, "%s is %u, must be a power of two", name, count);
        return FNL_OK;
    case FNL_OPTION_NUMBER:
        memcpy(&number, field, sizeof number);
        high = o->has_auto ? (double)INFINITY : o->high;
        if ((double)number <= high && (o->above_low ? (double)number > o->low : (double)number >= o->low)) return FNL_OK;
        snprintf(unit, sizeof unit, "%s%s", *o->unit ? " " : "", o->unit); /* only now: frames come here */
        if (o->above_low) return check_above(call, name, (double)number, o->low, high, unit);
        return check_range(call, name, (double)number, o->low, high, unit);
    default:
        memcpy(&count, field, sizeof count); /* enums have the size of int */
        return check_enum(call, name, (int)count, value_count(o->names), value_type(o->names));
    }
}

fnl_result options_check(const struct call *call, const fnl_frame *frame) {
    for (uint32_t i = 0; i < COUNT_OF(rows); i++)
        TRY(check_row(call, &rows[i], rows[i].member, (const char *)frame + rows[i].offset));
    return FNL_OK;
}

bool options_equal(const fnl_frame *a, const fnl_frame *b) {
    for (uint32_t i = 0; i < COUNT_OF(rows); i++) {
        const size_t at = rows[i].offset, size = rows[i].option.kind == FNL_OPTION_SWITCH ? sizeof(bool) : sizeof(uint32_t);
        if (memcmp((const char *)a + at, (const char *)b + at, size) != 0) return false;
    }
    return true;
}

/* ---- by text ---- */

static fnl_result parse_name(const struct call *call, const fnl_option *o, const char *text, uint32_t *out) {
    char known[512] = "";
    if (fnl_value_find(o->names, text, out)) return FNL_OK;
    const char *name;
    for (uint32_t i = 0; (name = fnl_value_name(o->names, i)); i++) {
        size_t length = strlen(known);
        snprintf(known + length, sizeof known - length, "%s%s", i ? ", " : "", name);
    }
    return misuse(call, "%s is '%.80s', must be one of %s", o->key, text, known);
}

static fnl_result parse(const struct call *call, const struct row *row, const char *text, void *out, size_t *out_size) {
    const fnl_option *o = &row->option;
    char *end = NULL;
    if (o->kind == FNL_OPTION_SWITCH) {
        bool on = strcmp(text, "on") == 0;
        if (!on && strcmp(text, "off") != 0) return misuse(call, "%s is '%.80s', must be on or off", o->key, text);
        memcpy(out, &on, *out_size = sizeof on);
        return FNL_OK;
    }
    if (o->kind == FNL_OPTION_NAME) {
        uint32_t value = 0;
        TRY(parse_name(call, o, text, &value));
        memcpy(out, &value, *out_size = sizeof value);
        return FNL_OK;
    }
    if (o->kind == FNL_OPTION_COUNT) {
        errno = 0;
        if (o->has_auto && strcmp(text, "auto") == 0) {
            memset(out, 0, *out_size = sizeof(uint32_t));
            return FNL_OK;
        }
        unsigned long long count = strtoull(text, &end, 10);
        if (*text < '0' || *text > '9' || *end) return misuse(call, "%s is '%.80s', must be a whole number%s", o->key, text, o->has_auto ? " or auto" : "");
        if (o->has_auto && count == 0) return check_choice(call, o->key, 0, o->choices, o->choice_count);
        uint32_t narrow = errno || count > UINT32_MAX ? UINT32_MAX : (uint32_t)count;
        memcpy(out, &narrow, *out_size = sizeof narrow);
        return check_row(call, row, o->key, out);
    }
    const char *digits = text + (*text == '-');
    const bool hexadecimal = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X'), begins = isdigit((unsigned char)digits[*digits == '.']) && !hexadecimal;
    float number = o->has_auto && strcmp(text, "auto") == 0 ? INFINITY : (float)number_read(text, &end);
    if (end && (!begins || *end || !isfinite(number)))
        return misuse(call, "%s is '%.80s', must be a number%s", o->key, text, o->has_auto ? " or auto" : "");
    memcpy(out, &number, *out_size = sizeof number);
    return check_row(call, row, o->key, out);
}

fnl_result fnl_frame_set(const fnl_host *host, fnl_frame *frame, const char *key, const char *value) {
    const fnl_host built_in = fnl_host_default();
    const struct call *call = CALL(host ? host : &built_in);
    char bytes[8];
    size_t size = 0;
    TRY(check_pointer(call, "frame", frame));
    TRY(check_pointer(call, "key", key));
    TRY(check_pointer(call, "value", value));
    const struct row *row = find(key);
    if (!row) return misuse(call, "there is no option '%.80s'", key);
    TRY(parse(call, row, value, bytes, &size));
    memcpy((char *)frame + row->offset, bytes, size);
    return FNL_OK;
}

size_t fnl_frame_get(const fnl_frame *frame, const char *key, char *text, size_t capacity) {
    if (check_handle(__func__, "frame", frame) != FNL_OK || check_handle(__func__, "key", key) != FNL_OK) return 0;
    if (!text && capacity && check_handle(__func__, "text", text) != FNL_OK) return 0;
    const struct row *row = find(key);
    if (!row) return 0;
    const void *field = (const char *)frame + row->offset;
    const char *name;
    uint32_t count;
    float number;
    bool on;
    int length = 0;
    char digits[32];
    switch (row->option.kind) {
    case FNL_OPTION_SWITCH:
        memcpy(&on, field, sizeof on);
        length = snprintf(text, capacity, "%s", on ? "on" : "off");
        break;
    case FNL_OPTION_COUNT:
        memcpy(&count, field, sizeof count);
        if (row->option.has_auto && count == 0) length = snprintf(text, capacity, "auto");
        else length = snprintf(text, capacity, "%u", count);
        break;
    case FNL_OPTION_NUMBER:
        memcpy(&number, field, sizeof number);
        length = snprintf(text, capacity, "%s", isinf(number) ? "auto" : number_text((double)number, digits));
        break;
    default:
        memcpy(&count, field, sizeof count);
        name = fnl_value_name(row->option.names, count);
        length = snprintf(text, capacity, "%s", name ? name : "?");
    }
    return (size_t)length;
}

/* ---- defaults ---- */

fnl_frame fnl_frame_default(void) {
    return (fnl_frame){.width = 1280,
                       .height = 720,
                       .camera = fnl_camera_default(),
                       .shading = FNL_SHADING_DEFERRED,
                       .lists = FNL_LISTS_AUTO,
                       .shadow = {.memory = 64, .texels_max = 1920, .filter = FNL_SHADOW_FILTER_AUTO, .samples = 1, .rays = 1, .cubemap_tint = true, .cubemap_correct = true},
                       .shadows = FNL_SHADOWS_MAPS,
                       .msaa = FNL_MSAA_AUTO,
                       .aa = FNL_ANTIALIASING_AUTO,
                       .studio = true,
                       .ground = FNL_GROUND_AUTO,
                       .background_blur = 0.35f,
                       .transmission_layers = 4,
                       .tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL,
                       .exposure = FNL_EXPOSURE_AUTO,
                       .outputs = FNL_OUTPUT_COLOR,
                       .timers = true,
                       .occlusion = FNL_OCCLUSION_AUTO,
                       .stereo = {.lists = FNL_STEREO_LISTS_AUTO},
                       .decals = FNL_DECALS_LISTS,
                       .decal_mip_fix = true,
                       .reflections = {.bounces = 1, .parallax = true},
                       .list = {.frustum_cull = true, .cone_tests = true, .tree_hybrid = true, .normal_cones = true},
                       .tiles = {.size = 16, .bounds = FNL_TILE_BOUNDS_BOX, .min_depth = true, .max_depth = true},
                       .clusters = {.size = 64, .slices = 32, .near = INFINITY, .far = INFINITY},
                       .fine = {.pruning = true, .masks = 1},
                       .deferred = {.msaa_method = FNL_MSAA_COMPACT, .msaa_groups = 2},
                       .volume_batch = 1,
                       .light_buffer = {.scale = 2},
                       .light_indexed = {.layers = 4},
                       .texturing = {.atlas_size = 8192},
                       .coarse = {.size = 2, .depth_factor = 1, .normal_degrees = 2, .tolerance = 0.05f, .albedo_tolerance = 1, .fovea_far = 30},
                       .dais = {.cache_buckets = 1 << 16},
                       .mobile = {.range = 8}};
}
