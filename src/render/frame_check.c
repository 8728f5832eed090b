/* SPDX-License-Identifier: MIT */
/** What a frame may ask for. */
#include "passes/visibility/visibility.h"
#include "render/shading.h"

static fnl_result check_gbuffer(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    REQUIRE(host, (uint32_t)frame->gbuffer < FNL_GBUFFER_COUNT);
    REQUIRE(host, (uint32_t)frame->normals < FNL_NORMALS_COUNT);
    REQUIRE(host, (uint32_t)frame->deferred_pass < FNL_DEFERRED_PASS_COUNT);
    if (frame->deferred_pass == FNL_DEFERRED_FRAGMENT && frame->shading == FNL_SHADING_DEFERRED &&
        (frame->class_blocks || frame->msaa > 1)) {
        log_error(host, "deferred lighting in a fragment pass has no classes and 1 sample a pixel");
        return FNL_ERROR_UNSUPPORTED;
    }
    bool plain = frame->gbuffer == FNL_GBUFFER_DEFAULT && frame->normals == FNL_NORMALS_LAYOUT && !frame->chroma;
    bool is_auto = frame->shading == FNL_SHADING_AUTO; /* may become deferred */
    if (plain || (!is_auto && !shading_is(frame->shading, SHADING_GBUFFER))) return FNL_OK;
    if (!is_auto && !shading_is(frame->shading, SHADING_LAYOUTS)) {
        log_error(host,
                  "%s shading has a G-buffer of its own: gbuffer, normals and chroma are of deferred and deferred-volumes",
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    if (!(info.encodings >> frame->normals & 1)) {
        log_error(host, "the normals of layout %s cannot hold encoding %s", fnl_gbuffer_name(frame->gbuffer),
                  fnl_normal_encoding_name(frame->normals));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->chroma && frame->gbuffer != FNL_GBUFFER_DEFAULT) {
        log_error(host, "layout %s has no base colour that chroma could make smaller", fnl_gbuffer_name(frame->gbuffer));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

/* Views of the G-buffer need one that holds what they show. */
static fnl_result check_gbuffer_view(const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->debug < FNL_DEBUG_GBUFFER_0 || frame->debug > FNL_DEBUG_LIT_FORWARD) return FNL_OK;
    const fnl_host *host = &r->host;
    if (frame->shading == FNL_SHADING_AUTO || !shading_is(frame->shading, SHADING_LAYOUTS) || frame->msaa > 1) {
        log_error(host, "the view %s shows the G-buffer of deferred shading with 1 sample",
                  fnl_debug_view_name(frame->debug));
        return FNL_ERROR_UNSUPPORTED;
    }
    fnl_gbuffer_info info;
    TRY(fnl_gbuffer_query_info(frame->gbuffer, &info));
    uint32_t index = (uint32_t)(frame->debug - FNL_DEBUG_GBUFFER_0);
    if (index <= 4 && index >= info.target_count + (frame->normals == FNL_NORMALS_FLOAT)) {
        log_error(host, "layout %s has no render target %u", fnl_gbuffer_name(frame->gbuffer), index);
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->debug == FNL_DEBUG_MATERIAL_ID && info.material_count == 0) {
        log_error(host, "layout %s has no material ID", fnl_gbuffer_name(frame->gbuffer));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

static fnl_result check_coarse(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    const fnl_coarse_options *coarse = &frame->coarse;
    REQUIRE(host, coarse->size == 1 || coarse->size == 2 || coarse->size == 4);
    REQUIRE(host, (uint32_t)coarse->criterion < FNL_COARSE_CRITERION_COUNT);
    REQUIRE(host, (uint32_t)coarse->split < FNL_COARSE_SPLIT_COUNT);
    REQUIRE(host, (uint32_t)coarse->filter < FNL_COARSE_FILTER_COUNT);
    REQUIRE(host, coarse->depth_factor >= 0 && isfinite(coarse->depth_factor));
    REQUIRE(host, coarse->normal_degrees >= 0 && coarse->normal_degrees <= 180);
    REQUIRE(host, coarse->tolerance >= 0 && coarse->tolerance <= 1 && coarse->albedo_tolerance >= 0 &&
                      coarse->albedo_tolerance <= 1);
    REQUIRE(host, coarse->ao_radius >= 0 && isfinite(coarse->ao_radius));
    REQUIRE(host, frame->shade_cost <= 100000);
    if (frame->shading == FNL_SHADING_COARSE && coarse->criterion == FNL_COARSE_CRITERION_ID &&
        !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which coarse.criterion id needs; use z");
        return FNL_ERROR_UNSUPPORTED;
    }
    bool view = frame->debug == FNL_DEBUG_COARSE || frame->debug == FNL_DEBUG_COARSE_REASON;
    if (view && frame->shading != FNL_SHADING_COARSE) {
        log_error(host, "the view %s shows the blocks of coarse shading, not of %s", fnl_debug_view_name(frame->debug),
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

static fnl_result check_geometry(const fnl_renderer *r, const fnl_frame *frame) {
    REQUIRE(&r->host, (uint32_t)frame->geometry < FNL_GEOMETRY_COUNT);
    if (frame->geometry != FNL_GEOMETRY_MESH) return FNL_OK;
    if (!gpu_info(r->device)->mesh_shader || r->no_meshes) {
        log_error(&r->host, "this device has no mesh shaders; use geometry vertex or auto");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->culling == FNL_CULLING_INSTANCES) {
        log_error(&r->host, "mesh shaders draw what culling by clusters or by triangles leaves, not that by instances");
        return FNL_ERROR_UNSUPPORTED;
    }
    return FNL_OK;
}

fnl_result frame_check(fnl_renderer *r, const fnl_frame *frame) {
    const fnl_host *host = &r->host;
    REQUIRE(host, frame->width >= 1 && frame->width <= 16384 && frame->height >= 1 && frame->height <= 16384);
    if (!camera_valid(&frame->camera)) {
        log_error(
            host,
            "the camera cannot be used: its numbers must be finite, position and target differ, near_distance be above 0, "
            "vertical_fov within 0 .. pi, or vertical_extent above 0 and far_distance above near_distance");
        return FNL_ERROR_INVALID;
    }
    REQUIRE(host, (uint32_t)frame->shading < FNL_SHADING_COUNT);
    REQUIRE(host, (uint32_t)frame->lists < FNL_LISTS_COUNT);
    TRY(lists_check(host, &frame->list_options));
    TRY(check_gbuffer(r, frame));
    REQUIRE(host, (uint32_t)frame->msaa_method < FNL_MSAA_METHOD_COUNT);
    REQUIRE(host, frame->msaa_groups == 2 || frame->msaa_groups == 3);
    REQUIRE(host, frame->msaa_tolerance >= 0 && frame->msaa_tolerance <= 1);
    REQUIRE(host, (uint32_t)frame->transparency < FNL_TRANSPARENCY_COUNT);
    REQUIRE(host, (uint32_t)frame->decals < FNL_DECALS_COUNT);
    REQUIRE(host, (uint32_t)frame->culling < FNL_CULLING_COUNT);
    TRY(check_geometry(r, frame));
    REQUIRE(host, (uint32_t)frame->aa < FNL_ANTIALIASING_COUNT);
    REQUIRE(host, fabsf(frame->jitter.x) <= 8 && fabsf(frame->jitter.y) <= 8);
    REQUIRE(host, (uint32_t)frame->tonemap < FNL_TONEMAP_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.layout < FNL_MOBILE_LAYOUT_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.gamma < FNL_MOBILE_GAMMA_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.light < FNL_MOBILE_LIGHT_COUNT);
    REQUIRE(host, (uint32_t)frame->mobile.lights < FNL_MOBILE_LIGHTS_COUNT);
    REQUIRE(host, frame->mobile.range > 0 && isfinite(frame->mobile.range));
    REQUIRE(host, (uint32_t)frame->visibility.sort < FNL_VISIBILITY_SORT_COUNT);
    REQUIRE(host, frame->atlas_size >= 256 && frame->atlas_size <= 8192 && frame->atlas_size % 256 == 0);
    REQUIRE(host, (uint32_t)frame->gradients < FNL_GRADIENTS_COUNT);
    REQUIRE(host, (uint32_t)frame->exposure <= FNL_EXPOSURE_NONE);
    REQUIRE(host, frame->exposure != FNL_EXPOSURE_EV || (frame->ev >= -64 && frame->ev <= 64));
    REQUIRE(host, (uint32_t)frame->debug < FNL_DEBUG_COUNT);
    TRY(check_gbuffer_view(r, frame));
    TRY(check_coarse(r, frame));
    REQUIRE(host, frame->outputs < 1u << OUTPUT_COUNT);
    REQUIRE(host, frame->light_lod >= 0 && isfinite(frame->light_lod));
    REQUIRE(host, frame->class_blocks == 0 || frame->class_blocks == 4 || frame->class_blocks == 8);
    REQUIRE(host, frame->msaa == 1 || frame->msaa == 2 || frame->msaa == 4 || frame->msaa == 8);
    if (!fnl_lists_supported(frame->shading, frame->lists)) {
        log_error(host, "%s lists do not go with %s shading", fnl_light_lists_name(frame->lists),
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (!fnl_msaa_supported(frame->shading) && frame->msaa > 1) {
        log_error(host, "%s shading has no MSAA; use another order, or 1 sample",
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    uint32_t counts = gpu_info(r->device)->msaa_counts;
    if (!(counts & frame->msaa)) {
        log_error(host, "this device cannot render with %u samples a pixel, but with 1%s%s%s", frame->msaa,
                  counts & 2 ? ", 2" : "", counts & 4 ? ", 4" : "", counts & 8 ? ", 8" : "");
        return FNL_ERROR_UNSUPPORTED;
    }
    bool texturing = frame->shading == FNL_SHADING_TEXTURING || frame->shading == FNL_SHADING_VIRTUAL_TEXTURING;
    if (texturing && frame->msaa > 1 &&
        !gpu_format_supports(r->device, VK_FORMAT_R16G16B16A16_UNORM, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT)) {
        log_error(host, "this device cannot draw to R16G16B16A16_UNORM, which %s shading with MSAA needs",
                  fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_DEFERRED && frame->msaa > 1 && frame->class_blocks) {
        log_error(host, "blocks of pixels cannot be classified with MSAA; use class_blocks 0 or 1 sample");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.grid &&
        (frame->msaa > 1 || frame->visibility.barycentrics || !visibility_grid_supported(r->device))) {
        log_error(host, "visibility.grid takes 1 sample a pixel, no visibility.barycentrics, and a device with 4 samples");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (frame->shading == FNL_SHADING_VISIBILITY && frame->visibility.barycentrics && frame->msaa > 1) {
        log_error(host, "visibility.barycentrics takes 1 sample a pixel, not %u", frame->msaa);
        return FNL_ERROR_UNSUPPORTED;
    }
    if ((frame->shading == FNL_SHADING_VISIBILITY || frame->shading == FNL_SHADING_DAIS) &&
        !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which %s shading needs", fnl_shading_name(frame->shading));
        return FNL_ERROR_UNSUPPORTED;
    }
    TRY(dais_check(r, frame));
    if (frame->debug == FNL_DEBUG_ATLAS || frame->debug == FNL_DEBUG_PAGES) {
        if (frame->shading != FNL_SHADING_VIRTUAL_TEXTURING) {
            log_error(host, "the view %s shows what virtual-texturing shading has", fnl_debug_view_name(frame->debug));
            return FNL_ERROR_UNSUPPORTED;
        }
        if (frame->debug == FNL_DEBUG_PAGES && frame->msaa > 1) {
            log_error(host, "the view pages takes 1 sample a pixel, not %u", frame->msaa);
            return FNL_ERROR_UNSUPPORTED;
        }
    }
    if (frame->debug == FNL_DEBUG_CLUSTERS && !gpu_info(r->device)->primitive_ids) {
        log_error(host, "this device cannot number triangles, which the view of clusters needs");
        return FNL_ERROR_UNSUPPORTED;
    }
    if (temporal_needs_motion(frame) && frame->msaa > 1) {
        log_error(host, "motion vectors and temporal antialiasing take one sample per pixel, not %u", frame->msaa);
        return FNL_ERROR_UNSUPPORTED;
    }
    return shading_supported(r, frame) ? FNL_OK : FNL_ERROR_UNSUPPORTED;
}
