/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/texturing/texturing.h"
#include "passes/texturing/virtual_view_shared.h"

/* What the GPU counts. */
struct virtual_counts {
    struct gpu_virtual_counts pages;
};
static const struct counter_table counters_virtual;

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->msaa > 1 &&
        !gpu_format_supports(r->device, VK_FORMAT_R16G16B16A16_UNORM, VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT))
        return unsupported(call, "this device cannot draw to R16G16B16A16_UNORM, which %s shading with MSAA needs",
                           fnl_value_name(FNL_ENUM_SHADING, frame->shading));
    return FNL_OK;
}

static void shade(struct frame_state *f, struct shade_input *input, const struct texturing *texturing) {
    counters_note(f, "gbuffer.bytes", (uint64_t)texturing->bytes * f->frame->width * f->frame->height);
    order_add_lists(f, f->depth, NULL);
    struct visible_list surfaces = texturing_shade_add(f->graph, input, texturing, f->radiance);
    f->stored.surfaces = surfaces.words;
    COUNTERS_COPY(f, surfaces.counts, 0, shading, edges);
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    bool derived = f->frame->texturing.gradients == FNL_GRADIENTS_DERIVED;
    struct texturing texturing = texturing_add(f->graph, input, derived, prepass, f->depth);
    shade(f, input, &texturing);
}

/* ---- virtual ---- */

static fnl_result prepare_virtual(fnl_renderer *r, const fnl_frame *frame) {
    return device_virtual_prepare(r->device_scene, frame->texturing.atlas_size, &r->shading.atlas);
}

static void forget_virtual(fnl_renderer *r) { r->shading.atlas.version = UINT64_MAX; }
static void submitted_virtual(fnl_renderer *r) { r->shading.atlas.fresh = false; }
static void destroy_virtual(fnl_renderer *r) { virtual_destroy(r->device, &r->shading.atlas); }

/* The first frame draws the geometry once more, to know which pages it wants; later ones have what the frame before wanted. */
static void add_virtual(struct frame_state *f, struct shade_input *input, bool prepass) {
    const fnl_renderer *r = f->r;
    struct virtual_frame pages = virtual_begin(f->graph, r->device, &r->shading.atlas, r->device_scene->materials.buffer.address);
    if (r->shading.atlas.fresh) texturing_virtual_add(f->graph, input, &pages, "texturing wanted", prepass, f->depth);
    virtual_update_add(f->graph, &pages);
    COUNTERS_COPY(f, pages.commands, 16, virtual, pages); /* behind a dispatch */
    counters_note(f, "atlas.pages", r->shading.atlas.page_count);
    counters_note(f, "atlas.capacity", r->shading.atlas.across * r->shading.atlas.across);
    counters_note(f, "atlas.bytes", r->shading.atlas.bytes);
    struct texturing texturing = texturing_virtual_add(f->graph, input, &pages, "texturing", prepass, f->depth);
    texturing.shows_levels = renderer_tests(r).show_levels;
    f->stored.texturing = texturing;
    shade(f, input, &texturing);
    texturing_forward_add(f->graph, input, f->radiance, f->depth);
    f->forward_layouts = 1u << VIRTUAL_FORWARD;
    f->calls.opaque = (r->shading.atlas.fresh ? 2 : 1) * f->calls.opaque + geometry_draw_count(input->scene, GEOMETRY_NOT_IN(VIRTUAL_FORWARD));
}

static void add_atlas(struct frame_state *f, bool swap) {
    uint32_t mode = f->frame->debug == FNL_DEBUG_ATLAS ? VIRTUAL_VIEW_ATLAS : VIRTUAL_VIEW_PAGES;
    virtual_view_add(f->graph, &f->stored.texturing.pages, mode, f->stored.texturing.targets[1], f->depth, f->view_address, f->color, swap);
}

static fnl_result check_pages(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(r);
    if (frame->msaa == 1) return FNL_OK;
    return unsupported(call, "the debug view pages needs 1 sample per pixel, not %u", frame->msaa);
}

static const struct debug_legend_color stripes[] = {{{1, 0, 1}, "stripes: a finer page is wanted"}};
static const struct debug_view virtual_views[] = {
    {FNL_DEBUG_ATLAS, LEGEND_TEXT("base colours in the atlas; hatched: empty"), .add = add_atlas},
    {FNL_DEBUG_PAGES, LEGEND_COLORS("each page in a colour of its own, darker where it is coarser; grey: lit forward", stripes), .add = add_atlas, .check = check_pages},
};

static const struct counter virtual_counters[] = {
    {"atlas.pages", "pages", "pages of all materials of the scene", NOTED},
    {"atlas.capacity", "pages", "pages that fit into the atlas", NOTED},
    {"atlas.wanted", "pages", "pages that the last frame wanted", COUNTED(virtual, pages.wanted)},
    {"atlas.resident", "pages", "pages in the atlas", COUNTED(virtual, pages.resident)},
    {"atlas.filled", "pages", "pages filled for this frame", COUNTED(virtual, pages.filled)},
    {"atlas.missing", "pages", "wanted pages that found no room in the atlas", COUNTED(virtual, pages.missing)},
    {"atlas.evicted", "pages", "pages replaced by others", COUNTED(virtual, pages.evicted)},
    {"atlas.bytes", "bytes", "memory of the atlas", NOTED},
};
static const struct counter_table counters_virtual = COUNTER_TABLE_COUNTED(virtual_counters, virtual);

/* Approximate as visibility is, and because normals are rounded. */
enum { TRAITS = SHADING_FULL_RASTER | SHADING_MAY_PREPASS | SHADING_APPROXIMATE | SHADING_SAMPLES };
const struct order order_texturing = {.traits = TRAITS | SHADING_LAYERS | SHADING_POSITIONS | SHADING_VIEWS, .check = check, .add = add};
/* One view: a frame brings the pages of one camera into the atlas. */
const struct order order_virtual_texturing = {.traits = TRAITS | SHADING_LAYERS,
                                              .check = check,
                                              .prepare = prepare_virtual,
                                              .add = add_virtual,
                                              .views = virtual_views,
                                              .view_count = COUNT_OF(virtual_views),
                                              .counters = &counters_virtual,
                                              .init = forget_virtual,
                                              .forget = forget_virtual,
                                              .destroy = destroy_virtual,
                                              .submitted = submitted_virtual};
