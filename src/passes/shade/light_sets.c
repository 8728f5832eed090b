/* SPDX-License-Identifier: MIT */
#include "passes/shade/light_sets.h"

/* Pixels look for lights a little beyond their radius (light_indexed.frag.glsl). Where two of a set meet all the same, the pixel notices. */
static bool overlap(const struct gpu_entity_bounds *a, const struct gpu_entity_bounds *b) {
    const vec3 between = vec3_sub(a->center, b->center);
    const float reach = (a->radius + b->radius) * 1.002f + 2e-3f;
    return !(vec3_dot(between, between) > reach * reach); /* NaN overlaps everything */
}

static bool is_seen(const struct light_sets_input *input, const struct gpu_entity_bounds *light) {
    for (uint32_t i = 0; i < input->plane_count; i++) {
        const vec4 p = input->planes[i];
        if (p.x * light->center.x + p.y * light->center.y + p.z * light->center.z + p.w < -light->radius) return false;
    }
    return true;
}

uint32_t light_sets_find(const struct light_sets_input *input, uint32_t *codes, uint32_t *members) {
    uint32_t sizes[INDEXED_SETS] = {0}, without = 0;
    for (uint32_t i = 0; i < input->count; i++) {
        const struct gpu_entity_bounds *light = &input->bounds[i];
        codes[i] = 0;
        if (!(light->radius > 0) || !is_seen(input, light)) continue;
        for (uint32_t set = 0; set < input->set_count && codes[i] == 0; set++) {
            uint32_t place = 1;
            while (place <= sizes[set] && !overlap(light, &input->bounds[members[set << 8 | place]])) place++;
            if (place > INDEXED_BATCH || place <= sizes[set]) continue;
            sizes[set] = place;
            members[set << 8 | place] = i;
            codes[i] = set << 8 | place;
        }
        without += codes[i] == 0;
    }
    return without;
}
