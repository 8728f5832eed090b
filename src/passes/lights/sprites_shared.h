/* SPDX-License-Identifier: MIT */
#ifndef FNL_PASSES_SPRITES_SHARED_H
#define FNL_PASSES_SPRITES_SHARED_H

#include "shared.h"
#include "lighting/lighting_shared.h"

/* Part of the light that the surfaces round it are taken to reflect. */
#define SPRITE_ALBEDO 0.3

struct gpu_sprites_push {
    ADDRESS(view_block) view;
    ADDRESS(light_array) lights;
    ADDRESS(entity_array) bounds; /* of the local ones */
    ADDRESS(light_array) faded;  /* fade: where the copies go */
    ADDRESS(entity_array) faded_bounds;
    uint directional_count;
    uint local_count;
    float lod;                   /* pixels */
};

#endif
