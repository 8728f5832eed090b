/* SPDX-License-Identifier: MIT */
/**
 * The frame graph. A frame is declared pass by pass: handles in, handles out. Compiling (pure CPU) drops passes that
 * nobody needs, derives every barrier and layout, lays transient resources over one another in memory, and splits the
 * work between the graphics and the compute queue. The plan prints as stable text. Executing records the passes, on
 * several threads if asked, and submits. The graph is declared anew each frame; in a steady state it allocates nothing.
 * docs/frame-graph.md tells more.
 */
#ifndef FNL_GRAPH_GRAPH_H
#define FNL_GRAPH_GRAPH_H

#include "fanal/stats.h"
#include "gpu/gpu.h"

#include <string.h>

struct graph;
struct graph_pass;

typedef struct graph_image {
    uint32_t id;
} graph_image; /* id 0 is none */
typedef struct graph_buffer {
    uint32_t id;
} graph_buffer;

/** `device` NULL gives the null back end: everything but execution works, with invented memory sizes. */
fnl_result graph_create(const fnl_host *host, gpu_device *device, struct graph **out);
void graph_destroy(struct graph **graph);

/* ---- names ---- */

/**
 * Passes, merged scopes, buffers, images and histories declared until graph_pop_names are called `name`/…: "left/tiled count". Scopes nest,
 * up to 8 deep. So whatever adds passes can be added once for each view, and keeps a history for each. Imported resources keep their names.
 * What is not popped when the frame is compiled is misuse, and so is one pop too many.
 */
void graph_push_names(struct graph *graph, const char *name);
void graph_pop_names(struct graph *graph);
/**
 * A name made from parts, which lives as long as the graph; the same text gives the same pointer and allocates nothing. For the few names
 * of a renderer, not for numbers that rise from frame to frame. At most 255 bytes.
 */
