/* SPDX-License-Identifier: MIT */
/** What the files of the frame graph share: a frame's declarations, the plan made of them, and what outlives a frame. */
#ifndef FNL_GRAPH_INTERNAL_H
#define FNL_GRAPH_INTERNAL_H

#include "graph/graph.h"

#define GRAPH_NONE UINT32_MAX

enum {
    GRAPH_NAME_SCOPES = 8, /* one in another */
    GRAPH_NAME_BUCKETS = 512,
    GRAPH_KEEP_FRAMES = 4, /* histories and physical resources that were not used for so many frames are released */
};

/* ---- declarations ---- */

/** All uses of one resource by one pass, merged. */
struct graph_access {
    struct graph_access *next;                                    /* of the same pass */
    struct graph_access *next_of_resource, *previous_of_resource; /* among live passes; set by compile */
    uint32_t resource, step;
    uint64_t read_layers, written_layers; /* bits; all of them for buffers, and for images with more than 64 layers */
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkPipelineStageFlags2 run_stages; /* this and the following reads of the same layout and queue, up to the next change */
    VkAccessFlags2 run_access;
    VkImageLayout layout; /* images */
    VkImageUsageFlags usage;
    bool reads; /* depends on what was there before */
    bool writes;
    bool discards; /* replaces the whole contents: a clear, a resolve, or an attachment whose old contents do not matter */
};

struct graph_pass_attachment {
    uint32_t resource, resolve; /* GRAPH_NONE: none */
    VkAttachmentLoadOp load;
    VkClearValue clear;
    bool read_only;
};

/** Between graph_begin_scope and graph_end_scope. */
struct graph_scope {
    const char *name;
    bool merged;
};

/** A row of a pass, and where its address goes in the pass's data. */
struct graph_patch {
    struct graph_patch *next;
    struct graph_row row;
    void *place;
};

/** An address or sampled index that is wanted outside of passes. */
struct graph_put {
    struct graph_put *next;
    void *place;
    uint32_t resource;
    uint64_t offset;
};

struct graph_pass {
    struct graph *graph;
    const char *name;
    enum graph_queue queue;
    enum graph_role role;
    graph_execute *execute;
    void *data;
    const void *original; /* what rows point into: the caller's data, or push constants */
    void *copy;           /* the same in `data` */
    size_t original_size;
    struct graph_patch *patches;
    struct graph_access *first_use, *last_use;
    struct graph_pass_attachment colors[GPU_MAX_COLORS], depth;
    uint32_t color_count;
    const struct graph_scope *scope;   /* or NULL */
    uint32_t inputs[GPU_MAX_INPUTS];   /* resources of local reads, GRAPH_NONE: none */
    uint32_t input_count;              /* with gaps */
    uint32_t view_mask;                /* 0: one view */
    uint32_t vertex_layers;            /* 0: layer 0 alone, or the view mask */
    const struct graph_merged *merged; /* of the pass that compile makes of a merged scope: what it is made of */
    bool keep, live;
};

/** The live passes of a merged scope, and their attachments in order of first use. */
struct graph_merged {
    struct graph_pass *parts[GPU_MAX_SCOPE_STEPS];
    uint32_t part_count;
    struct graph_pass_attachment attachments[GPU_MAX_SCOPE_ATTACHMENTS];
    uint32_t attachment_count;
};

/** What must be waited for before a resource may be used again: while a plan is made, and at its end for the next one. */
struct graph_state {
    VkImageLayout layout;
    /* The last write or layout change, and what it was made visible to on its own queue. */
    enum gpu_queue write_queue;
    uint32_t write_batch;
    VkPipelineStageFlags2 write_stages, visible_stages;
    VkAccessFlags2 write_access, visible_access;
    /* Reads since then, by queue; stages 0: none. */
    VkPipelineStageFlags2 read_stages[2];
    uint32_t read_batch[2];
};

enum graph_history_role { GRAPH_HISTORY_NONE, GRAPH_HISTORY_CURRENT, GRAPH_HISTORY_PREVIOUS };

struct graph_resource {
    const char *name;
    bool is_image, imported, host_read;
    bool has_contents; /* at the start of the frame */
    enum graph_history_role role;
    uint32_t history; /* index, when role is not NONE */
    struct graph_image_params params;
    uint64_t buffer_size;
    VkImageLayout initial_layout, final_layout; /* imported images and histories */
    uint32_t whole, layer;                      /* of graph_image_layer: the image's index + 1; 0: it is none */
    const struct gpu_image *image;              /* imported, or set before the passes are recorded */
    const struct gpu_buffer *buffer;

