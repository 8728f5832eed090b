/* SPDX-License-Identifier: MIT */
/** What the parts of a frame hand to each other while it is declared. */
#ifndef FNL_RENDER_FRAME_STATE_H
#define FNL_RENDER_FRAME_STATE_H

#include "decals_shared.h"
#include "passes/aa/motion.h"
#include "passes/dais/dais.h"
#include "passes/debug/debug.h"
#include "passes/post/post.h"
#include "passes/shadow/denoise.h"
#include "passes/stereo/hidden_area.h"
#include "passes/texturing/texturing.h"
#include "passes/visibility/visibility.h"
#include "render/renderer_internal.h"

#include <math.h>

/** Decals of the frame (decals.c). */
struct frame_decals {
    struct device_decals_frame buffers;
    struct gpu_decal_set *set; /* NULL: there are none */
    VkDeviceAddress set_address;
    struct light_input input;
    struct lights_in_view in_view;
    struct light_list list;
};

/** Of the frame and the last one (temporal.c). */
struct frame_temporal {
    struct gpu_view view, previous; /* without jitter; `previous`: the last frame's, if any, relative to this origin */
    double origin_moved[3];         /* since the last frame */
    vec2 jitter;          /* pixels right of and below their centres */
    uint32_t index;
    bool keeps, still; /* the last frame's history counts; and nothing has changed since */
    bool same;         /* still, with the same jitter: pixels show the same points as in the last frame */
    uint32_t sequence;     /* frames before whose history counts, where shadows are denoised or guided */
    uint32_t still_frames; /* since something changed */
    graph_image motion;
};

/** Views that are the eyes of one viewer, while they are declared (stereo.c). */
struct frame_display {
    struct gpu_view head;      /* sees all that an eye sees */
    VkDeviceAddress head_address; /* 0: there is no such view, as eyes look too far apart */
    VkDeviceAddress near_address; /* of the same but for what lies behind the plane of mono_distance, which is all that is drawn for an eye; 0: none */
    struct geometry_draws draws;  /* of the head; sums id 0: each eye culls for itself */
    struct light_list lights;     /* of the head, from the first eye on; header 0: none */
};

/** What the views of a frame pass on to the next view. */
struct frame_common {
    uint32_t vertex_queries;        /* taken so far */
    struct environment_faces faces; /* of a reflection probe that the frame captures */
};

/** One view of a frame. Members that all views share are filled in before the first. Each group of members belongs to one step, or to what its name says. */
struct frame_state {
    const fnl_renderer *r; /* not changed while a frame is declared */
    const struct frame_input *input;
    struct frame_common *common;
    const struct renderer_view *kept; /* what the view keeps from frame to frame */
    struct view_made *made;           /* what this frame makes of the view */
    uint32_t view_index;
    bool named;                       /* names of its passes begin with the view's */
    const fnl_frame *frame;           /* its camera is the view's */
    struct graph *graph;
    struct device_scene_frame *scene; /* made->scene */
    struct gpu_frame shared; /* by all views */
    struct gpu_view view;
    VkDeviceAddress shared_address, view_address;
    uint64_t counts_offset;  /* of this view's struct frame_counts */
    struct frame_temporal temporal;
    struct hidden_area hidden;              /* of the view; in frames without hidden areas nothing */
    struct frame_decals decals;
    struct gpu_reflection_set *reflections; /* NULL: there are none */
    struct lighting lighting;               /* without a list: what lights the view, as far as it is known yet */
    struct lighting lights, blend_lights;   /* by the frame's lists: of opaque and of blended surfaces; the same list except for tiles with depth bounds */
    struct geometry_draws draws;
    graph_buffer counters, exposure;
    graph_image radiance, depth, color;
    struct {
        struct frame_display *display;    /* the display of which this view is an eye; or NULL */
        const struct frame_state *layers; /* the layer_count views that are drawn at once; NULL: only this one */
        uint32_t layer_count;
        const struct frame_state *mono;   /* for an eye: the view of what is far away (mono.c); or NULL */
        const struct frame_state *eyes;   /* for such a view: its eye_count eyes; otherwise NULL */
        uint32_t eye_count;
    } group;
    struct { /* by the order, before it shades; id or address 0: not by this order */
        struct gbuffer gbuffer;
        struct visibility visibility;
        graph_buffer surfaces;       /* of MSAA in orders that shade after drawing (passes/shade/samples_shared.h) */
        graph_buffer coarse_words;   /* of coarse shading (passes/shade/coarse.h) */
        struct texturing texturing;  /* of virtual texturing */
        struct dais dais;
    } stored;
    struct {
        uint32_t first;  /* draw calls before lists; for several views at once, in the first view */
        uint32_t opaque; /* draw calls of the opaque set without a prepass: of one draw unless the order sets more */
    } calls;
    uint32_t forward_layouts; /* bits of geometry_bucket.forward_layouts: what the order also shades forward; 0: nothing */
    struct {
        struct light_set whole_lights;   /* before small lights were faded */
        fnl_light_lists drawn;           /* the frame's, or the lists that replace them */
        struct lists_fallback fallback;
    } lists;
    struct {
        graph_image depth;               /* drawn only for shadows; id 0: not drawn */
        struct rays rays;                /* of items at least, where maps are drawn; address 0: there are none */
        struct light_list surface_lights; /* for surfaces in the depth image, without lights that contribute nothing there; header 0: none */
        graph_buffer classes;            /* for the debug view shadow-classes: the output of shadow_dark_add(); or id 0 */
        struct denoise denoise;          /* places.id 0: nothing was denoised */
    } shadows;
    struct { /* the nearest surface of each pixel */
        struct aov_images aov;
        graph_image objects;
        VkDeviceAddress object_table; /* with FNL_OUTPUT_OBJECT */
    } nearest;
    struct {
        bool sky, blended; /* the order has drawn them itself */
    } done;
};

