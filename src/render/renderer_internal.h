/* SPDX-License-Identifier: MIT */
#ifndef FNL_RENDER_RENDERER_INTERNAL_H
#define FNL_RENDER_RENDERER_INTERNAL_H

#include "fanal/renderer.h"
#include "fanal/vulkan.h"
#include "passes/shadow/pages.h"
#include "render/shadow_costs.h"
#include "render/chooser.h"
#include "render/counters.h"
#include "render/device/scene.h"
#include "render/lists.h"
#include "render/probes_state.h"
#include "render/reflections_state.h"
#include "render/temporal_state.h"
#include "render/view.h"
#include "render/view_plan.h"

enum { OUTPUT_COUNT = 7 };           /* bits of fnl_output */

/** What belongs to one view of a renderer's frames, by its place in fnl_frame.views. */
struct renderer_view {
    struct temporal_state temporal;
    struct renderer_shadows {
        struct shadow_state pages;
        struct gpu_buffer kept; /* of items, by which they are found to have changed */
        struct gpu_buffer planes, keys; /* of struct gpu_shadow_maps, for suns. Frames that take the last one's pages take these as well */
        uint64_t drawn[4], placed[2]; /* versions of what the pages show: how things look, and where they are */
        bool all_changed, moved; /* since then */
        uint64_t changed; /* number of the last frame that was not in all the one before */
        uint64_t settled; /* of the last one known to have left all pages as they were */
    } shadows;
    struct gpu_buffer draws, counters; /* read back with count_lights */
    uint64_t counter_count;            /* light_counter_count() of the view */
};

/** What declaring a frame makes of a view. On submission, steps take over what they keep; the frame's results come from the rest. */
struct view_made {
    struct device_scene_frame scene; /* with the lights as this view sees them; passes look at it while they are recorded */
    fnl_frame_stats stats;           /* the parts that the CPU knows */
    struct view_counters numbers;
    struct light_totals known_totals;
    bool totals_known;
    uint32_t forward_layouts; /* frame_state.forward_layouts */
    uint32_t transmission_layers, transmission_limit; /* drawn, and how many there may be; 0: nothing is transmissive */
    uint64_t fixed_bytes; /* of the lists: what their pools do not hold */
    uint32_t entry_bytes, blend_entry_bytes;
    struct temporal_state temporal;
    struct {
        bool has_pages, same; /* the pages were requested; and nothing had changed */
        struct shadow_turn turn;
    } shadows;
};

/** Messages that each renderer logs once; true: already logged. */
struct renderer_notes {
    bool decal_lists;  /* lists replace decals over the G-buffer */
    bool mesh_lists;   /* mesh lists replace others */
    bool stereo_path;  /* the device lacks what stereo.path needs */
    bool shadow_rays;  /* rays replace shadow maps */
    bool shadow_trees; /* trees replace ray queries */
    bool mobile[2];    /* messages of the path mobile */
};

/** Where the CPU reads results: pictures of all views one after the other, and struct inspected. */
struct renderer_outputs {
    struct gpu_buffer pictures[OUTPUT_COUNT], pixel;
};

/** What tests ask of a renderer. */
struct renderer_tests {
    bool poison;      /* transient buffers begin each frame full of rubbish */
    bool force_async; /* passes for the compute queue go through it even where it is the graphics queue */
    /* As on devices without something: mesh shaders; scopes large enough for the order mobile; blending of 32-bit targets, for weighted
     * transparency; samplers that reduce, for the criterion minmax; coverage after the depth test and values shared by four pixels. */
    bool no_meshes, cannot_merge, weighted_half, no_minmax, dais_plain;
    bool auto_meshes;             /* geometry auto as on devices that are no CPU */
    uint32_t mesh_row, mesh_rows; /* work groups of a draw by mesh shaders; 0: as many as every device takes */
    bool fixed_pools;             /* pools of lists have pool_capacity entries, whatever the lights of the frame are thought to need */
    bool cluster_limit;           /* pools of culling stay as they are */
    uint32_t visibility_bits;     /* ids of the visibility buffer are at least so wide */
    uint32_t dais_probe;          /* DAIS_SHOW_… */
    bool guide_adverse;           /* what guides the choice of lights is nonsense */
    bool dais_impatient;          /* nobody locks a bucket, so that each fragment stores its triangle */
    bool show_levels;             /* virtual texturing gives levels of detail in place of radiance */
    struct gpu_buffer *probe_tap; /* takes the texels of the cube map that is baked, cubemap_bytes(); NULL: nothing does */
    struct gpu_buffer *mobile_tap; /* takes the targets of the order mobile as they are in the end, one after the other; NULL: nothing does */
    const struct volumes_hook *volume_hook; /* of deferred-volumes with the shape stencil; NULL: none */
};

