/* SPDX-License-Identifier: MIT */
/** What a frame may ask for. */
#include "passes/visibility/visibility.h"
#include "render/shading.h"

static fnl_result check_gbuffer(const struct call *call, const fnl_frame *frame) {
    TRY(check_enum(call, "gbuffer", (int)frame->gbuffer, FNL_GBUFFER_COUNT, "fnl_gbuffer"));
    TRY(check_enum(call, "normals", (int)frame->normals, FNL_NORMALS_COUNT, "fnl_normal_encoding"));
    TRY(check_enum(call, "deferred_pass", (int)frame->deferred_pass, FNL_DEFERRED_PASS_COUNT, "fnl_deferred_pass"));
    if (frame->deferred_pass == FNL_DEFERRED_FRAGMENT && frame->shading == FNL_SHADING_DEFERRED &&
        (frame->class_blocks || frame->msaa > 1))
        return unsupported(call, "deferred lighting in a fragment pass has no classes and 1 sample a pixel");
    bool plain = frame->gbuffer == FNL_GBUFFER_DEFAULT && frame->normals == FNL_NORMALS_LAYOUT && !frame->chroma;
    bool is_auto = frame->shading == FNL_SHADING_AUTO; /* may become deferred */
    if (plain || (!is_auto && !shading_is(frame->shading, SHADING_GBUFFER))) return FNL_OK;
    if (!is_auto && !shading_is(frame->shading, SHADING_LAYOUTS))
        return unsupported(
            call, "%s shading has a G-buffer of its own: gbuffer, normals and chroma are of deferred and deferred-volumes",
            fnl_shading_name(frame->shading));
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    if (!(info.encodings >> frame->normals & 1))
        return unsupported(call, "the normals of layout %s cannot hold encoding %s", fnl_gbuffer_name(frame->gbuffer),
                           fnl_normal_encoding_name(frame->normals));
    if (frame->chroma && frame->gbuffer != FNL_GBUFFER_DEFAULT)
        return unsupported(call, "layout %s has no base colour that chroma could make smaller",
                           fnl_gbuffer_name(frame->gbuffer));
    return FNL_OK;
}

/* Views of the G-buffer need one that holds what they show. */
static fnl_result check_gbuffer_view(const struct call *call, const fnl_frame *frame) {
    if (frame->debug < FNL_DEBUG_GBUFFER_0 || frame->debug > FNL_DEBUG_LIT_FORWARD) return FNL_OK;
    if (frame->shading == FNL_SHADING_AUTO || !shading_is(frame->shading, SHADING_LAYOUTS) || frame->msaa > 1)
        return unsupported(call, "the view %s shows the G-buffer of deferred shading with 1 sample",
                           fnl_debug_view_name(frame->debug));
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    uint32_t index = (uint32_t)(frame->debug - FNL_DEBUG_GBUFFER_0);
    if (index <= 4 && index >= info.target_count + (frame->normals == FNL_NORMALS_FLOAT))
        return unsupported(call, "layout %s has no render target %u", fnl_gbuffer_name(frame->gbuffer), index);
    if (frame->debug == FNL_DEBUG_MATERIAL_ID && info.material_count == 0)
        return unsupported(call, "layout %s has no material ID", fnl_gbuffer_name(frame->gbuffer));
    return FNL_OK;
}

static fnl_result check_coarse(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_coarse_options *coarse = &frame->coarse;
    static const uint32_t sizes[] = {1, 2, 4};
    TRY(check_choice(call, "coarse.size", coarse->size, sizes, COUNT_OF(sizes)));
    TRY(check_enum(call, "coarse.criterion", (int)coarse->criterion, FNL_COARSE_CRITERION_COUNT, "fnl_coarse_criterion"));
    TRY(check_enum(call, "coarse.split", (int)coarse->split, FNL_COARSE_SPLIT_COUNT, "fnl_coarse_split"));
    TRY(check_enum(call, "coarse.filter", (int)coarse->filter, FNL_COARSE_FILTER_COUNT, "fnl_coarse_filter"));
    TRY(check_range(call, "coarse.depth_factor", (double)coarse->depth_factor, 0, (double)FLT_MAX, ""));
    TRY(check_range(call, "coarse.normal_degrees", (double)coarse->normal_degrees, 0, 180, " degrees"));
    TRY(check_range(call, "coarse.tolerance", (double)coarse->tolerance, 0, 1, ""));
    TRY(check_range(call, "coarse.albedo_tolerance", (double)coarse->albedo_tolerance, 0, 1, ""));
    TRY(check_range(call, "coarse.ao_radius", (double)coarse->ao_radius, 0, (double)FLT_MAX, " metres"));
    TRY(check_count(call, "shade_cost", frame->shade_cost, 0, 100000));
    if (frame->shading == FNL_SHADING_COARSE && coarse->criterion == FNL_COARSE_CRITERION_ID &&
        !gpu_info(r->device)->primitive_ids)
        return unsupported(call, "this device cannot number triangles, which coarse.criterion id needs; use z");
    bool view = frame->debug == FNL_DEBUG_COARSE || frame->debug == FNL_DEBUG_COARSE_REASON;
    if (view && frame->shading != FNL_SHADING_COARSE)
        return unsupported(call, "the view %s shows the blocks of coarse shading, not of %s",
                           fnl_debug_view_name(frame->debug), fnl_shading_name(frame->shading));
    return FNL_OK;
}