/** Whether the frame is declared only for its pipelines. */
static inline bool frame_is_dry(const struct frame_state *f) { return !f->input->notes; }
/** Whether a message that a renderer logs once (renderer_notes) is due; marks it as logged. */
#define FRAME_TELLS(f, note) ((f)->input->notes && !(f)->input->notes->note && ((f)->input->notes->note = true))

/** What radiance is multiplied by for the picture; 1 where metering finds it. */
static inline float frame_exposure(const fnl_frame *frame) {
    return frame->exposure == FNL_EXPOSURE_EV ? 1 / (1.2f * exp2f(frame->ev)) : 1;
}

/** What the picture of the frame is made with; exposure by metering is left to the caller. */
struct picture {
    VkFormat format;
    struct tonemap_params tonemap;
    enum display_format display; /* of linear targets */
};
static inline struct picture frame_picture(const struct frame_state *f) {
    struct picture picture = {.format = VK_FORMAT_R8G8B8A8_UNORM,
                              .tonemap = {.tonemap = (uint32_t)f->frame->tonemap, .factor = frame_exposure(f->frame)}};
    if (f->input->target) {
        VkFormat wanted = f->input->target->image->params.format;
        picture.tonemap.swap = wanted == VK_FORMAT_B8G8R8A8_UNORM || wanted == VK_FORMAT_B8G8R8A8_SRGB;
        picture.tonemap.linear = wanted == VK_FORMAT_R16G16B16A16_SFLOAT || wanted == VK_FORMAT_R32G32B32A32_SFLOAT;
        if (picture.tonemap.linear) picture.format = wanted;
        if (wanted == VK_FORMAT_A2B10G10R10_UNORM_PACK32) picture.display = DISPLAY_ABGR10;
        if (wanted == VK_FORMAT_A2R10G10B10_UNORM_PACK32) picture.display = DISPLAY_ARGB10;
        if (picture.display != DISPLAY_LINEAR) {
            picture.tonemap.linear = true;
            picture.format = VK_FORMAT_R16G16B16A16_SFLOAT;
        }
    }
    return picture;
}

/** An image of the frame's size. */
static inline graph_image frame_create_image(struct frame_state *f, const char *name, VkFormat format, uint32_t samples) {
    return graph_create_image(
        f->graph,
        &(struct graph_image_params){
            .name = name, .format = format, .width = f->frame->width, .height = f->frame->height, .samples = samples});
}

#endif
