/* SPDX-License-Identifier: MIT */
/**
 * What rays and pages of shadow maps cost on this device with this scene, for hybrid shadows. Knows nothing of the GPU: it is told the times and counts of frames, some
 * frames later. Pages are timed whenever enough of them are drawn. For rays some frames send a few more, whose time is known apart: the third, the sixth, then each 64th.
 * The first time of each does not count, as drivers compile things late.
 */
#ifndef FNL_RENDER_SHADOW_COSTS_H
#define FNL_RENDER_SHADOW_COSTS_H

#include <stdbool.h>
#include <stdint.h>

struct shadow_costs {
    double page, ray; /* milliseconds; 0: not known */
    uint32_t page_times, ray_times; /* that were told */
    uint32_t frames;  /* so far in which rays could have been timed */
};

struct shadow_times {
    double page_milliseconds;
    uint64_t pages;
    double ray_milliseconds;
    uint64_t rays;
};

/** Whether the next frame times rays. It adds one to `frames` once it is submitted. */
bool shadow_costs_probe(const struct shadow_costs *costs);
void shadow_costs_feed(struct shadow_costs *costs, struct shadow_times times);
/** How many rays take as long as a page. */
float shadow_costs_page_rays(const struct shadow_costs *costs, bool is_cpu);

#endif
