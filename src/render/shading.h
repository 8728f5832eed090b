/* SPDX-License-Identifier: MIT */
/**
 * The shading orders seen from outside: what each goes with, and what all of them share. An order is a file of orders/ that ends in a row
 * (struct order of orders/order.h); shading.c lists the rows.
 */
#ifndef FNL_RENDER_SHADING_H
#define FNL_RENDER_SHADING_H

#include "render/frame_state.h"

enum shading_trait {
    SHADING_FORWARD = 1 << 0,      /* shades while it draws: pixels may have several samples */
    SHADING_GBUFFER = 1 << 1,      /* shades what a G-buffer holds: lists may look at depth and normals */
    SHADING_PREPASS = 1 << 2,      /* draws the depth of the opaque set first */
    SHADING_MAY_PREPASS = 1 << 3,  /* does so where gbuffer.prepass asks for it */
    SHADING_BLENDS = 1 << 4,       /* adds lights up by blending into the radiance target */
    SHADING_POSITIONS = 1 << 5,    /* looks lights up at positions rebuilt from depth, as lists made from depth do */
    SHADING_SAMPLES = 1 << 6,      /* pixels may have several samples */
    SHADING_LAYOUTS = 1 << 7,      /* heeds gbuffer.layout, normals and chroma, and has the debug views of a G-buffer */
    SHADING_REDRAW = 1 << 8,       /* draws the geometry a second time for its materials */
    SHADING_APPROXIMATE = 1 << 9,  /* gives a picture that is close to that of the others, not equal */
    SHADING_VOLUMES = 1 << 10,     /* finds the lights of opaque surfaces by drawing volumes: lists serve blended ones alone */
    SHADING_ITEMS = 1 << 11,       /* knows the item that a pixel shows: lists of objects serve it */
    SHADING_FULL_RASTER = 1 << 12, /* draws all geometry in the frame's own pixels: culling may leave out what their samples do not see */
    SHADING_LISTS_FIRST = 1 << 13, /* makes its lists before it draws: they see depth only after a prepass */
    SHADING_VERTICES = 1 << 14,    /* needs vertex shaders */
    SHADING_DECALS = 1 << 15,      /* with decals = gbuffer it applies boxes and volumes to what it stores */
    SHADING_DECAL_STEP = 1 << 16,  /* does so in a step that walks their list and does not know what a surface receives */
    SHADING_VIEWS = 1 << 17,       /* draws several views in one frame */
    SHADING_MULTIVIEW = 1 << 18,   /* of them what it draws before lists, the prepass included, for several views at once */
    SHADING_HIDDEN = 1 << 21,      /* leaves out what hidden areas cover (fnl_frame.hidden_areas) */
    SHADING_LAYERS = 1 << 20,      /* shades layered materials itself; where it does not they are drawn over its picture */
    SHADING_SURFACES = 1 << 19     /* with one sample a pixel it shades just what depth shows there, whatever else it shades for nothing */
};
/** Whether an order has all of these traits, whatever the options of a frame; auto has none. */
bool shading_is(fnl_shading shading, uint32_t traits);
/** The same of the order of a frame with its options, which may add traits or take them away. Not auto. */
bool frame_is(const fnl_frame *frame, uint32_t traits);

/** Whether the debug view of lights, or the pixel that is asked for, shows counts of this very frame's volumes. */
bool shading_shows_volumes(const fnl_frame *frame);
/** Whether the environment is seen behind everything. */
bool shading_shows_sky(const struct frame_state *f);
/** Where nothing opaque is seen. An order that draws blended surfaces itself calls it before them; a second call does nothing. */
void shading_add_sky(struct frame_state *f);
/** The frame's background in place of auto, and of what its scene does not have. Captures of reflection probes show the environment. */
fnl_background shading_background(const struct frame_state *f);
/** Whether the scene has surfaces that show what is behind them. */
bool shading_has_glass(const struct frame_state *f);
/** Whether layered materials are drawn over the order's picture. */
bool shading_draws_layered(const struct frame_state *f);
/** The layout of the frame's G-buffer: the default becomes FNL_GBUFFER_LAYERS where that holds more of the scene. */
fnl_gbuffer shading_layout(const struct frame_state *f);
/** The format of the radiance target. */
VkFormat shading_format(const struct frame_state *f);

/** Fails with a log line where the frame's order cannot do what the frame asks of it. Not auto. */
fnl_result shading_check(const struct call *call, const fnl_renderer *r, const fnl_frame *frame);
/** Before a frame begins: what the order keeps from frame to frame. */
fnl_result shading_prepare(fnl_renderer *r, const fnl_frame *frame);
/** Fills in what of f->shared depends on the order, before it is sent. */
void shading_begin(struct frame_state *f);
/**
 * Draws what needs no lists, with f->draws, which may be of several views: then targets have a layer for each. shading_add() does it where it
 * was not done before.
 */
void shading_draw(struct frame_state *f);
/** The view takes its layer of what was drawn for several, of which it is one. */
void shading_take_layer(struct frame_state *f, const struct frame_state *together, uint32_t layer);
/** Declares everything between culling and the picture: lists, opaque surfaces, sprites, blended surfaces. Fills f->radiance. */
void shading_add(struct frame_state *f);
/** Once the frame is on its way to the device. */
void shading_submitted(fnl_renderer *r, const fnl_frame *frame);
/** Of what several orders do. */
extern const struct counter_table shading_counters;

/** Draw calls of the frame so declared. */
uint32_t shading_draw_count(const struct frame_state *f);

#endif
