/* SPDX-License-Identifier: MIT */
#include "render/orders/order.h"

#include "render/debug_views.h"
#include "render/shading.h"

#include "passes/dais/dais.h"
#include "passes/debug/colors_shared.h"

_Static_assert(FNL_DEBUG_DAIS_TRIANGLES - FNL_DEBUG_DAIS_ADDRESSES == DAIS_VIEW_TRIANGLES &&
                   FNL_DEBUG_DAIS_FAILURES - FNL_DEBUG_DAIS_ADDRESSES == DAIS_VIEW_FAILURES,
               "dais_shared.h has the order of fnl_debug_view");

/* passes/dais/dais_shared.h */
struct dais_counts {
    uint32_t words[DAIS_COUNTS];
};
static const struct counter_table counters_dais;

static struct dais_params params_of(const fnl_renderer *r, const fnl_frame *frame) {
    const fnl_device_info *info = gpu_info(r->device);
    const struct renderer_tests tests = renderer_tests(r);
    return (struct dais_params){.lists = frame->dais.mode == FNL_DAIS_LIST,
                                .shared_samples = frame->dais.multirate,
                                .each_sample = frame->msaa > 1 && (!info->post_depth_coverage || tests.dais_plain),
                                .quads = info->quad_operations && !tests.dais_plain,
                                .buckets = frame->dais.cache_buckets,
                                .capacity = MAX(r->shading.dais_capacity, 64u),
                                .node_capacity = MAX(r->shading.dais_node_capacity, 2u),
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
    f->stored.dais = dais;
    COUNTERS_COPY(f, dais.counts, 0, dais, words);
    counters_note(f, "dais.bytes", dais.fixed_bytes);
}

static void add_view(struct frame_state *f, bool swap) {
    const struct shade_input input = {.scene = &f->scene->geometry, .view = f->view_address};
    dais_view_add(f->graph, &input, &f->stored.dais, (uint32_t)(f->frame->debug - FNL_DEBUG_DAIS_ADDRESSES), f->color, swap);
}

static const struct debug_legend_color no_room[] = {{{1, 1, 1}, "no room"}};
static const struct debug_legend_color triangles[] = {{DEBUG_DAIS_1(LEGEND_COLOR), "1"},
                                                      {DEBUG_DAIS_2(LEGEND_COLOR), "2"},
                                                      {DEBUG_DAIS_3(LEGEND_COLOR), "3"},
                                                      {DEBUG_DAIS_4(LEGEND_COLOR), "4 and more"}};

static const struct debug_view views[] = {
    {FNL_DEBUG_DAIS_ADDRESSES, LEGEND_COLORS("each stored triangle in a colour of its own", no_room), .add = add_view},
    {FNL_DEBUG_DAIS_TRIANGLES, LEGEND_COLORS("different triangles in the pixel", triangles), .add = add_view},
    {FNL_DEBUG_DAIS_FAILURES, LEGEND_TEXT("red: a triangle that was stored again, because its bucket of the cache stayed locked"), .add = add_view},
};

/* Noted is what does not depend on the picture. */
static bool find_bytes(const struct counted *counted, uint64_t *value) {
    const uint32_t *counts = COUNTS(counted->counts, dais)->words;
    bool lists = counted->r->frame.dais.mode == FNL_DAIS_LIST;
    *value += counts[DAIS_WORDS] * 4ull + counts[DAIS_STORED] * 4ull +
              (lists ? counts[DAIS_NODES] * (uint64_t)DAIS_NODE * 4 : 0) + counts[DAIS_SAMPLES] * 8ull;
    return COUNTED_HAS(counted, dais, words);
}

static const struct counter rows[] = {
    {"dais.bytes", "bytes", "memory that references, triangles, cache and lists fill", .find = find_bytes},
    {"dais.triangles", "triangles", "triangles stored, including those that the cache had forgotten",
     COUNTED(dais, words[DAIS_STORED])},
    {"dais.unique", "triangles", "different triangles among those stored", COUNTED(dais, words[DAIS_UNIQUE]),
     .needs = "count-lights"},
    {"dais.cache-failures", "triangles", "triangles stored again because a cache bucket stayed locked",
     COUNTED(dais, words[DAIS_FAILED])},
    {"dais.overflow", "fragments", "fragments that found a pool full: the frame was shaded forward",
     COUNTED(dais, words[DAIS_OVERFLOW]), .kind = FNL_COUNTER_OVERFLOW},
    {"dais.list-elements", "", "triangles that cover only part of their pixel", COUNTED(dais, words[DAIS_NODES]),
     .needs = "dais.mode=list"},
    {"dais.shading-samples", "", "places where ambient light was computed", COUNTED(dais, words[DAIS_SAMPLES]),
     .needs = "dais.multirate"},
    {"dais.shaded", "triangles", "triangles shaded: each once in every pixel that shows it", COUNTED(dais, words[DAIS_SHADED]),
     .needs = "count-lights"},
};
static const struct counter_table counters_dais = COUNTER_TABLE_COUNTED(rows, dais);

enum {
    POOL_START = 1 << 20, /* words of triangles */
    POOL_LIMIT = 1 << 30, /* references have 31 bits */
    NODE_START = 1 << 14
};

static void init(fnl_renderer *r) {
    r->shading.dais_capacity = POOL_START;
    r->shading.dais_node_capacity = NODE_START;
}

static void grow(fnl_renderer *r, const struct frame_counts *counts) {
    const uint32_t *words = COUNTS(counts, dais)->words;
    const uint64_t limit = gpu_info(r->device)->memory_bytes / 8 / 4, nodes = words[DAIS_NODES] + 2ull;
    if (words[DAIS_OVERFLOW] == 0) return;
    /* How much more the others want is not known: those that find no room take none. */
    if (words[DAIS_WORDS] + DAIS_RECORD_MAX > r->shading.dais_capacity)
        r->shading.dais_capacity = (uint32_t)MIN(MAX(2ull * r->shading.dais_capacity, (uint64_t)POOL_START), MIN(limit, POOL_LIMIT));
    if (nodes > r->shading.dais_node_capacity) r->shading.dais_node_capacity = (uint32_t)MIN(nodes + nodes / 4, MIN(limit, POOL_LIMIT) / 4);
}

const struct order order_dais = {.traits = SHADING_LAYERS | SHADING_VIEWS | SHADING_FULL_RASTER | SHADING_ITEMS | SHADING_PREPASS | SHADING_REDRAW |
                                           SHADING_SAMPLES | SHADING_APPROXIMATE,
                                 .init = init,
                                 .check = check,
                                 .grow = grow,
                                 .add = add,
                                 .views = views,
                                 .view_count = COUNT_OF(views),
                                 .counters = &counters_dais};
