/* SPDX-License-Identifier: MIT */
/** What a frame did and took, in numbers. */
#ifndef FANAL_STATS_H
#define FANAL_STATS_H

#include "fanal/frame.h"

#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What a pass runs on. */
typedef enum fnl_queue {
    FNL_QUEUE_GRAPHICS = 0,
    FNL_QUEUE_COMPUTE, /**< beside it, where the device has a second queue */
    FNL_QUEUE_COUNT
} fnl_queue;

/** What a pass is for. */
typedef enum fnl_pass_role {
    FNL_PASS_REST = 0,
    FNL_PASS_GEOMETRY, /**< what is where: skinning, culling, depth, G-buffers */
    FNL_PASS_LISTS,    /**< which lights reach what */
    FNL_PASS_SHADOWS,
    FNL_PASS_SHADING,
    FNL_PASS_READ, /**< hands results to the CPU */
    FNL_PASS_ROLE_COUNT
} fnl_pass_role;

typedef struct fnl_pass_time {
    const char *name; /**< as the frame graph names it */
    double milliseconds;
    double begin_milliseconds; /**< since the first pass of the frame began */
    fnl_queue queue;
    fnl_pass_role role;
} fnl_pass_time;

/** A part of what the calling thread does for a frame. They follow one another without gaps. */
typedef struct fnl_cpu_section {
    const char *name;          /**< lives as long as the program */
    double begin_milliseconds; /**< since the call that rendered the frame began */
    double milliseconds;
} fnl_cpu_section;

/** A pair that `auto` may choose. */
typedef struct fnl_candidate {
    fnl_shading shading;
    fnl_light_lists lists;
    double milliseconds; /**< the median of its frames, without passes that cost the same with all of them; 0: not measured yet */
    uint32_t frames;     /**< that were measured, those of earlier runs among them; 0 with milliseconds above 0: remembered */
    bool chosen;         /**< the decision; none while auto is choosing */
} fnl_candidate;

typedef enum fnl_counter_kind {
    FNL_COUNTER_COUNT = 0, /**< how many */
    FNL_COUNTER_OVERFLOW,  /**< how many found no room in a pool, so that the frame was drawn in another way; the pool grows for the next one if it can */
    FNL_COUNTER_SWITCH     /**< 1: yes, 0: no */
} fnl_counter_kind;

/** A number of one technique. All strings live as long as the program. */
typedef struct fnl_counter {
    /** Such as "coarse.shared": the technique, and what is counted. */
    const char *key;
    /** One line. */
    const char *help;
    fnl_counter_kind kind;
    /** Such as "bytes"; "": none. */
    const char *unit;
    /** The shading paths that can have it: bit 1 << fnl_shading. All bits: several paths make it, but perhaps not each. */
    uint32_t shadings;
    /** The option without which a frame does not have it: "count-lights" where that is not off or 0, "dais.mode=list" where it has this value, or one of several with commas between; "": none. */
    const char *needs;
    /** What the frame counted; 0 in a row of fnl_counter_query(). */
    uint64_t value;
} fnl_counter;

/** Device memory of one kind. */
typedef struct fnl_memory_kind {
    const char *name; /**< lives as long as the program */
    uint64_t bytes;
} fnl_memory_kind;

/** The counter `index`, 0 and up, without a value; false beyond the last. No frame has all of them. */
FNL_API bool fnl_counter_query(uint32_t index, fnl_counter *out);

