/* SPDX-License-Identifier: MIT */
/** The shading orders: how each turns the opaque geometry into radiance, and what it goes with. One row per order in shading.c. */
#ifndef FNL_RENDER_SHADING_H
#define FNL_RENDER_SHADING_H

#include "render/frame_state.h"

enum shading_trait {
    SHADING_FORWARD = 1,       /* shades while it draws: pixels may have several samples */
    SHADING_GBUFFER = 2,       /* shades what a G-buffer holds: lists may look at depth and normals */
    SHADING_PREPASS = 4,       /* draws depth first, always */
    SHADING_BLENDS = 8,        /* adds lights up by blending into the radiance target */
    SHADING_POSITIONS = 16,    /* looks lights up at positions rebuilt from depth, as lists made from depth do */
    SHADING_SAMPLES = 32,      /* pixels may have several samples */
    SHADING_LAYOUTS = 64,      /* heeds fnl_frame.gbuffer, normals and chroma */
    SHADING_REDRAW = 128,      /* draws the geometry a second time for its materials */
    SHADING_APPROXIMATE = 256, /* gives a picture that is close to that of the others, not equal */
    SHADING_ITEMS = 512,       /* knows the item that a pixel shows: lists of objects serve it */
    SHADING_FULL_RASTER = 2048, /* draws all geometry in the frame's own pixels: culling may leave out what their samples do not see */
    SHADING_VOLUMES = 1024      /* finds the lights of opaque surfaces by drawing volumes: lists serve blended ones alone */
};
/** Whether an order (not auto) has all of these traits. */
bool shading_is(fnl_shading shading, uint32_t traits);

/** Whether the frame draws the depth of the opaque set first. */
bool shading_has_prepass(const fnl_frame *frame);
/** Whether opaque surfaces find their lights by volumes. */
bool shading_draws_volumes(const fnl_frame *frame);
/** Whether the debug view of lights shows counts of this very frame's volumes. */
bool shading_shows_volumes(const fnl_frame *frame);
/** The format of the radiance target. */
VkFormat shading_format(const struct frame_state *f);

/** Sets light_scale and light_max of f->view. */
void shading_scale_light(struct frame_state *f);
/** Fails with a log line unless the frame's options of dais are in range and the device can do what they ask for. */
fnl_result dais_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame);
/** From counters (DAIS_COUNTS words) of the last frame to its stats. */
void dais_query(const fnl_renderer *r, const uint32_t *counts, struct fnl_dais_stats *out);
/** Fails with a log line unless the device has formats for mobile shading, where the frame asks for it. */
fnl_result mobile_check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);

/** Declares everything between culling and the picture: lists, opaque surfaces, sprites, blended surfaces. Fills f->radiance. */
void shading_add(struct frame_state *f);
/** Bytes of the G-buffer's targets: what drawing it writes, and lighting reads once; depth and radiance are left out. */
uint64_t shading_gbuffer_bytes(const struct frame_state *f);
/** Draw calls of the frame so declared. */
uint32_t shading_draw_count(const struct frame_state *f);

#endif