enum { RENDERER_CPU_SECTIONS = 9 };

struct fnl_renderer {
    fnl_host host;
    gpu_device *device;
    fnl_scene *scene;
    struct graph *graph;
    struct device_scene_user scene_user;
    struct device_scene *device_scene;     /* the user's: other renderers may have it too */
    ARRAY(struct renderer_view) views;     /* at least one; as many as any frame so far had */
    struct renderer_tests *tests;          /* of the host; NULL outside of tests */

    /* What each step keeps. Declaring a frame does not change it. */
    struct {
        struct lists_shared shared;
        ARRAY(struct lists_state) views; /* one for each of `views` */
        uint32_t pool_capacity; /* entries that the pools of lists have at least; grows after an overflow */
    } lists;
    struct {
        uint32_t capacity;  /* of what holds decals */
        uint32_t tree_from; /* from so many boxes on a tree fills the clusters of their list; the entries are the same */
    } decals;
    struct {
        uint32_t cluster_capacity, triangle_capacity; /* 0: before the first frame that needs them */
    } culling;
    struct {
        uint32_t pairs; /* of a page of shadow maps and an item that is drawn into it; grows after an overflow */
        struct shadow_costs costs;
        struct {
            uint64_t frame, drawn, probed;
        } counted;                /* of the frame whose counts were taken last; 0: its times are not wanted */
        uint64_t mapless_version; /* light_version of the scene + 1 at which `mapless` was found; 0: never */
        bool mapless;             /* the scene has lights without maps */
    } shadows;
    struct renderer_probes probes;
    struct renderer_reflections reflections;
    struct {
        struct fnl_renderer *owner;     /* NULL: this renderer makes the caller's frames; else those that probes of `owner` are captured by */
        uint32_t probe;                 /* which one in the list */
    } capture;
    struct {
        uint32_t transmission_layers; /* that frames draw: as many as the last ones needed */
        uint32_t blend_capacity;      /* fragments of linked transparency; 0: before the first frame */
        uint32_t dais_capacity, dais_node_capacity; /* words of triangles, list elements; they grow after an overflow */
        struct virtual_atlas atlas;   /* of virtual texturing */
    } shading;
    struct renderer_overlay {
        struct gpu_image image;
        uint64_t version;
    } overlays[FNL_OVERLAY_IMAGES_MAX];
    struct renderer_pixel {
        ARRAY(uint32_t) suns;           /* the scene's when it was asked for */
        uint32_t next_generation;       /* as well: lights of later ones came after */
        ARRAY(fnl_pixel_light) lights;  /* handed out */
    } pixel;
    struct {
        struct chooser chooser;
        struct choice asked; /* of the last frame */
        bool measures;       /* the frame being made has an auto that may measure */
    } choice;
    struct {
        uint64_t version;       /* light_version of the scene in the last frame */
        uint32_t moving_frames; /* for which lights still count as moving */
    } lights;

    struct renderer_notes notes;

    /* Frames that are declared only for their pipelines. */
    struct {
        struct graph *graph; /* NULL: none yet */
        uint32_t together;   /* while one is declared: its one view is drawn with so many; 0: alone */
    } dry;

    /* The last frame, and where its results are. */
    fnl_frame frame;       /* without the addresses of its views and its overlay */
    uint64_t frame_number; /* 0: none yet, or the last one failed */
    uint32_t frame_slot;   /* its slot: other renderers of the device take slots too */
    uint32_t pipelines_made; /* by the frame itself */
    struct renderer_outputs outputs;
    ARRAY(struct view_made) last, making; /* for each view: of the last frame, and of the frame being declared */
    ARRAY(struct geometry_bucket) counted_buckets; /* of a frame with count_lights: another renderer may change the scene's meanwhile */
    struct {
        struct gpu_buffer counts[GPU_FRAMES_IN_FLIGHT]; /* struct frame_counts of each view */
        uint64_t frames[GPU_FRAMES_IN_FLIGHT];          /* their numbers */
        uint32_t views[GPU_FRAMES_IN_FLIGHT];           /* of the frame whose counts a slot holds; 0: none */
    } slots;
    struct { /* with the stats of a frame */
        ARRAY(fnl_frame_stats) view_stats; /* with several views */
        ARRAY(fnl_counter) counters;
        ARRAY(fnl_pass_time) pass_times;
        fnl_candidate candidates[CHOOSER_ROWS];
        fnl_memory_kind memory_kinds[GPU_USE_COUNT];
        fnl_cpu_section cpu_sections[RENDERER_CPU_SECTIONS];
        uint32_t cpu_section_count;
        double cpu_milliseconds;
    } handed;
};