    /* Set by compile. */
    VkImageUsageFlags usage;
    struct graph_access *first_use, *last_use; /* by live passes, in order */
    uint32_t first_step, last_step;            /* lifetime of its memory */
    bool on_async;
    uint32_t pool; /* GRAPH_NONE: owns no transient memory */
    uint64_t offset, size;
    uint32_t next_in_pool; /* by rising offset */
    uint32_t physical;     /* index into graph.physicals */
    struct graph_state state;
};

/* ---- the plan ---- */

struct graph_barrier {
    struct graph_barrier *next;
    uint32_t resource;
    VkPipelineStageFlags2 from_stages, to_stages;
    VkAccessFlags2 from_access, to_access;
    VkImageLayout from_layout, to_layout;
};

/** A buffer (or aliased memory) that takes part in a memory barrier; for the printed plan. */
struct graph_cause {
    struct graph_cause *next;
    uint32_t resource;
};

/** One pipeline barrier: image barriers and one global memory barrier (none when its stages are 0). */
struct graph_barriers {
    struct graph_barrier *first, *last;
    VkPipelineStageFlags2 from_stages, to_stages;
    VkAccessFlags2 from_access, to_access;
    struct graph_cause *first_cause, *last_cause;
};

/** A live pass. */
struct graph_step {
    struct graph_pass *pass;
    struct graph_barriers before;
    uint32_t batch, next_in_batch;
    enum gpu_queue queue;
};

struct graph_batch {
    enum gpu_queue queue;
    uint32_t wait; /* a batch of the other queue, or GRAPH_NONE */
    uint32_t first_step, last_step, step_count;
    struct graph_barriers after; /* at its end */
};

struct graph_plan {
    bool compiled, async; /* async: some pass runs on the compute queue */
    struct graph_step *steps;
    uint32_t step_count, culled_count, barrier_count;
    struct graph_batch *batches; /* in submission order */
    uint32_t batch_count;
    uint64_t transient_bytes, unaliased_bytes;
    uint64_t bytes_read, bytes_written, tile_bytes; /* of images */
    double compile_milliseconds;
};

/* ---- what lives longer than a frame ---- */

/** What the last frame did with a piece of memory on the graphics queue. */
struct graph_tenant {
    uint64_t offset, size;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access; /* writes that nobody has waited for */
};

/**
 * Transient memory of one kind: all its resources are packed into one heap. Buffers have a heap for each frame in flight, so that what a
 * frame does first, culling and light lists, waits for nothing of the last one; images, which are larger, have one heap and wait.
 */
struct graph_pool {
    bool images;
    uint32_t memory_types;
    uint64_t needed;         /* by this frame's plan */
    uint32_t first_resource; /* by rising offset */
    struct graph_heap {
        struct gpu_heap memory; /* size 0: none yet */
        uint32_t oversized_frames;
    } heaps[GPU_FRAMES_IN_FLIGHT]; /* images: the first */
    ARRAY(struct graph_tenant) tenants; /* images */
};

/** A resource bound to a place in a pool's heap. */
struct graph_physical {
    uint64_t key;
    uint32_t pool, heap;
    bool is_image;
    uint64_t last_frame;
    struct gpu_image image;
    struct gpu_buffer buffer;
};

struct graph_history_entry {
    const char *name;
    struct graph_image_params params;
    struct gpu_image images[2];
    VkImageLayout layouts[2];
    struct graph_state states[2]; /* as the last frame that used them left them */
    uint32_t current; /* which of the two this frame writes */
    bool valid;       /* the other one holds the last frame's contents */
    uint64_t last_frame;
    struct graph_history handles; /* of this frame */
};

struct graph_requirements {
    uint64_t key;
    struct gpu_requirements requirements;
};

/** A pass with a timer. */
struct graph_timed {
    const char *name;
    enum gpu_queue queue;
    enum graph_role role;
};

/** Timers of the latest frame of a slot, and the results of that frame or, until it is over, of the one before. */
struct graph_timer_slot {
    uint64_t frame_number, results_frame;
    ARRAY(struct graph_timed) names;
    ARRAY(struct graph_timer) results;
};

/** All names that were ever made, and the scopes that are open. */
struct graph_names {
    struct arena arena; /* never reset */
    struct graph_kept_name *buckets[GRAPH_NAME_BUCKETS];
    const char *prefixes[GRAPH_NAME_SCOPES]; /* "left/shadows/" */
    uint32_t depth, lost;                    /* lost: pushes that found no room */
};

