/* SPDX-License-Identifier: MIT */
/** The defaults of a frame, and what the layouts of the G-buffer consist of. */
#include "base/check.h"
#include "fanal/renderer.h"
#include "passes/shade/gbuffer_layouts.h"

fnl_result fnl_gbuffer_query_info(fnl_gbuffer layout, fnl_gbuffer_info *out) {
    const fnl_host host = fnl_host_default();
    TRY(check_enum(CALL(&host), "layout", (int)layout, FNL_GBUFFER_COUNT, "fnl_gbuffer"));
    TRY(check_pointer(CALL(&host), "out", out));
    const struct gbuffer_layout *l = &gbuffer_layouts[layout];
    *out = (fnl_gbuffer_info){.target_count = l->target_count,
                              .published_bits = l->published_bits,
                              .material_count = l->id_count,
                              .normals = l->own,
                              .encodings = l->encodings | 1u << FNL_NORMALS_LAYOUT,
                              .field_count = l->field_count,
                              .fields = l->fields};
    for (uint32_t i = 0; i < l->target_count; i++) {
        out->target_bits[i] = gbuffer_format_bits(l->targets[i].format);
        out->bits += out->target_bits[i];
    }
    return FNL_OK;
}

fnl_frame fnl_frame_default(void) {
    return (fnl_frame){.width = 1280,
                       .height = 720,
                       .camera = fnl_camera_default(),
                       .shading = FNL_SHADING_DEFERRED,
                       .lists = FNL_LISTS_AUTO,
                       .msaa = 1,
                       .tonemap = FNL_TONEMAP_KHRONOS_NEUTRAL,
                       .exposure = FNL_EXPOSURE_AUTO,
                       .outputs = FNL_OUTPUT_COLOR,
                       .timers = true,
                       .decals = FNL_DECALS_LISTS,
                       .decal_mip_fix = true,
                       .list = {.frustum_cull = true, .cone_tests = true, .tree_hybrid = true, .normal_cones = true},
                       .tiles = {.size = 16, .bounds = FNL_TILE_BOUNDS_BOX, .min_depth = true, .max_depth = true},
                       .clusters = {.size = 64, .slices = 32, .near = INFINITY, .far = INFINITY},
                       .fine = {.pruning = true, .masks = 1},
                       .deferred = {.msaa_method = FNL_MSAA_COMPACT, .msaa_groups = 2},
                       .light_buffer = {.scale = 2},
                       .light_indexed = {.layers = 4},
                       .texturing = {.atlas_size = 8192},
                       .coarse = {.size = 2, .depth_factor = 1, .normal_degrees = 2, .tolerance = 0.05f, .albedo_tolerance = 1},
                       .dais = {.cache_buckets = 1 << 16},
                       .mobile = {.range = 8}};
}