static fnl_result check_geometry(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    TRY(check_enum(call, "geometry", (int)frame->geometry, FNL_GEOMETRY_COUNT, "fnl_geometry"));
    if (frame->geometry != FNL_GEOMETRY_MESH) return FNL_OK;
    if (!gpu_info(r->device)->mesh_shader || r->no_meshes)
        return unsupported(call, "this device has no mesh shaders; use geometry vertex or auto");
    if (frame->culling == FNL_CULLING_INSTANCES)
        return unsupported(call, "mesh shaders draw what culling by clusters or by triangles leaves, not that by instances");
    return FNL_OK;
}

fnl_result frame_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame) {
    static const uint32_t samples[] = {1, 2, 4, 8}, groups[] = {2, 3}, blocks[] = {0, 4, 8};
    TRY(check_count(call, "width", frame->width, 1, 16384));
    TRY(check_count(call, "height", frame->height, 1, 16384));
    TRY(camera_check(call, "camera.", &frame->camera));
    TRY(check_enum(call, "shading", (int)frame->shading, FNL_SHADING_COUNT, "fnl_shading"));
    TRY(check_enum(call, "lists", (int)frame->lists, FNL_LISTS_COUNT, "fnl_light_lists"));
    TRY(lists_check(call, &frame->list_options));
    TRY(check_gbuffer(call, frame));
    TRY(check_enum(call, "msaa_method", (int)frame->msaa_method, FNL_MSAA_METHOD_COUNT, "fnl_msaa_method"));
    TRY(check_choice(call, "msaa_groups", frame->msaa_groups, groups, COUNT_OF(groups)));
    TRY(check_range(call, "msaa_tolerance", (double)frame->msaa_tolerance, 0, 1, ""));
    TRY(check_enum(call, "transparency", (int)frame->transparency, FNL_TRANSPARENCY_COUNT, "fnl_transparency"));
    TRY(check_enum(call, "decals", (int)frame->decals, FNL_DECALS_COUNT, "fnl_decals"));
    TRY(check_enum(call, "culling", (int)frame->culling, FNL_CULLING_COUNT, "fnl_culling"));
    TRY(check_geometry(call, r, frame));
    TRY(check_enum(call, "aa", (int)frame->aa, FNL_ANTIALIASING_COUNT, "fnl_antialiasing"));
    TRY(check_range(call, "jitter.x", (double)frame->jitter.x, -8, 8, " pixels"));
    TRY(check_range(call, "jitter.y", (double)frame->jitter.y, -8, 8, " pixels"));
    TRY(check_enum(call, "tonemap", (int)frame->tonemap, FNL_TONEMAP_COUNT, "fnl_tonemap"));
    TRY(check_enum(call, "mobile.layout", (int)frame->mobile.layout, FNL_MOBILE_LAYOUT_COUNT, "fnl_mobile_layout"));
    TRY(check_enum(call, "mobile.gamma", (int)frame->mobile.gamma, FNL_MOBILE_GAMMA_COUNT, "fnl_mobile_gamma"));
    TRY(check_enum(call, "mobile.light", (int)frame->mobile.light, FNL_MOBILE_LIGHT_COUNT, "fnl_mobile_light"));
    TRY(check_enum(call, "mobile.lights", (int)frame->mobile.lights, FNL_MOBILE_LIGHTS_COUNT, "fnl_mobile_lights"));
    TRY(check_above(call, "mobile.range", (double)frame->mobile.range, 0, (double)FLT_MAX, ""));
    TRY(check_enum(call, "visibility.sort", (int)frame->visibility.sort, FNL_VISIBILITY_SORT_COUNT, "fnl_visibility_sort"));
    TRY(check_count(call, "atlas_size", frame->atlas_size, 256, 8192));
    if (frame->atlas_size % 256) return misuse(call, "atlas_size is %u, must be a multiple of 256", frame->atlas_size);
    TRY(check_enum(call, "gradients", (int)frame->gradients, FNL_GRADIENTS_COUNT, "fnl_gradients"));
    TRY(check_enum(call, "exposure", (int)frame->exposure, FNL_EXPOSURE_NONE + 1, "fnl_exposure"));
    if (frame->exposure == FNL_EXPOSURE_EV) TRY(check_range(call, "ev", (double)frame->ev, -64, 64, ""));
    TRY(check_enum(call, "debug", (int)frame->debug, FNL_DEBUG_COUNT, "fnl_debug_view"));
    TRY(check_gbuffer_view(call, frame));
    TRY(check_coarse(call, r, frame));
    TRY(check_count(call, "outputs", frame->outputs, 0, (1u << OUTPUT_COUNT) - 1));
    TRY(check_range(call, "light_lod", (double)frame->light_lod, 0, (double)FLT_MAX, " pixels"));
    TRY(check_choice(call, "class_blocks", frame->class_blocks, blocks, COUNT_OF(blocks)));
    TRY(check_choice(call, "msaa", frame->msaa, samples, COUNT_OF(samples)));
    if (!fnl_lists_supported(frame->shading, frame->lists))
        return unsupported(call, "%s lists do not go with %s shading", fnl_light_lists_name(frame->lists),
                           fnl_shading_name(frame->shading));
    if (!fnl_msaa_supported(frame->shading) && frame->msaa > 1)
        return unsupported(call, "%s shading has no MSAA; use another order, or 1 sample", fnl_shading_name(frame->shading));
    uint32_t counts = gpu_info(r->device)->msaa_counts;
    if (!(counts & frame->msaa))
        return unsupported(call, "this device cannot render with %u samples a pixel, but with 1%s%s%s", frame->msaa,
                           counts & 2 ? ", 2" : "", counts & 4 ? ", 4" : "", counts & 8 ? ", 8" : "");
    bool texturing = frame->shading == FNL_SHADING_TEXTURING || frame->shading == FNL_SHADING_VIRTUAL_TEXTURING;
    if (texturing && frame->msaa > 1 &&
        !gpu_format_supports(r->device, VK_FORMAT_R16G16B16A16_UNORM, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT))
        return unsupported(call, "this device cannot draw to R16G16B16A16_UNORM, which %s shading with MSAA needs",
                           fnl_shading_name(frame->shading));
    if (frame->shading == FNL_SHADING_DEFERRED && frame->msaa > 1 && frame->class_blocks)
        return unsupported(call, "blocks of pixels cannot be classified with MSAA; use class_blocks 0 or 1 sample");
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.grid &&
        (frame->msaa > 1 || frame->visibility.barycentrics || !visibility_grid_supported(r->device)))
        return unsupported(
            call, "visibility.grid takes 1 sample a pixel, no visibility.barycentrics, and a device with 4 samples");
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.barycentrics && frame->msaa > 1)
        return unsupported(call, "visibility.barycentrics takes 1 sample a pixel, not %u", frame->msaa);
    if ((frame->shading == FNL_SHADING_VISIBILITY || frame->shading == FNL_SHADING_DAIS) &&
        !gpu_info(r->device)->primitive_ids)
        return unsupported(call, "this device cannot number triangles, which %s shading needs",
                           fnl_shading_name(frame->shading));
    TRY(dais_check(call, r, frame));
    if (frame->debug == FNL_DEBUG_ATLAS || frame->debug == FNL_DEBUG_PAGES) {
        if (frame->shading != FNL_SHADING_VIRTUAL_TEXTURING)
            return unsupported(call, "the view %s shows what virtual-texturing shading has",
                               fnl_debug_view_name(frame->debug));
        if (frame->debug == FNL_DEBUG_PAGES && frame->msaa > 1)
            return unsupported(call, "the view pages takes 1 sample a pixel, not %u", frame->msaa);
    }
    if (frame->debug == FNL_DEBUG_CLUSTERS && !gpu_info(r->device)->primitive_ids)
        return unsupported(call, "this device cannot number triangles, which the view of clusters needs");
    if (temporal_needs_motion(frame) && frame->msaa > 1)
        return unsupported(call, "motion vectors and temporal antialiasing take one sample per pixel, not %u", frame->msaa);
    return mobile_check(call, r, frame);
}