struct graph {
    fnl_host host;
    gpu_device *device; /* NULL: null back end */
    uint64_t frame;     /* frames declared so far */
    fnl_result result;  /* of this frame; the first error sticks */
    struct arena arena; /* lives for a frame */
    ARRAY(struct graph_resource) resources;
    ARRAY(struct graph_pass *) passes;
    const struct graph_scope *scope; /* the open one */
    enum graph_role role;            /* of new passes */
    struct graph_put *puts;
    struct graph_plan plan;
    bool executed;
    double place_milliseconds, record_milliseconds, submit_milliseconds; /* of the last frame executed */
    struct graph_names names;

    ARRAY(struct graph_pool) pools;
    ARRAY(struct graph_physical) physicals;
    ARRAY(struct graph_history_entry) histories;
    ARRAY(struct graph_requirements) requirements;
    struct gpu_last_uses *last_uses; /* the device's, or its own */
    struct gpu_last_uses own_uses;
    struct graph_timer_slot timer_slots[GPU_FRAMES_IN_FLIGHT];
};

/** The image that a layer belongs to, whose uses and memory the graph keeps; anything else itself. */
static inline const struct graph_resource *graph_whole(const struct graph *graph, const struct graph_resource *resource) {
    return resource->whole ? &graph->resources.data[resource->whole - 1] : resource;
}

/** Logs misuse and makes the frame fail. */
void graph_misuse(struct graph *graph, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** Makes the frame fail; whoever found the error logged it. */
void graph_fail(struct graph *graph, fnl_result result);
/** The resource of a handle; NULL when it is none, stale, or of the other kind. */
struct graph_resource *graph_find_resource(const struct graph *graph, uint32_t id, bool is_image);
/** D16, X8_D24, D32, S8, a stencil, and D32_S8, both. */
bool graph_is_depth_format(VkFormat format);
struct gpu_image_params graph_gpu_params(const struct graph_resource *resource);

void graph_names_init(struct graph *graph);
void graph_names_finish(struct graph *graph);
/** The name with the scopes that are open before it; NULL stays NULL. */
const char *graph_scoped_name(struct graph *graph, const char *name);
/** Misuse: two passes of one name, scopes that are still open. */
void graph_check_names(struct graph *graph);

/** Writes the addresses that a pass's rows ask for into its data. */
void graph_patch_data(const struct graph_context *context, const struct graph_pass *pass);
/** Writes those of graph_put_address. */
void graph_put_addresses(struct graph *graph);

/** Index of a resource among the attachments of a merged scope, or GRAPH_NONE. */
uint32_t graph_merged_attachment(const struct graph_merged *merged, uint32_t resource);
/** Makes one pass of the live passes of a merged scope that begin at `first`; NULL after an error. `next`: the pass after them. */
struct graph_pass *graph_merge(struct graph *graph, uint32_t first, uint32_t *next);
/** Of all mips, layers and samples. */
uint64_t graph_image_bytes(const struct graph_resource *resource);
/** graph_query_traffic of one step; the plan's uses are linked. */
uint32_t graph_step_traffic(const struct graph *graph, uint32_t step, struct graph_traffic *out, uint32_t capacity);
/** What the end of a step does with an attachment's contents. */
VkAttachmentStoreOp graph_store_op(const struct graph *graph, const struct graph_resource *resource, bool read_only,
                                   uint32_t step);

/** Compiles as if there were a compute queue (`async`) or not. */
fnl_result graph_compile_for(struct graph *graph, bool async);
/** Gives each transient resource of the plan a place in a pool. False when memory ran out. */
bool graph_place_resources(struct graph *graph);
/** Do two resources of the plan share memory? */
bool graph_overlaps(const struct graph_resource *a, const struct graph_resource *b);

/** Makes heaps, images and buffers of the plan real, and lets go of what has not been used for some frames. */
fnl_result graph_realise(struct graph *graph);
/** The plan was executed: histories keep what was written and swap with the next frame, which learns what it has to wait for. */
void graph_commit(struct graph *graph);
/** What a resource's last users left for this frame to wait for. False when memory ran out. */
bool graph_first_state(struct graph *graph, const struct graph_resource *resource, struct graph_state *out);
void graph_drop_history(struct graph *graph, uint32_t index);
/** Destroys all heaps and what lies in them. */
void graph_release_memory(struct graph *graph);

#endif
