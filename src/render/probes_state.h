/* SPDX-License-Identifier: MIT */
/** The renderer's state for cubemap shadows (probes.h). */
#ifndef FNL_RENDER_PROBES_STATE_H
#define FNL_RENDER_PROBES_STATE_H

#include "passes/shadow/cubemap.h"
#include "render/device/scene.h"

/** One of a renderer. */
struct renderer_probe {
    fnl_probe_params params;
    struct gpu_image image;
    uint64_t key; /* of what the image shows; 0: nothing */
};

struct renderer_probes {
    ARRAY(struct renderer_probe) list; /* those that cast shadows, PROBES_MOST at most */
    ARRAY(uint32_t) mover_generations; /* by node: the generation of one that has moved since it was first seen; 0: it has not */
    ARRAY(uint32_t) known_generations; /* by node: when transforms were last looked at */
    struct device_array moving;        /* a bit for each draw item */
    uint64_t structure, transforms, mover_version, sent_movers; /* what is known: versions of the scene's structure and of its transforms */
    bool moves;                        /* some item does */
    bool told;                         /* the log knows that there is no probe, or that there are too many */
    bool started;
};

#endif