typedef struct fnl_frame_stats {
    /* ---- lights ---- */

    /** All point, spot and shaped lights, and those whose bounds touch the view; for `all` lists both are the same. */
    uint32_t lights_total, lights_in_view;
    /** Memory of the light lists; the part of it that this frame's lights and cells fill; pairs of a cell and a light. */
    uint64_t list_bytes, list_used_bytes, list_entries;
    /** Cells of the lists, and those whose lights did not fit into the pool in this frame: they use coarser lists, of about a hundredth of the
        screen. */
    uint32_t cells, overflow_cells;
    /** Always 0: no light is ever lost. */
    uint32_t lights_dropped;
    /** Whether the next five were counted (fnl_frame.count_lights). */
    bool evaluations_counted;
    /** Points shaded with coarser lists, or with all lights: in cells that overflowed, and with MSAA also off the surfaces of their cell or outside
        the view. Not counted by light-prepass, low-res and inferred. */
    uint64_t unserved_points;
    /** Lights visited by shaded fragments, and those of them that reach the surface: the least that any list could visit. Without directional
        lights. */
    uint64_t evaluations, evaluations_useful;
    /** Lights that a pixel visits, on average and at most. */
    double mean_per_pixel;
    uint32_t max_per_pixel;

    /* ---- geometry ---- */

    /** Draw calls; an indirect one counts once. Those that draw several views at once count in the first of them. */
    uint32_t draws;
    /** Items, which are primitives of instances; those left after culling; those in view that are occluded (with occlusion). */
    uint64_t items, items_visible, items_occluded;
    /** Visible items drawn as a whole because a pool of culling was too small in this frame. */
    uint32_t items_whole;
    /** Triangles of visible items, opaque and alpha-masked; known with count_lights. */
    uint64_t triangles_visible;
    /** Opaque and alpha-masked triangles of all instances, and with culling by clusters or triangles what became of them: drawn, outside the view,
        facing away, between samples, occluded. Objects that some lists draw in their own way (batches, multipass) count all the same. */
    uint64_t triangles_total, triangles_drawn, triangles_outside, triangles_back, triangles_small, triangles_occluded;
    /** Clusters of all instances, and those of which something is drawn. */
    uint64_t clusters_total, clusters_drawn;
    /** What drew the clusters: vertex or mesh. */
    fnl_geometry geometry;
    /** Whether occluded surfaces were culled. */
    bool occlusion;

    /* ---- what the techniques of the frame did ---- */

    /** The counters of the frame, in the order of fnl_counter_query(). Those that its shading path, lists and options do not make are missing, rather than
        0. fnl_counter_find() finds one by its key. Owned by the renderer, valid until the next call on it. */
    uint32_t counter_count;
    const fnl_counter *counters;

    /* ---- memory and time ---- */

    /** What the passes move between images and memory, computed from formats and load and store operations, not measured: an attachment that is loaded or
        stored, and an image that a shader reads or writes, counts as a whole each time. Copies, textures and buffers are left out.
        fnl_renderer_print() with FNL_PRINT_TRAFFIC lists it by pass. */
    uint64_t image_bytes_read, image_bytes_written;
    /** Attachments that never leave tile memory on GPUs that have it; lazily allocated memory among them, and what the driver had to back. */
    uint64_t tile_bytes, lazy_bytes, lazy_committed_bytes;
    /** Device memory in use, and its greatest amount so far. */
    uint64_t device_bytes, device_peak_bytes;
    /** device_bytes by kind, always the same ones in the same order; together they are device_bytes, of all that use the device. Owned by the renderer,
        valid until the next call on it.
        geometry: vertices, clusters, instances, materials, acceleration structures; textures: images of materials and decals; lights: lights, decals and
        probes, the environment, lists that outlive frames; shadows: shadow maps; frame: what lives within a frame, images as light lists; history: images
        that frames hand on; transfer: between the CPU and the device, both ways; other: the rest. */
    uint32_t memory_kind_count;
    const fnl_memory_kind *memory_kinds;
    /** What the calling thread took to declare, compile, record and submit the frame: the sum of cpu_sections but for "update the scene" and
        "wait for the GPU". */
    double cpu_milliseconds;
    /** Sum of all passes; 0 without timers. */
    double gpu_milliseconds;
    /** The exposure used, EV100. */
    float ev;

    /* ---- what the frame was rendered with ---- */

    /** The choice of auto, or what was asked for. Lists are mesh where these stand in for batches or multipass, which have no MSAA and a limited number
        of passes. */
    fnl_shading shading;
    fnl_light_lists lists;
    /** Samples per pixel: fnl_frame.msaa, with FNL_MSAA_AUTO resolved. */
    uint32_t msaa;
    /** auto has not decided yet; false with pin_choice. */
    bool choosing;
    /** Pipelines of auto's candidates that are still being compiled in the background; until then it does not measure. */
    uint32_t pipelines_pending;
    /** Pipelines that the frame needed and had to compile itself or to wait for: a hitch. fnl_renderer_warm makes them ahead. */
    uint32_t pipelines_made;
    /** Pipelines made for the device so far, and those of them that the driver found in its cache file (0 where it does not tell). */
    uint32_t pipelines_total, pipelines_cached;
    /** What auto chose by, or "". Owned by the renderer, valid until the next call on it. */
    const char *choice;
    /** The passes in order. Owned by the renderer, valid until the next call on it. */
    uint32_t pass_count;
    const fnl_pass_time *passes;
    /** What the calling thread did, in order. Owned by the renderer, valid until the next call on it. */
    uint32_t cpu_section_count;
    const fnl_cpu_section *cpu_sections;
    /** What auto has measured or will, the shading paths first; 0 and NULL for frames without auto. Owned by the renderer, valid until the next call
        on it. */
    uint32_t candidate_count;
    const fnl_candidate *candidates;
    /** The numbers of each view of a frame with several: those of lights and geometry, the counters, and ev are the view's own, the rest is the frame's.
        With fnl_stereo_options.mono_distance the mono view of each display comes behind them. Here outside are those of the first view. 0 and NULL for a frame with one. Owned by the renderer, valid until the next call on it. */
    uint32_t view_count;
    const struct fnl_frame_stats *views;
} fnl_frame_stats;

/** The counter with this key, of a frame or of one of its views; NULL if it has none. */
static inline const fnl_counter *fnl_counter_find(const fnl_frame_stats *stats, const char *key) {
    for (uint32_t i = 0; i < stats->counter_count; i++)
        if (strcmp(stats->counters[i].key, key) == 0) return &stats->counters[i];
    return NULL;
}

#ifdef __cplusplus
}
#endif
#endif
