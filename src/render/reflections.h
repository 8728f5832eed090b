/* SPDX-License-Identifier: MIT */
/**
 * Reflection probes (docs/techniques/reflection-probes.md). Each renderer keeps what they have seen. A probe is captured by frames of six views that a
 * renderer of its own makes before the frame that shows it; its maps are made as those of an environment are. Boxes ride in exact lists of each view.
 */
#ifndef FNL_RENDER_REFLECTIONS_H
#define FNL_RENDER_REFLECTIONS_H

#include "fanal/renderer.h"
#include "passes/lights/light_list.h"
#include "render/device/scene.h"
#include "reflections_shared.h"

struct frame_state;
struct fnl_renderer;

/** One of a renderer. */
struct renderer_reflection {
    fnl_probe_params params;
    uint32_t slot;     /* of the scene */
    uint64_t version;  /* of the scene's probe */
    struct environment_maps maps;
    bool is_due, is_captured; /* is_captured: the maps hold something */
};

struct renderer_reflections {
    ARRAY(struct renderer_reflection) list; /* highest priority first, then as in the scene */
    uint64_t version;                       /* of the scene's probes, which `list` is of */
    struct device_array probes, bounds;     /* struct gpu_reflection, gpu_entity_bounds */
    struct gpu_buffer diffuse;              /* struct gpu_environment of each */
    bool gathered;                          /* `diffuse` holds that of all maps, in the order of `list` */
    struct fnl_renderer *capturer;          /* NULL: none is needed */
    uint32_t turn;                          /* the next of those that are captured again and again */
    uint32_t captures;                      /* of the last frame */
};

/** Before a frame is made: captures what is due. Not inside of a frame. */
fnl_result reflections_capture(struct fnl_renderer *r, const fnl_frame *frame);
/** Outside of frames: sends what shaders look up. */
fnl_result reflections_prepare(struct fnl_renderer *r);
/** Makes the place of the view's set known to it; before the view is sent. */
fnl_result reflections_begin(struct frame_state *f);
/** The list over the boxes, and what passes that shade use. After the view was sent, before anything is drawn. */
void reflections_add_list(struct frame_state *f);
/** In a frame that captures: what the view has seen becomes a face. */
void reflections_take_face(struct frame_state *f);
/** After a frame that failed: what was to be kept may never have reached the device. */
void reflections_forget(struct fnl_renderer *r);
/** The device is idle. */
void reflections_finish(struct fnl_renderer *r);
/** The counters of a view. */
void reflections_note(struct frame_state *f);

extern const struct counter_table reflections_counters;

#endif
