/* SPDX-License-Identifier: MIT */
/** Shadows by maps for some lights and by rays for others, whatever costs less. */
#include "passes/shadow/maps.h"
#include "render/shadows/maps.h"
#include "render/shadows/method.h"
#include "render/step.h"

/* passes/shadow/pages_shared.h */
struct hybrid_counts {
    struct gpu_shadow_split_counts split;
};
static const struct counter_table counters_hybrid;

float shadow_hybrid_page_rays(const fnl_renderer *r, const fnl_frame *frame) {
    if (frame->shadow.page_rays > 0) return frame->shadow.page_rays;
    return shadow_costs_page_rays(&r->shadows.costs, gpu_info(r->device)->type == FNL_DEVICE_CPU);
}

static bool timed(const fnl_frame *frame) { return shadows_have(frame, SHADOWS_SPLIT) && !(frame->shadow.page_rays > 0) && !frame->count_lights; }

static bool may_probe(const fnl_frame *frame) { return frame->msaa == 1 && timed(frame); }

/* What the next frames decide by. */
void shadow_hybrid_add(struct frame_state *f, const struct shadow_pages *pages, const struct shadow_fill *filled, const struct lighting *surfaces, graph_image depth) {
    const struct shadow_costs *costs = &f->r->shadows.costs;
    shadow_drawn_add(f->graph, pages, filled);
    const bool asks = frame_is_dry(f); /* a later frame will need the pipeline */
    if (f->view_index == 0 && may_probe(f->frame) && (asks || shadow_costs_probe(costs))) shadow_probe_add(f->graph, pages, surfaces, depth, costs->frames);
    COUNTERS_COPY(f, pages->split_counts, 0, hybrid, split);
    counters_note(f, "shadows.page-rays", (uint64_t)lroundf(shadow_hybrid_page_rays(f->r, f->frame)));
}

static void counted(fnl_renderer *r, uint32_t slot) {
    r->shadows.counted.frame = r->shadows.counted.drawn = 0;
    if (r->slots.views[slot] == 0) return;
    const struct gpu_shadow_split_counts *split = &COUNTS(renderer_counts(r, slot, 0), hybrid)->split;
    if (split->maps + split->rays == 0) return;
    r->shadows.counted.frame = r->slots.frames[slot];
    r->shadows.counted.probed = split->probed;
    for (uint32_t i = 0; i < r->slots.views[slot]; i++) r->shadows.counted.drawn += COUNTS(renderer_counts(r, slot, i), shadow_maps)->pages.drawn;
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    if (may_probe(frame)) r->shadows.costs.frames++;
    const struct graph_timer *timers;
    uint32_t count;
    if (r->shadows.counted.frame == 0 || !graph_query_timers(r->graph, r->shadows.counted.frame, &timers, &count)) return;
    double fill = 0, probe = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (timers[i].role == GRAPH_ROLE_SHADOW_FILL) fill += timers[i].milliseconds;
        if (timers[i].role == GRAPH_ROLE_SHADOW_PROBE) probe += timers[i].milliseconds;
    }
    shadow_costs_feed(&r->shadows.costs, (struct shadow_times){fill, r->shadows.counted.drawn, probe, r->shadows.counted.probed});
}

#define SPLIT(key, unit, help, member) {"shadows." key, unit, help, COUNTED(hybrid, split.member), .needs = "shadows=hybrid"}
static const struct counter rows[] = {
    SPLIT("by-maps", "lights", "hybrid: local lights that pixels look up in maps", maps),
    SPLIT("by-rays", "lights", "hybrid: local lights with shadow rays, because rays cost less", rays),
    SPLIT("reached", "pixels", "hybrid: sum over these lights of the pixels in reach: the most rays they can need", reached),
    SPLIT("switched", "lights", "hybrid: lights that went from maps to rays or back in this frame", switched),
    {"shadows.page-rays", "rays", "hybrid: how many take as long as drawing a page, given or measured", NOTED, .needs = "shadows=hybrid"},
};
static const struct counter_table counters_hybrid = COUNTER_TABLE_COUNTED(rows, hybrid);

const struct shadow_method shadow_method_hybrid = {.traits = SHADOWS_MAPS | SHADOWS_RAYS | SHADOWS_SPLIT | SHADOWS_EXACT,
                                                   .captured_as = FNL_SHADOWS_MAPS,
                                                   .timed = timed,
                                                   .counted = counted,
                                                   .submitted = submitted,
                                                   .prepare_view = shadow_maps_prepare_view,
                                                   .add = shadow_maps_add,
                                                   .counters = &counters_hybrid};
