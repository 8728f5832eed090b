/* SPDX-License-Identifier: MIT */
/** Lights sorted into sets whose members do not overlap, so that a pixel needs room for one light of each set (light_indexed.h). */
#ifndef FNL_PASSES_LIGHT_SETS_H
#define FNL_PASSES_LIGHT_SETS_H

#include "base/maths.h"
#include "lights/lights_shared.h"
#include "passes/shade/light_indexed_shared.h"

struct light_sets_input {
    const struct gpu_entity_bounds *bounds; /* what has a radius <= 0 needs no set */
    uint32_t count;
    const vec4 *planes;   /* bounds wholly outside one of them need no set (inside: dot(plane, (p, 1)) >= 0); NULL: none */
    uint32_t plane_count;
    uint32_t set_count;   /* 1 .. INDEXED_SETS */
};
/**
 * Gives each light, in order, the first set that has room and no member that it overlaps. `codes[i]`: set << 8 | place, places from 1 to INDEXED_BATCH; 0: none.
 * `members[set << 8 | place]`: the light. Returns how many lights that need a set have none. Cost: a test of each light with the members of the sets before its own.
 */
uint32_t light_sets_find(const struct light_sets_input *input, uint32_t *codes, uint32_t *members);

#endif