/** The counts of a view in a slot. */
static inline const struct frame_counts *renderer_counts(const fnl_renderer *r, uint32_t slot, uint32_t view) {
    return (const struct frame_counts *)(const void *)((const char *)r->slots.counts[slot].mapped + view * counters_size());
}

/** What follows the counts of pixels, as count_shadows() in shade.glsl writes it. */
enum { LIGHT_COUNTER_UNSERVED, LIGHT_COUNTER_RAYS, LIGHT_COUNTER_RAYS_PASSED, LIGHT_COUNTER_FILTERED, LIGHT_COUNTER_SETTLED, LIGHT_COUNTERS_MORE };
/** Words of the counts of light evaluations of a view: two for each pixel, then LIGHT_COUNTERS_MORE. */
static inline uint64_t light_counter_count(const fnl_frame *frame) { return 2ull * frame->width * frame->height + LIGHT_COUNTERS_MORE; }

/** What tests ask for: nothing outside of them. */
static inline struct renderer_tests renderer_tests(const fnl_renderer *r) {
    return r->tests ? *r->tests : (struct renderer_tests){0};
}

/** Where a frame goes besides the readback buffers: view i to layer i. */
struct frame_target {
    const struct gpu_image *image;
    VkImageLayout initial_layout, final_layout;
    fnl_vulkan_part part; /* not 0 x 0 */
    const struct gpu_image *depth; /* NULL: none is wanted */
    VkImageLayout depth_initial_layout, depth_final_layout;
    bool depth_forward;
};

/** The size that the picture is scaled to. */
static inline struct gpu_extent frame_target_size(const struct frame_target *target) {
    return target->part.fitted ? (struct gpu_extent){target->part.width, target->part.height}
                               : (struct gpu_extent){target->image->params.width, target->image->params.height};
}

/** Whether mesh shaders draw the clusters that culling leaves. The scene is prepared, nothing of the frame is auto. */
bool frame_draws_meshes(const fnl_renderer *r, const fnl_frame *frame);
/** What the frame's occlusion is in place of auto. The scene is prepared. */
fnl_occlusion frame_choose_occlusion(const fnl_renderer *r, const fnl_frame *frame);
/** Whether occluded surfaces are culled; nothing of the frame is auto. */
bool frame_culls_hidden(const fnl_frame *frame);

/** Input of frame_declare(). Arrays have an element for each camera of the plan. */
struct frame_input {
    const fnl_frame *frame; /* settled */
    const struct view_plan *plan;
    const struct frame_target *target; /* NULL: none */
    struct graph *graph;
    const struct renderer_view *views;
    const struct renderer_outputs *outputs;
    struct view_made *made; /* out */
    /* Working memory of steps while they declare. */
    struct device_scene_user *user;
    struct lists_shared *shared_lists;
    struct lists_state *lists;
    struct renderer_notes *notes; /* NULL: the frame is declared only for its pipelines, and logs nothing */
};
/** Declares the whole frame (frame.c). */
fnl_result frame_declare(const fnl_renderer *r, const struct frame_input *input);

/** Brings the scene on the device up to date, replaces auto by what the frame uses, and makes what lasts; outside of frames. */
fnl_result renderer_prepare(fnl_renderer *r, fnl_frame *frame);
void renderer_choose(fnl_renderer *r, fnl_frame *frame);
/** After a frame that failed: nothing is known of what the device has of it. */
void renderer_forget(fnl_renderer *r);
/**
 * A frame of one view becomes as any other. With several, auto becomes what serves any scene: it learns from frames of one view. Before the frame
 * is checked.
 */
void renderer_settle_views(fnl_frame *frame);
/**
 * Sets the stage (fanal/stage.h), and replaces what a frame leaves open by what it uses: views, shadows, samples. Before the frame is checked. The choice of `auto` paths and lists
 * comes later (renderer_choose()).
 */
fnl_result renderer_settle(fnl_renderer *r, fnl_frame *frame);
/** FNL_ERROR_UNSUPPORTED, with a log line, unless frames can go into images of this format. */
fnl_result renderer_check_target(const struct call *call, VkFormat format);
/**
 * Asks for the pipelines of a frame without rendering it (warm.c): declares it in a graph of its own, and puts everything back that
 * declaring changes in the renderer. Inside a device's frame, whose memory it takes. The scene is prepared. `out_ticket` as gpu_ask_end's.
 */
fnl_result renderer_ask_pipelines(fnl_renderer *r, const fnl_frame *frame, const struct frame_target *target,
                                  uint64_t *out_ticket);

/** Fails, with a log line, unless the frame's options are in range, go together and suit the device (frame_check.c). */
fnl_result frame_check(const struct call *call, fnl_renderer *r, const fnl_frame *frame);

/** Bytes of a picture of one view, by the bit of its output (results.c). */
uint64_t renderer_picture_size(const fnl_frame *frame, uint32_t bit);

#endif
