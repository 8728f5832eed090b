/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "passes/dais/dais.h"

_Static_assert(FNL_DEBUG_DAIS_TRIANGLES - FNL_DEBUG_DAIS_ADDRESSES == DAIS_VIEW_TRIANGLES &&
                   FNL_DEBUG_DAIS_FAILURES - FNL_DEBUG_DAIS_ADDRESSES == DAIS_VIEW_FAILURES,
               "dais_shared.h has the order of fnl_debug_view");

static struct dais_params params_of(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_device_info *info = gpu_info(r->device);
    const struct renderer_tests tests = renderer_tests(r);
    return (struct dais_params){.lists = frame->dais.mode == FNL_DAIS_LIST,
                                .shared_samples = frame->dais.multirate,
                                .each_sample = frame->msaa > 1 && (!info->post_depth_coverage || tests.dais_plain),
                                .quads = info->quad_operations && !tests.dais_plain,
                                .buckets = frame->dais.cache_buckets,
                                .capacity = MAX(r->dais_capacity, 64u),
                                .node_capacity = MAX(r->dais_node_capacity, 2u),
                                .probe = tests.dais_probe,
                                .attempts = tests.dais_impatient ? 0 : DAIS_ATTEMPTS};
}

static fnl_result check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->msaa > 1 && frame->dais.mode == FNL_DAIS_TARGET && !dais_target_supported(r->device, frame->msaa))
        return unsupported(
            call, "this device has no integer targets of %u samples for dais shading; lists (fnl_dais_options) need none",
            frame->msaa);
    return order_check_primitive_ids(call, r, frame);
}

static void add(struct frame_state *f, struct shade_input *input, bool prepass) {
    UNUSED(prepass); /* always */
    struct dais_params params = params_of(f->r, f->frame);
    struct dais dais = dais_add(f->graph, input, &params, f->depth);
    order_add_lists(f, f->depth, NULL);
    dais_shade_add(f->graph, input, &dais, f->radiance);
    f->dais = dais;
    f->r->dais_bytes = dais.fixed_bytes;
}

static void query(const fnl_renderer *r, const struct frame_counts *frame_counts, fnl_frame_stats *stats) {
    const uint32_t *counts = frame_counts->dais;
    struct fnl_dais_stats *out = &stats->dais;
    bool lists = r->frame.dais.mode == FNL_DAIS_LIST;
    out->triangles = counts[DAIS_STORED];
    out->unique = counts[DAIS_UNIQUE];
    out->cache_failures = counts[DAIS_FAILED];
    out->overflow = counts[DAIS_OVERFLOW];
    out->list_elements = counts[DAIS_NODES];
    out->shading_samples = counts[DAIS_SAMPLES];
    out->shaded = counts[DAIS_SHADED];
    out->bytes = r->dais_bytes + counts[DAIS_WORDS] * 4ull + counts[DAIS_STORED] * 4ull +
                 (lists ? counts[DAIS_NODES] * (uint64_t)DAIS_NODE * 4 : 0) + counts[DAIS_SAMPLES] * 8ull;
}

static void add_view(struct frame_state *f, bool swap) {
    const struct shade_input input = {.scene = &f->scene->geometry, .view = f->view_address};
    dais_view_add(f->graph, &input, &f->dais, (uint32_t)(f->frame->debug - FNL_DEBUG_DAIS_ADDRESSES), f->color, swap);
}

static const struct debug_view views[] = {
    {FNL_DEBUG_DAIS_ADDRESSES, .add = add_view},
    {FNL_DEBUG_DAIS_TRIANGLES, .add = add_view},
    {FNL_DEBUG_DAIS_FAILURES, .add = add_view},
};

const struct order order_dais = {.traits = SHADING_VIEWS | SHADING_FULL_RASTER | SHADING_ITEMS | SHADING_PREPASS | SHADING_REDRAW | SHADING_SAMPLES |
                                           SHADING_APPROXIMATE,
                                 .check = check,
                                 .add = add,
                                 .views = views,
                                 .view_count = COUNT_OF(views),
                                 .query = query};
