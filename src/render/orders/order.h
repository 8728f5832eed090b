/* SPDX-License-Identifier: MIT */
/**
 * A shading order: a file in this folder that ends in its row, or in several rows if the orders share most of their code. ORDERS lists the
 * rows; shading.c calls each only for frames of its own order.
 */
#ifndef FNL_RENDER_ORDER_H
#define FNL_RENDER_ORDER_H

#include "passes/shade/volumes.h"
#include "render/frame_state.h"
#include "render/traits.h"

struct debug_view;

struct order {
    uint32_t traits; /* enum shading_trait, whatever the options */
    /* Adds or removes traits according to the frame's options. This and everything below except `add` is optional. */
    uint32_t (*adjust)(const fnl_frame *frame, uint32_t traits);
    /* Fails, with a log line, where options do not go together or the device cannot do what they ask for. */
    fnl_result (*check)(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
    /* Before the frame begins: what lasts longer than it. */
    fnl_result (*prepare)(fnl_renderer *r, const fnl_frame *frame);
    /* Fills in its part of f->shared, before that is sent. */
    void (*begin)(struct frame_state *f);
    /* Draws what needs no lists, after the prepass if there is one: with SHADING_MULTIVIEW for several views at once, where f->draws says so. What it
       makes goes into members of f that shading_take_layer() handles. */
    void (*draw)(struct frame_state *f, struct shade_input *input, bool prepass);
    /* Declares lists and opaque surfaces and fills f->radiance; f->depth is complete with `prepass`. `input` is a copy that it may change. */
    void (*add)(struct frame_state *f, struct shade_input *input, bool prepass);
    /* The debug views that only orders which have them offer. */
    const struct debug_view *views;
    uint32_t view_count;
    /* Its own numbers; those that several orders have are in shading.c. */
    const struct counter_table *counters;
    /* As in struct frame_step, but `submitted` follows only frames of this path. */
    void (*init)(fnl_renderer *r);
    void (*submitted)(fnl_renderer *r);
    void (*forget)(fnl_renderer *r);
    void (*grow)(fnl_renderer *r, const struct frame_counts *counts);
    void (*destroy)(fnl_renderer *r);
};

/** All orders: FNL_SHADING_… and the row order_…. */
#define ORDERS(ROW)                                                                                                         \
    ROW(FORWARD, forward) ROW(FORWARD_PREPASS, forward_prepass) ROW(DEFERRED, deferred)                                     \
    ROW(DEFERRED_VOLUMES, deferred_volumes) ROW(LIGHT_PREPASS, light_prepass) ROW(PRE_LIGHTING, pre_lighting)               \
    ROW(LOW_RES, low_res) ROW(INFERRED, inferred) ROW(LIGHT_INDEXED, light_indexed) ROW(ZIOMA, zioma)                       \
    ROW(VISIBILITY, visibility) ROW(TEXTURING, texturing) ROW(VIRTUAL_TEXTURING, virtual_texturing)                         \
    ROW(COARSE, coarse) ROW(DAIS, dais) ROW(MOBILE, mobile)
#define DECLARE_ORDER(value, name) extern const struct order order_##name;
ORDERS(DECLARE_ORDER)

/** The row of an order; not of auto. */
const struct order *shading_order(fnl_shading shading);

/* ---- what they share ---- */

/**
 * Makes the frame's lists, which may read `depth` (id 0: none yet) and `gbuffer` (or NULL). Passes before the lists have the role geometry, passes after
 * them the role shading (graph_role).
 */
void order_add_lists(struct frame_state *f, graph_image depth, const struct gbuffer *gbuffer);
/** Makes additional lists, for pixels that the frame's lists do not serve. Their passes get the role that is current at the call. */
struct lighting order_add_fallback_lists(struct frame_state *f);
/** Makes tiles beside them for all that `depth` shows. */
struct light_list order_add_surface_lists(struct frame_state *f, graph_image depth);
/** The view's lighting without lists: by all lights, or by the directional ones. */
struct lighting order_light_by_all(struct frame_state *f);
struct lighting order_light_by_suns(struct frame_state *f);
/** Notes as gbuffer.bytes the size of f->stored.gbuffer plus `extra_bytes` for each pixel. */
void order_note_gbuffer(struct frame_state *f, uint32_t extra_bytes);
/** The volumes of the local lights, in a shape of volumes_shared.h; with VOLUME_SCREEN, `batch` lights per draw. */
struct volumes order_prepare_volumes(struct frame_state *f, uint32_t shape, uint32_t batch);
/** The lights in view are those whose volumes are drawn, where no lists count them. */
void order_count_volumes(struct frame_state *f, const struct volumes *volumes);
/** Fails with a log line unless the device numbers triangles. */
fnl_result order_check_primitive_ids(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);

#endif