const char *graph_name(struct graph *graph, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** "name number", or `name` alone where the number is 0: the first of several that the others are numbered after. */
const char *graph_numbered_name(struct graph *graph, const char *name, uint32_t number);

/* ---- declaring a frame ---- */

/** Forgets the last frame's declarations (not the history images, nor the memory). */
void graph_begin(struct graph *graph);

struct graph_image_params {
    const char *name; /* a string that lives as long as the graph: a literal, or of graph_name */
    VkFormat format;
    uint32_t width, height;
    uint32_t layers, mips, samples; /* 0 means 1 */
};
graph_image graph_create_image(struct graph *graph, const struct graph_image_params *params);
/**
 * One layer of an image that graph_create_image made with at most 64 of them, to use as an image of its own: as an attachment, sampled, as
 * storage or in copies; not in merged scopes. The graph knows which layers were written, but waits for the whole image and keeps it in one
 * layout. Asking twice gives the same handle. Of an image of one layer: that image.
 */
graph_image graph_image_layer(struct graph *graph, graph_image image, uint32_t layer);
graph_buffer graph_create_buffer(struct graph *graph, const char *name, uint64_t size);
/**
 * Resources that live outside of the graph; what they point to must stay until the frame is executed. Importing one twice
 * gives the same handle. The graph leaves an image in `final_layout` (UNDEFINED: in that of its last use); an
 * `initial_layout` of UNDEFINED means that its contents do not matter.
 */
graph_image graph_import_image(struct graph *graph, const struct gpu_image *image, VkImageLayout initial_layout,
                               VkImageLayout final_layout);
graph_buffer graph_import_buffer(struct graph *graph, const char *name, const struct gpu_buffer *buffer);
/**
 * An image that is kept from frame to frame under its name: `current` is this frame's to write, `previous` the last
 * frame's to read. `previous.id` is 0 in the first frame, after the size or format changed, and when the last frame did
 * not declare or not write it.
 */
struct graph_history {
    graph_image current, previous;
};
struct graph_history graph_history(struct graph *graph, const struct graph_image_params *params);

struct graph_image_params graph_image_info(const struct graph *graph, graph_image image);
uint64_t graph_buffer_size(const struct graph *graph, graph_buffer buffer);

/* ---- passes ---- */

enum graph_queue {
    GRAPH_QUEUE_GRAPHICS, /* draws, dispatches and copies */
    GRAPH_QUEUE_ASYNC,    /* dispatches and copies, on the compute queue where there is one */
};

struct graph_context; /* what a pass gets to record with */
typedef void graph_execute(const struct graph_context *context, const void *data);

/** What a pass is for. Timers are found by it, not by names. */
enum graph_role {
    GRAPH_ROLE_REST,
    GRAPH_ROLE_GEOMETRY, /* what is where: culling, deforming, drawing without light */
    GRAPH_ROLE_LISTS,    /* which lights reach what */
    GRAPH_ROLE_SHADOWS,
    GRAPH_ROLE_SHADOW_FILL,  /* of these: draws pages of maps, whose time hybrid shadows learn */
    GRAPH_ROLE_SHADOW_PROBE, /* of these: sends rays for their time */
    GRAPH_ROLE_SHADING,
    GRAPH_ROLE_READ, /* hands results to the CPU */
};
/** Sets the role of passes added from now on and returns the previous role. Each frame begins with REST. */
enum graph_role graph_set_role(struct graph *graph, enum graph_role role);
/** The public value of a role. */
fnl_pass_role graph_pass_role(enum graph_role role);

/**
 * `name` is also the debug label and the timer's name; names must be unique in a frame and live as long as the graph.
 * `execute` may be NULL (a pass that only clears, or only hands something to the host). `data` (may be NULL) is copied. Passes run in the
 * order they are added in; those that may be on different queues only as far as their uses demand. NULL when memory ran out: the calls
 * below accept that, and compiling then fails.
 */
struct graph_pass *graph_add_pass(struct graph *graph, const char *name, enum graph_queue queue, graph_execute *execute,
                                  const void *data, size_t data_size);

/** A pass that fills whole buffers with a word; ids of 0 are passed over. */
struct graph_clear {
    graph_buffer buffers[3];
    uint32_t word;
};
void graph_add_clear(struct graph *graph, const char *name, enum graph_queue queue, struct graph_clear clear);

enum graph_use {
    GRAPH_SAMPLE_COMPUTE, /* image: texture reads */
    GRAPH_SAMPLE_FRAGMENT,
    GRAPH_READ_COMPUTE,  /* storage image or buffer */
    GRAPH_WRITE_COMPUTE, /* what was there does not matter to the pass, but texels it does not write keep their values */
    GRAPH_READ_WRITE_COMPUTE,
    GRAPH_READ_VERTEX, /* buffer, by address, in vertex shaders */
    GRAPH_READ_MESH,   /* the same in mesh shaders, on devices that have them */
    GRAPH_READ_FRAGMENT,
    GRAPH_READ_GRAPHICS,       /* buffer: in vertex and fragment shaders */
    GRAPH_WRITE_FRAGMENT,      /* buffer: as GRAPH_WRITE_COMPUTE */
    GRAPH_READ_WRITE_FRAGMENT, /* atomics from fragment shaders */
    GRAPH_INDIRECT,            /* buffer: indirect commands */
    GRAPH_INDEX,               /* buffer: indices */
    GRAPH_COPY_FROM,
    GRAPH_COPY_TO,
    GRAPH_BUILD_INPUT,   /* buffer: triangles or instances that acceleration structures are built of, on devices that have them */
    GRAPH_BUILD_SCRATCH, /* buffer: what the device needs to build them */
    GRAPH_BUILD,         /* imported buffer: acceleration structures that are built, updated, measured or copied */
    GRAPH_BUILD_READ,    /* … that others are built of */
    GRAPH_TRACE_COMPUTE, /* … that compute shaders trace rays through */
    GRAPH_TRACE_FRAGMENT,
    GRAPH_READ_HOST, /* imported buffer: read by the CPU after the frame; keeps the pass */
};
/** Several uses of one resource by one pass add up; those of an image must agree on the layout. */
void graph_use_image(struct graph_pass *pass, graph_image image, enum graph_use use);
void graph_use_buffer(struct graph_pass *pass, graph_buffer buffer, enum graph_use use);

/**
 * A row: a use of a resource, and the member of the pass's data that tells the shader where it is. The graph writes buffer addresses,
 * sampled indices and storage indices (as the use is) into its copy of the data before the pass is recorded, so that nothing can be
 * passed on that was not declared. Rows are made by the functions below; of a `member` NULL the use alone counts (the shader finds the
 * resource by another way, or an earlier row tells it). A handle of 0 is misuse: rows that are not always there go through graph_row_if.
 */
struct graph_row {
    const void *member;
    uint32_t id;
    bool is_image, is_absent;
    enum graph_use use;
    uint64_t offset; /* added to the address of a buffer */
};
static inline struct graph_row graph_buffer_row(const uint64_t *member, graph_buffer buffer, enum graph_use use) {
    return (struct graph_row){.member = member, .id = buffer.id, .use = use};
}
static inline struct graph_row graph_image_row(const uint32_t *member, graph_image image, enum graph_use use) {
    return (struct graph_row){.member = member, .id = image.id, .is_image = true, .use = use};
}
/* What compute shaders do to buffers: */
static inline struct graph_row graph_reads(const uint64_t *member, graph_buffer buffer) {
    return graph_buffer_row(member, buffer, GRAPH_READ_COMPUTE);
}
static inline struct graph_row graph_writes(const uint64_t *member, graph_buffer buffer) {
    return graph_buffer_row(member, buffer, GRAPH_WRITE_COMPUTE);
}
static inline struct graph_row graph_changes(const uint64_t *member, graph_buffer buffer) {
    return graph_buffer_row(member, buffer, GRAPH_READ_WRITE_COMPUTE);
}
/* … and to images: */
static inline struct graph_row graph_samples(const uint32_t *member, graph_image image) {
    return graph_image_row(member, image, GRAPH_SAMPLE_COMPUTE);
}
static inline struct graph_row graph_stores(const uint32_t *member, graph_image image) {
    return graph_image_row(member, image, GRAPH_WRITE_COMPUTE);
}
static inline struct graph_row graph_row_if(bool condition, struct graph_row row) {
    row.is_absent = !condition;
    return row;
}
/** The row, with the address so many bytes into the buffer. */
static inline struct graph_row graph_row_at(uint64_t offset, struct graph_row row) {
    row.offset = offset;
    return row;
}
/** Adds a row to a pass. The member is one of the `data` that graph_add_pass copied, or of the `push` of graph_dispatch. */
void graph_add_row(struct graph_pass *pass, struct graph_row row);

/**
 * A pass that is one dispatch: its uses, its push constants and its pipeline in one statement.
 *
 *     struct gpu_blur_push push = {.radius = 3};
 *     graph_dispatch(graph, &(struct graph_dispatch){.name = "blur",
 *                                                    .pipeline = {.shader = &shader_blur_comp},
 *                                                    .groups = {DIVIDE_UP(width, 8u), DIVIDE_UP(height, 8u)},
 *                                                    GRAPH_PUSH(push),
 *                                                    GRAPH_ROWS(graph_samples(&push.from, from), graph_stores(&push.to, to))});
 *
 * While `push` is in scope, more rows and uses may be added to the pass. Where one pass is several dispatches, each has its own pipeline,
 * groups, push constants and rows, and no barrier stands between them; rows that are added to the pass are of the last one:
 *
 *     for (uint32_t i = 0; i < count; i++) pass = graph_dispatch(graph, &(struct graph_dispatch){.pass = pass, …});
 */
struct graph_dispatch {
    struct graph_pass *pass; /* NULL (default): a new pass. Else one that graph_dispatch added, for one more dispatch in it */
    const char *name;        /* this and the queue: of a new pass */
    enum graph_queue queue; /* default GRAPH_QUEUE_GRAPHICS */
    struct gpu_compute_params pipeline;
    uint32_t groups[3];     /* work groups; with a height of 0 as many as gpu_dispatch_linear makes of the width, which may be 0 too */
    graph_buffer indirect;  /* id 0 (default): `groups`. Else these are read at indirect_offset, and the row is added */
    uint64_t indirect_offset;
    const void *push; /* copied; NULL: none */
    size_t push_size;
    const struct graph_row *rows;
    uint32_t row_count;
};
#define GRAPH_PUSH(push_) .push = &(push_), .push_size = sizeof(push_)
#define GRAPH_ROWS(...)                                                                                                     \
    .rows = (const struct graph_row[]){__VA_ARGS__},                                                                        \
    .row_count = (uint32_t)(sizeof((const struct graph_row[]){__VA_ARGS__}) / sizeof(struct graph_row))
struct graph_pass *graph_dispatch(struct graph *graph, const struct graph_dispatch *dispatch);

/**
 * Writes the address of a buffer to memory that the host and shaders share (gpu_frame_allocate), before the frame's passes are recorded:
 * for tables of addresses that several passes read. Those passes declare their uses of the buffer themselves. 0 where no pass needs it.
 */
void graph_put_address(struct graph *graph, uint64_t *place, graph_buffer buffer);
/** The address so many bytes into the buffer. */
void graph_put_address_at(struct graph *graph, uint64_t *place, graph_buffer buffer, uint64_t offset);
/** The same for the index by which an image is sampled; GPU_NO_INDEX where no pass needs it. */
void graph_put_sampled(struct graph *graph, uint32_t *place, graph_image image);

/** Attachments: the graph begins and ends rendering around the pass. All must have the same size and samples. */
void graph_color(struct graph_pass *pass, graph_image image, VkAttachmentLoadOp load, const float clear[4]);
/** Multisampled colour attachment `index` (in the order of graph_color) is averaged into `image` at the end. */
void graph_resolve(struct graph_pass *pass, uint32_t index, graph_image image);
/** An image of S8_UINT is attached as the stencil, one of D32_SFLOAT_S8_UINT as both, its stencil cleared to 0; neither can be sampled. */
void graph_depth(struct graph_pass *pass, graph_image image, VkAttachmentLoadOp load, float clear_depth);
/** Depth test without writes; the image may be sampled by the same pass. */
void graph_depth_read_only(struct graph_pass *pass, graph_image image);
/**
 * What the pass draws goes to each layer of its attachments whose bit is set (multiview): gl_ViewIndex tells shaders which one it is. Other
 * layers keep what they hold or are left undefined, as the load operations say. Not in scopes; bits below fnl_device_info.max_views. 0: layer 0
 * alone, as without this call.
 */
void graph_view_mask(struct graph_pass *pass, uint32_t mask);
/** In place of it: vertex shaders choose among the first `count` layers (gl_Layer). Not in scopes; with fnl_device_info.vertex_layers. */
void graph_vertex_layers(struct graph_pass *pass, uint32_t count);
/**
 * Passes added until graph_end_scope draw one over the other in one rendering scope (gpu.h): what they leave at a pixel stays in tile
 * memory for the next one to read at the same pixel, and only what is used after the scope is stored. All must be graphics passes with
 * attachments of one size, single-sampled; only the first that has an attachment may clear it. An image is either an attachment (or local
 * read) or something else in a scope. Buffers that one pass writes and another uses are for fragment shaders at the same pixel.
 * Returns true when they are merged so. False when the device cannot, or `separate` forbids it: then they are passes as any other, and
 * local reads are sampled reads; shaders differ. `name`, which is unique among passes, names the label and the timer of the whole.
 */
struct graph_scope_params {
    const char *name;
    uint32_t most_colors, most_inputs; /* in any of the passes */
    bool separate;
};
bool graph_begin_scope(struct graph *graph, const struct graph_scope_params *params);
void graph_end_scope(struct graph *graph);
/** In a scope: the fragment shader reads `image`, a colour attachment, at its own pixel; merged, it is input attachment `input`. */
void graph_local_read(struct graph_pass *pass, uint32_t input, graph_image image);
/**
 * graph_local_read of what is also the pass's next colour attachment. Returns the image to use from here on: merged, the same one; else a
 * new one like it, all of whose pixels the pass must write.
 */
graph_image graph_local_rewrite(struct graph_pass *pass, uint32_t input, graph_image image);

/** The pass runs even if nothing reads what it writes. Passes that write imported or history resources are always kept. */
void graph_keep(struct graph_pass *pass);

/* ---- compile and execute ---- */

/**
 * Misuse (reading what was never written, a stale handle, attachments of different sizes …) fails with the pass and the
 * resource named in the log; the next frame starts afresh. Without a device, plans are made as if there were a compute queue.
 */
fnl_result graph_compile(struct graph *graph);
/**
 * The compiled plan: passes in order with queue, barriers and layouts; batches with waits; memory with offsets and
 * lifetimes. Stable: two compiles print the same. Writes at most `capacity` bytes with a terminating zero; returns the
 * length it wants.
 */
size_t graph_print(const struct graph *graph, char *text, size_t capacity);
/** The same as JSON (docs/frame-graph.md), with what resources are and the load and store operations of attachments; "null" without a plan. */
size_t graph_print_json(const struct graph *graph, char *text, size_t capacity);

struct graph_execute_params {
    uint32_t record_threads;      /* 0: as many as the device's job pool has */
    bool timers;                  /* write timestamps around every pass */
    bool force_async_on_graphics; /* tests: compile for a compute queue although the device has none; its batches then go
                                     to the graphics queue in their own submissions */
    bool poison; /* tests: fills all transient buffers with rubbish first, so that what is read before it is written shows */
    const struct gpu_external_semaphores *external; /* or NULL */
};
/**
 * Between gpu_frame_begin and the end of the frame: records all passes and calls gpu_frame_end, after an error too.
 * `params` may be NULL. Execute functions run on the threads of the device's job pool, several at once.
 */
fnl_result graph_execute_frame(struct graph *graph, const struct graph_execute_params *params);

/**
 * In place of executing, between gpu_frame_begin and the end of the frame: asks for the pipelines of all passes (gpu_ask_begin; the ticket is
 * gpu_ask_end's). Nothing is recorded, and transient resources get no memory. Execute functions run on the calling thread, with images and
 * buffers that have nothing but their sizes.
 */
fnl_result graph_ask_pipelines(struct graph *graph, uint64_t *out_ticket);

/**
 * Timers of a frame, in pass order; false when there are none. Frame N - GPU_FRAMES_IN_FLIGHT, with N the latest executed,
 * is at hand; a later one is waited for; an earlier one is forgotten. Culled passes and those after the 1024th do not
 * appear. `out` is valid until the next execute. Names are those of passes, with their scopes.
 */
struct graph_timer {
    const char *name;
    double begin_milliseconds; /* since the first pass of the frame began */
    double milliseconds;
    enum gpu_queue queue;
    enum graph_role role; /* a merged scope has the role of its first pass */
};
bool graph_query_timers(struct graph *graph, uint64_t frame_number, const struct graph_timer **out, uint32_t *out_count);

struct graph_stats {
    uint32_t pass_count, culled_pass_count, barrier_count, batch_count; /* a merged scope is one pass */
    uint64_t transient_bytes, transient_bytes_unaliased;
    uint64_t image_bytes_read, image_bytes_written; /* of graph_query_traffic */
    uint64_t tile_bytes; /* of images that live in one scope or pass as attachments: usage TRANSIENT_ATTACHMENT */
    double compile_milliseconds;
    double place_milliseconds, record_milliseconds, submit_milliseconds; /* of the last execute, which does these one after the other */
};
/** Of the last compile. */
struct graph_stats graph_query_stats(const struct graph *graph);

/**
 * What a pass moves between an image and memory, by formats and load and store operations, not measured: each attachment that is loaded or
 * stored, and each image that is sampled or is storage, counts once as a whole (caches, compression and texels left out are not known
 * here); local reads of a merged scope count nothing, nor do copies.
 */
struct graph_traffic {
    const char *pass, *image; /* of a merged scope: its name */
    VkFormat format;
    bool attachment, transient; /* transient: has no memory on devices that keep it in tiles */
    VkAttachmentLoadOp load;    /* attachments */
    VkAttachmentStoreOp store;
    uint64_t bytes_read, bytes_written;
};
/** Of the last compile, in order of passes; writes at most `capacity` and returns how many there are. */
uint32_t graph_query_traffic(const struct graph *graph, struct graph_traffic *out, uint32_t capacity);
/** The same as a table for people; writes and returns as graph_print. */
size_t graph_print_traffic(const struct graph *graph, char *text, size_t capacity);
/** Lazily allocated memory of transient attachments: reserved, and of it what the driver had to back. 0 where there is none. */
struct graph_lazy_memory {
    uint64_t reserved_bytes, committed_bytes;
} graph_query_lazy_memory(struct graph *graph);

/* ---- inside a pass ---- */

struct graph_context {
    struct gpu_commands *commands;
    gpu_device *device;
    const struct graph *graph;
    const struct gpu_scope *scope; /* merged scopes: the one that the pass is step `scope_step` of */
    uint32_t scope_step;
    uint32_t view_mask; /* of graph_view_mask */
};
/** The graphics pipeline for drawing in this pass, merged or not. */
static inline const struct gpu_pipeline *graph_pipeline(const struct graph_context *context,
                                                        const struct gpu_graphics_params *params) {
    if (!context->scope && !context->view_mask) return gpu_graphics_pipeline(context->device, params);
    struct gpu_graphics_params own;
    memcpy(&own, params, sizeof own); /* hashed as bytes */
    own.scope = context->scope;
    own.scope_step = context->scope_step;
    own.view_mask = context->view_mask;
    return gpu_graphics_pipeline(context->device, &own);
}
/** The context must be the one that the execute function was given. A resource that the pass did not declare is misuse. */
const struct gpu_image *graph_get_image(const struct graph_context *context, graph_image image);
const struct gpu_buffer *graph_get_buffer(const struct graph_context *context, graph_buffer buffer);
static inline uint32_t graph_sampled(const struct graph_context *context, graph_image image) {
    return graph_get_image(context, image)->sampled_index;
}
static inline uint32_t graph_storage(const struct graph_context *context, graph_image image) {
    return graph_get_image(context, image)->storage_index;
}
static inline VkDeviceAddress graph_address(const struct graph_context *context, graph_buffer buffer) {
    return graph_get_buffer(context, buffer)->address;
}

#endif
