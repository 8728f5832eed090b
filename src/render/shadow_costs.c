/* SPDX-License-Identifier: MIT */
#include "render/shadow_costs.h"

enum {
    FIRST_PROBE = 3,
    PROBE_EVERY = 64,
    FEW_PAGES = 16, /* the time of fewer is mostly that of starting to draw at all */
    FEW_RAYS = 64,
};
#define GPU_PAGE_RAYS 1024.0f
#define CPU_PAGE_RAYS 64.0f

bool shadow_costs_probe(const struct shadow_costs *costs) {
    const uint32_t next = costs->frames + 1;
    return next == FIRST_PROBE || next == 2 * FIRST_PROBE || next % PROBE_EVERY == 0;
}

/* A quarter of what is new: single frames may be far off. */
static void learn(double *known, uint32_t *times, double milliseconds, uint64_t count, uint64_t few) {
    if (count < few || !(milliseconds > 0) || (*times)++ == 0) return;
    const double found = milliseconds / (double)count;
    *known = *known > 0 ? *known + (found - *known) / 4 : found;
}

void shadow_costs_feed(struct shadow_costs *costs, struct shadow_times times) {
    learn(&costs->page, &costs->page_times, times.page_milliseconds, times.pages, FEW_PAGES);
    learn(&costs->ray, &costs->ray_times, times.ray_milliseconds, times.rays, FEW_RAYS);
}

float shadow_costs_page_rays(const struct shadow_costs *costs, bool is_cpu) {
    if (!(costs->page > 0) || !(costs->ray > 0)) return is_cpu ? CPU_PAGE_RAYS : GPU_PAGE_RAYS;
    const double rays = costs->page / costs->ray;
    return (float)(rays < 1 ? 1 : rays > 1e6 ? 1e6 : rays);
}
