/* SPDX-License-Identifier: MIT */
/**
 * Random frames against an exhaustive checker. The checker knows Vulkan's rules of execution and memory dependencies and
 * the declared uses, not how plans are made: it follows every single access of two frames in a row, equal ones and different ones, through
 * the barriers and semaphores of their plans and demands that each later conflicting access, or change of layout, is ordered after it.
 */
#include "graph/graph_internal.h"

#include <setjmp.h>

#include <cmocka.h>

enum { GRAPHS = 1000, FRAMES = 2, MAX_BATCHES = 64 };

static const VkPipelineStageFlags2 HOST = VK_PIPELINE_STAGE_2_HOST_BIT;
static const VkAccessFlags2 WRITES = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                                     VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;

static VkPipelineStageFlags2 expand_stages(VkPipelineStageFlags2 stages) {
    return stages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT ? ~HOST | (stages & HOST) : stages;
}

static VkAccessFlags2 expand_access(VkAccessFlags2 access) {
    if (access & VK_ACCESS_2_MEMORY_WRITE_BIT) access |= WRITES;
    if (access & VK_ACCESS_2_MEMORY_READ_BIT) access |= ~WRITES;
    return access;
}

/** One stage of one access, or a change of layout by a barrier. */
struct probe {
    uint32_t frame, step; /* step GRAPH_NONE: a change of layout */
    const struct graph_barrier *transition;
    uint32_t resource;
    VkPipelineStageFlags2 stage;
    VkAccessFlags2 access;
    bool writes;
};

/** What is known to come after the probe, by queue. */
struct follow {
    const struct graph *graphs[FRAMES];
    struct probe probe;
    bool happened[2]; /* on this queue */
    VkPipelineStageFlags2 after[2];
    bool available;
    VkAccessFlags2 visible[2][64]; /* by stage bit */
    bool reached[FRAMES * MAX_BATCHES];
    uint32_t errors;
};

static void complain(struct follow *follow, uint32_t frame, const char *what, const char *where, uint32_t resource) {
    const struct probe *probe = &follow->probe;
    const struct graph *graph = follow->graphs[probe->frame];
    if (follow->errors++ > 3) return;
    print_error("frame %u: '%s' in %s %s after %s of '%s' in frame %u\n", frame,
                follow->graphs[frame]->resources.data[resource].name, where, what, probe->step == GRAPH_NONE ? "a change of layout" : graph->plan.steps[probe->step].pass->name,
                graph->resources.data[probe->resource].name, probe->frame);
}

/* A resource of a frame. */
struct place {
    const struct graph *graph;
    uint32_t frame, index;
    const struct graph_resource *resource;
};

static struct place place_of(const struct follow *follow, uint32_t frame, uint32_t index) {
    return (struct place){follow->graphs[frame], frame, index, &follow->graphs[frame]->resources.data[index]};
}

static uint32_t history_image(const struct place *place) {
    uint32_t current = place->graph->histories.data[place->resource->history].current;
    return place->resource->role == GRAPH_HISTORY_CURRENT ? current : current ^ 1;
}

/* One image or buffer, not only its memory; the two images of a history swap from frame to frame. */
static bool is_same(const struct place *a, const struct place *b) {
    if (a->frame == b->frame) return a->index == b->index;
    if (a->resource->is_image != b->resource->is_image) return false;
    if (a->resource->imported && b->resource->imported)
        return a->resource->image == b->resource->image && a->resource->buffer == b->resource->buffer;
    return a->resource->role && b->resource->role && a->resource->history == b->resource->history &&
           history_image(a) == history_image(b);
}

/* Buffers have memory of their own in each frame in flight. */
static bool conflicts(const struct place *a, const struct place *b) {
    const struct graph_resource *first = a->resource, *second = b->resource;
    if (is_same(a, b)) return true;
    if (a->frame != b->frame && !first->is_image) return false;
    return first->pool == second->pool && first->pool != GRAPH_NONE && first->offset < second->offset + second->size &&
           second->offset < first->offset + first->size;
}

static bool has_happened(const struct follow *follow) { return follow->happened[0] || follow->happened[1]; }

/* One barrier of a call; `old` is what came after the probe before the call. */
static void follow_barrier(struct follow *follow, uint32_t frame, uint32_t queue, const struct follow *old,
                           uint32_t resource, VkPipelineStageFlags2 from, VkAccessFlags2 from_access, VkPipelineStageFlags2 to,
                           VkAccessFlags2 to_access) {
    const struct probe *probe = &follow->probe;
    from = expand_stages(from);
    to = expand_stages(to);
    bool direct = old->happened[queue] && (from & probe->stage);
    if (!direct && !(from & old->after[queue])) return;
    follow->after[queue] |= to;
    if (!probe->writes) return;
    if (resource != GRAPH_NONE) {
        const struct place here = place_of(follow, frame, resource), there = place_of(follow, probe->frame, probe->resource);
        if (!is_same(&here, &there)) return;
    }
    bool available = old->available || (direct && (expand_access(from_access) & probe->access));
    follow->available |= available;
    if (!available) return;
    for (uint32_t bit = 0; bit < 64; bit++)
        if (to >> bit & 1) follow->visible[queue][bit] |= expand_access(to_access);
}

static void follow_barriers(struct follow *follow, uint32_t frame, uint32_t queue, const struct graph_barriers *barriers) {
    struct follow old = *follow;
    const struct probe *probe = &follow->probe;
    if (barriers->from_stages)
        follow_barrier(follow, frame, queue, &old, GRAPH_NONE, barriers->from_stages, barriers->from_access, barriers->to_stages,
                       barriers->to_access);
    for (const struct graph_barrier *barrier = barriers->first; barrier; barrier = barrier->next)
        follow_barrier(follow, frame, queue, &old, barrier->resource, barrier->from_stages, barrier->from_access,
                       barrier->to_stages, barrier->to_access);
    for (const struct graph_barrier *barrier = barriers->first; barrier; barrier = barrier->next) {
        if (barrier->from_layout == barrier->to_layout) continue;
        bool is_probe = probe->transition == barrier && probe->frame == frame;
        const struct place here = place_of(follow, frame, barrier->resource),
                           there = place_of(follow, probe->frame, probe->resource);
        if (!is_probe && has_happened(&old) && conflicts(&here, &there)) {
            VkPipelineStageFlags2 from = expand_stages(barrier->from_stages);
            if (!(from & old.after[queue]) && !(old.happened[queue] && (from & probe->stage)))
                complain(follow, frame, "changes layout unordered", "a barrier", barrier->resource);
            else if (probe->writes && !follow->available)
                complain(follow, frame, "changes layout before writes are available", "a barrier", barrier->resource);
        }
        if (!is_probe) continue;
        follow->happened[queue] = true;
        follow->available = true; /* a change of layout makes its own writes available */
        follow->after[queue] |= expand_stages(barrier->to_stages);
        for (uint32_t bit = 0; bit < 64; bit++)
            if (expand_stages(barrier->to_stages) >> bit & 1)
                follow->visible[queue][bit] |= expand_access(barrier->to_access);
    }
}

static void check_use(struct follow *follow, uint32_t frame, uint32_t queue, const char *where,
                      const struct graph_access *use) {
    const struct probe *probe = &follow->probe;
    const struct place here = place_of(follow, frame, use->resource), there = place_of(follow, probe->frame, probe->resource);
    if (!conflicts(&here, &there)) return;
    bool same = is_same(&here, &there);
    if (same && !probe->writes && !use->writes) return;
    VkPipelineStageFlags2 after = follow->after[queue];
    if (!has_happened(follow) || (use->stages & ~after)) {
        complain(follow, frame, "is not ordered", where, use->resource);
        return;
    }
    if (!probe->writes) return;
    if (!follow->available)
        complain(follow, frame, "is ordered, but memory is not available", where, use->resource);
    else if (use->reads && same)
        for (uint32_t bit = 0; bit < 64; bit++)
            if (use->stages >> bit & 1 && !(follow->visible[queue][bit] & use->access))
                complain(follow, frame, "is ordered, but writes are not visible", where, use->resource);
}

static void follow_step(struct follow *follow, uint32_t frame, uint32_t index) {
    const struct graph_step *step = &follow->graphs[frame]->plan.steps[index];
    const struct probe *probe = &follow->probe;
    follow_barriers(follow, frame, step->queue, &step->before);
    if (probe->step == index && probe->frame == frame) {
        follow->happened[step->queue] = true;
        return;
    }
    bool declared_before =
        frame < probe->frame || (frame == probe->frame && probe->step != GRAPH_NONE && index < probe->step);
    bool submitted_before = probe->step == GRAPH_NONE && !has_happened(follow);
    for (const struct graph_access *use = step->pass->first_use; use; use = use->next) {
        if (submitted_before) continue; /* follow_barriers of that access's own probe looks at it */
        if (!declared_before)
            check_use(follow, frame, step->queue, step->pass->name, use);
        else if (has_happened(follow) && (probe->writes || use->writes)) {
            const struct place here = place_of(follow, frame, use->resource),
                               there = place_of(follow, probe->frame, probe->resource);
            if (conflicts(&here, &there)) complain(follow, frame, "is submitted", step->pass->name, use->resource);
        }
    }
}

static uint32_t run_probe(const struct graph *const graphs[FRAMES], const struct probe *probe) {
    struct follow follow = {.graphs = {graphs[0], graphs[1]}, .probe = *probe};
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        const struct graph *graph = graphs[frame];
        const struct graph_plan *plan = &graph->plan;
        for (uint32_t b = 0; b < plan->batch_count; b++) {
            const struct graph_batch *batch = &plan->batches[b];
            uint32_t queue = batch->queue;
            if (batch->wait != GRAPH_NONE && follow.reached[frame * MAX_BATCHES + batch->wait]) {
                follow.after[queue] = ~HOST;
                follow.available = true;
                memset(follow.visible[queue], 0xff, sizeof follow.visible[queue]);
            }
            for (uint32_t step = batch->first_step; step != GRAPH_NONE; step = plan->steps[step].next_in_batch)
                follow_step(&follow, frame, step);
            follow_barriers(&follow, frame, queue, &batch->after);
            follow.reached[frame * MAX_BATCHES + b] = follow.happened[queue] || follow.after[queue];
        }
        if (probe->step == GRAPH_NONE || frame != probe->frame || !graph->resources.data[probe->resource].host_read)
            continue;
        if (probe->writes && !((follow.after[GPU_QUEUE_GRAPHICS] & HOST) && follow.available))
            complain(&follow, frame, "is not ordered", "the host's reads", probe->resource);
    }
    return follow.errors;
}

/* Of what the first of two frames does. */
static uint32_t check_hazards(const struct graph *const graphs[FRAMES]) {
    const struct graph_plan *plan = &graphs[0]->plan;
    uint32_t errors = 0;
    for (uint32_t i = 0; i < plan->step_count; i++) {
        for (const struct graph_access *use = plan->steps[i].pass->first_use; use; use = use->next)
            for (uint32_t bit = 0; bit < 64; bit++)
                if (use->stages >> bit & 1)
                    errors += run_probe(
                        graphs, &(struct probe){0, i, NULL, use->resource, 1ull << bit, use->access & WRITES, use->writes});
        for (const struct graph_barrier *barrier = plan->steps[i].before.first; barrier; barrier = barrier->next)
            if (barrier->from_layout != barrier->to_layout)
                errors += run_probe(graphs, &(struct probe){0, GRAPH_NONE, barrier, barrier->resource, 0, 0, true});
    }
    for (uint32_t b = 0; b < plan->batch_count; b++)
        for (const struct graph_barrier *barrier = plan->batches[b].after.first; barrier; barrier = barrier->next)
            if (barrier->from_layout != barrier->to_layout)
                errors += run_probe(graphs, &(struct probe){0, GRAPH_NONE, barrier, barrier->resource, 0, 0, true});
    return errors;
}

/* ---- layouts, contents and queues, in order of submission ---- */

/* Vulkan wants each access to belong to one of the stages. */
static bool fits_stages(VkPipelineStageFlags2 stages, VkAccessFlags2 access) {
    static const struct {
        VkAccessFlags2 access;
        VkPipelineStageFlags2 stages;
    } rules[] = {
        {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
        {VK_ACCESS_2_INDEX_READ_BIT, VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT},
        {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
         VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
             VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT},
        {VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
         VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT},
        {VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
         VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT},
        {VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT},
        {VK_ACCESS_2_HOST_READ_BIT, VK_PIPELINE_STAGE_2_HOST_BIT},
    };
    for (uint32_t i = 0; i < COUNT_OF(rules); i++)
        if ((access & rules[i].access) && !(expand_stages(stages) & rules[i].stages)) return false;
    return true;
}

struct contents {
    VkImageLayout layout;
    bool valid;
};

static uint32_t apply_barriers(const struct graph *graph, const struct graph_barriers *barriers, enum gpu_queue queue,
                               struct contents *contents) {
    const VkPipelineStageFlags2 compute_stages =
        VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT |
        VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT | VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    uint32_t errors = 0;
    errors +=
        !fits_stages(barriers->from_stages, barriers->from_access) || !fits_stages(barriers->to_stages, barriers->to_access);
    if (queue == GPU_QUEUE_COMPUTE) errors += ((barriers->from_stages | barriers->to_stages) & ~compute_stages) != 0;
    for (const struct graph_barrier *barrier = barriers->first; barrier; barrier = barrier->next) {
        struct contents *image = &contents[barrier->resource];
        if (queue == GPU_QUEUE_COMPUTE) {
            errors += ((barrier->from_stages | barrier->to_stages) & ~compute_stages) != 0;
            errors += barrier->from_layout == VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL ||
                      barrier->from_layout == VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
        }
        errors +=
            !fits_stages(barrier->from_stages, barrier->from_access) || !fits_stages(barrier->to_stages, barrier->to_access);
        errors += barrier->from_stages == 0 || barrier->to_stages == 0 || barrier->to_layout == VK_IMAGE_LAYOUT_UNDEFINED;
        if (barrier->from_layout == VK_IMAGE_LAYOUT_UNDEFINED)
            image->valid = false;
        else
            errors += barrier->from_layout != image->layout;
        image->layout = barrier->to_layout;
        if (errors) print_error("wrong barrier of '%s'\n", graph->resources.data[barrier->resource].name);
    }
    return errors;
}

static uint32_t check_contents(const struct graph *graph) {
    const struct graph_plan *plan = &graph->plan;
    struct contents contents[64];
    uint32_t errors = 0;
    assert_true(graph->resources.count <= COUNT_OF(contents));
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *resource = &graph->resources.data[i];
        contents[i] = (struct contents){resource->has_contents ? resource->initial_layout : VK_IMAGE_LAYOUT_UNDEFINED,
                                        resource->has_contents};
    }
    for (uint32_t b = 0; b < plan->batch_count; b++) {
        const struct graph_batch *batch = &plan->batches[b];
        if (batch->wait != GRAPH_NONE) errors += batch->wait >= b || plan->batches[batch->wait].queue == batch->queue;
        for (uint32_t i = batch->first_step; i != GRAPH_NONE; i = plan->steps[i].next_in_batch) {
            errors += apply_barriers(graph, &plan->steps[i].before, batch->queue, contents);
            for (const struct graph_access *use = plan->steps[i].pass->first_use; use; use = use->next) {
                const struct graph_resource *resource = &graph->resources.data[use->resource];
                bool wrong = (use->reads && !contents[use->resource].valid) ||
                             (resource->is_image && contents[use->resource].layout != use->layout) ||
                             (resource->usage & use->usage) != use->usage;
                if (wrong)
                    print_error("pass '%s' finds '%s' without contents, usage, or in another layout\n",
                                plan->steps[i].pass->name, resource->name);
                errors += wrong;
            }
            for (const struct graph_access *use = plan->steps[i].pass->first_use; use; use = use->next)
                contents[use->resource].valid |= use->writes;
        }
        errors += apply_barriers(graph, &batch->after, batch->queue, contents);
    }
    errors += plan->batches[plan->batch_count - 1].queue != GPU_QUEUE_GRAPHICS;
    for (uint32_t i = 0; i < graph->resources.count; i++) {
        const struct graph_resource *resource = &graph->resources.data[i];
        if (resource->final_layout != VK_IMAGE_LAYOUT_UNDEFINED && resource->final_layout != contents[i].layout) errors++;
    }
    return errors;
}

/* ---- culling: what a live pass reads was written by live passes only, and what outlives the frame is written ---- */

static const struct graph_access *find_use(const struct graph_pass *pass, uint32_t resource) {
    const struct graph_access *use = pass->first_use;
    while (use && use->resource != resource) use = use->next;
    return use;
}

static uint32_t check_culling(const struct graph *graph) {
    uint32_t errors = 0;
    for (uint32_t i = 0; i < graph->passes.count; i++) {
        const struct graph_pass *pass = graph->passes.data[i];
        bool wanted = pass->keep;
        for (const struct graph_access *use = pass->first_use; use; use = use->next) {
            const struct graph_resource *resource = &graph->resources.data[use->resource];
            if (use->writes && (resource->imported || resource->role)) wanted = true;
            if (use->writes) { /* does a live pass read it before it is replaced? */
                for (uint32_t j = i + 1; j < graph->passes.count; j++) {
                    const struct graph_access *later = find_use(graph->passes.data[j], use->resource);
                    if (!later || !graph->passes.data[j]->live) continue;
                    if (later->reads) wanted = true;
                    if (later->reads || later->discards) break;
                }
            }
        }
        if (wanted != pass->live) {
            print_error("pass '%s' is %s\n", pass->name, pass->live ? "kept for nothing" : "missing");
            errors++;
        }
    }
    return errors;
}

/* ---- random frames ---- */

enum { PASSES = 14, COLORS = 5, DEPTHS = 2, STORAGES = 4, BUFFERS = 5 };

struct frame {
    struct graph *graph;
    struct random_state random;
    uint32_t count;
    struct {
        uint32_t id;
        bool image, attachment, depth, written, read_only, imported;
        uint32_t size;
    } resources[32];
};

static uint32_t dice(struct frame *frame, uint32_t sides) { return (uint32_t)(random_bits(&frame->random) % sides); }

static const char *const names[32] = {"r0",  "r1",  "r2",  "r3",  "r4",  "r5",  "r6",  "r7",  "r8",  "r9",  "r10",
                                      "r11", "r12", "r13", "r14", "r15", "r16", "r17", "r18", "r19", "r20", "r21",
                                      "r22", "r23", "r24", "r25", "r26", "r27", "r28", "r29", "r30", "r31"};
static const char *const pass_names[PASSES] = {"p0", "p1", "p2", "p3",  "p4",  "p5",  "p6",
                                               "p7", "p8", "p9", "p10", "p11", "p12", "p13"};

static struct gpu_image imported_images[3] = {
    {.params = {.name = "i0",
                .format = VK_FORMAT_R8G8B8A8_UNORM,
                .width = 64,
                .height = 64,
                .layers = 1,
                .mips = 1,
                .samples = 1}},
    {.params = {.name = "i1",
                .format = VK_FORMAT_R8G8B8A8_UNORM,
                .width = 64,
                .height = 64,
                .layers = 1,
                .mips = 1,
                .samples = 1}},
    {.params = {.name = "i2",
                .format = VK_FORMAT_R8G8B8A8_UNORM,
                .width = 256,
                .height = 64,
                .layers = 1,
                .mips = 1,
                .samples = 1}},
};
static struct gpu_buffer imported_buffers[2] = {{.size = 64}, {.size = 128}};

static void declare_resources(struct frame *frame) {
    const uint32_t widths[4] = {64, 128, 32, 256};
    const VkImageLayout layouts[4] = {VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL,
                                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    frame->count = 0;
#define ADD(...)                                                                                                            \
    (frame->resources[frame->count].id = 0, memset(&frame->resources[frame->count], 0, sizeof frame->resources[0]),         \
     frame->count++)
    for (uint32_t i = 0; i < COLORS + DEPTHS + STORAGES + 1; i++) {
        bool depth = i >= COLORS && i < COLORS + DEPTHS, history = i == COLORS + DEPTHS + STORAGES;
        uint32_t size = i < COLORS + DEPTHS ? dice(frame, 2) : dice(frame, 4);
        struct graph_image_params params = {.name = names[frame->count],
                                            .width = widths[size],
                                            .height = 64,
                                            .format = depth ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT};
        uint32_t index = ADD();
        frame->resources[index].image = true;
        frame->resources[index].attachment = i < COLORS + DEPTHS;
        frame->resources[index].depth = depth;
        frame->resources[index].size = size;
        if (!history)
            frame->resources[index].id = graph_create_image(frame->graph, &params).id;
        else {
            params.name = "history";
            params.width = 64;
            struct graph_history handles = graph_history(frame->graph, &params);
            frame->resources[index].id = handles.current.id;
            if (handles.previous.id) {
                uint32_t previous = ADD();
                frame->resources[previous] = frame->resources[index];
                frame->resources[previous].id = handles.previous.id;
                frame->resources[previous].written = frame->resources[previous].read_only = true;
            }
        }
    }
    for (uint32_t i = 0; i < BUFFERS; i++) {
        uint32_t index = ADD();
        frame->resources[index].id = graph_create_buffer(frame->graph, names[index], 256u << dice(frame, 6)).id;
    }
    for (uint32_t i = 0; i < COUNT_OF(imported_images); i++) {
        uint32_t index = ADD();
        VkImageLayout initial = layouts[dice(frame, 4)];
        frame->resources[index].id =
            graph_import_image(frame->graph, &imported_images[i], initial, layouts[dice(frame, 4)]).id;
        frame->resources[index].image = frame->resources[index].imported = true;
        frame->resources[index].attachment = i < 2;
        frame->resources[index].written = initial != VK_IMAGE_LAYOUT_UNDEFINED;
    }
    for (uint32_t i = 0; i < COUNT_OF(imported_buffers); i++) {
        uint32_t index = ADD();
        frame->resources[index].id = graph_import_buffer(frame->graph, i ? "b1" : "b0", &imported_buffers[i]).id;
        frame->resources[index].written = frame->resources[index].imported = true;
    }
}

static void declare_pass(struct frame *frame, uint32_t number, bool async) {
    static const enum graph_use compute_images[] = {GRAPH_SAMPLE_COMPUTE,     GRAPH_READ_COMPUTE, GRAPH_WRITE_COMPUTE,
                                                    GRAPH_READ_WRITE_COMPUTE, GRAPH_COPY_FROM,    GRAPH_COPY_TO};
    static const enum graph_use compute_buffers[] = {GRAPH_READ_COMPUTE, GRAPH_WRITE_COMPUTE, GRAPH_READ_WRITE_COMPUTE,
                                                     GRAPH_INDIRECT,     GRAPH_COPY_FROM,     GRAPH_COPY_TO};
    static const enum graph_use draw_images[] = {GRAPH_SAMPLE_FRAGMENT, GRAPH_READ_FRAGMENT, GRAPH_READ_WRITE_FRAGMENT};
    static const enum graph_use draw_buffers[] = {GRAPH_READ_VERTEX, GRAPH_READ_FRAGMENT, GRAPH_READ_GRAPHICS,
                                                  GRAPH_INDIRECT,    GRAPH_INDEX,         GRAPH_READ_WRITE_FRAGMENT};
    bool on_compute = async && dice(frame, 3) == 0, draws = !on_compute && dice(frame, 2) == 0;
    struct graph_pass *pass = graph_add_pass(frame->graph, pass_names[number],
                                             on_compute ? GRAPH_QUEUE_ASYNC : GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    if (dice(frame, 3) == 0) graph_keep(pass);
    bool used[32] = {false}, written[32] = {false};
    uint32_t size = dice(frame, 2);
    for (uint32_t n = 0, wanted = 1 + dice(frame, 5); n < wanted; n++) {
        uint32_t r = dice(frame, frame->count);
        if (used[r]) continue;
        bool attach = draws && frame->resources[r].attachment && frame->resources[r].size == size && dice(frame, 3);
        bool depth_taken = pass->depth.resource != GRAPH_NONE;
        bool read = frame->resources[r].written;
        if (attach && frame->resources[r].depth && !depth_taken) {
            used[r] = true;
            if (read && dice(frame, 3) == 0) {
                graph_depth_read_only(pass, (graph_image){frame->resources[r].id});
                if (dice(frame, 2)) graph_use_image(pass, (graph_image){frame->resources[r].id}, GRAPH_SAMPLE_FRAGMENT);
            } else {
                graph_depth(pass, (graph_image){frame->resources[r].id},
                            read && dice(frame, 2) ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
                written[r] = true;
            }
        } else if (attach && !frame->resources[r].depth) {
            used[r] = written[r] = true;
            graph_color(pass, (graph_image){frame->resources[r].id},
                        read && dice(frame, 2) ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
        } else {
            enum graph_use use;
            if (draws)
                use = frame->resources[r].image ? draw_images[dice(frame, COUNT_OF(draw_images))]
                                                : draw_buffers[dice(frame, COUNT_OF(draw_buffers))];
            else
                use = frame->resources[r].image ? compute_images[dice(frame, COUNT_OF(compute_images))]
                                                : compute_buffers[dice(frame, COUNT_OF(compute_buffers))];
            bool writes = use == GRAPH_WRITE_COMPUTE || use == GRAPH_COPY_TO || use == GRAPH_READ_WRITE_COMPUTE ||
                          use == GRAPH_READ_WRITE_FRAGMENT;
            bool reads = use != GRAPH_WRITE_COMPUTE && use != GRAPH_COPY_TO;
            if ((reads && !read) || (writes && frame->resources[r].read_only)) continue;
            used[r] = true;
            written[r] = writes;
            if (frame->resources[r].image)
                graph_use_image(pass, (graph_image){frame->resources[r].id}, use);
            else
                graph_use_buffer(pass, (graph_buffer){frame->resources[r].id}, use);
            if (writes && frame->resources[r].imported && !frame->resources[r].image && dice(frame, 3) == 0)
                graph_use_buffer(pass, (graph_buffer){frame->resources[r].id}, GRAPH_READ_HOST);
        }
    }
    for (uint32_t r = 0; r < frame->count; r++) frame->resources[r].written |= written[r];
}

/* The plan as it is, for when the graph has gone on: what was declared lies in the arena, and the graph gets another one. */
static void keep_plan(struct graph *graph, struct graph *out) {
    *out = *graph;
    out->resources.data = malloc(graph->resources.count * sizeof *graph->resources.data);
    memcpy(out->resources.data, graph->resources.data, graph->resources.count * sizeof *graph->resources.data);
    out->histories.data = malloc(graph->histories.count * sizeof *graph->histories.data);
    memcpy(out->histories.data, graph->histories.data, graph->histories.count * sizeof *graph->histories.data);
    arena_init(&graph->arena, &graph->host, 64 << 10);
}

static void drop_plan(struct graph *kept) {
    free(kept->resources.data);
    free(kept->histories.data);
    arena_finish(&kept->arena);
}

static void declare_frame(struct frame *frame, uint32_t seed) {
    frame->random.state = seed;
    graph_begin(frame->graph);
    declare_resources(frame);
    for (uint32_t i = 0; i < PASSES; i++) declare_pass(frame, i, seed % 2);
    assert_int_equal(graph_compile(frame->graph), FNL_OK);
    assert_true(frame->graph->plan.batch_count <= MAX_BATCHES);
}

static void fail_with(const struct graph *graph, uint32_t seed, uint32_t errors) {
    static char text[1 << 16];
    graph_print(graph, text, sizeof text);
    fail_msg("seed %u: %u errors in\n%s", seed, errors, text);
}

/* Each frame after its like, and after the one before, which is another. */
static void test_random_graphs_have_no_hazard(void **state) {
    UNUSED(state);
    struct frame frame = {0};
    assert_int_equal(graph_create(NULL, NULL, &frame.graph), FNL_OK);
    uint64_t shared = 0, unshared = 0, async_plans = 0, batches = 0, barriers = 0, culled = 0, passes = 0;
    struct graph kept;
    for (uint32_t seed = 0; seed < GRAPHS; seed++) {
        for (int again = 0; again < 2; again++) {
            declare_frame(&frame, seed);
            const struct graph *const graphs[FRAMES] = {&kept, frame.graph};
            uint32_t errors = check_contents(frame.graph) + check_culling(frame.graph);
            if (seed || again) errors += check_hazards(graphs);
            if (seed || again) drop_plan(&kept);
            if (errors) fail_with(frame.graph, seed, errors);
            keep_plan(frame.graph, &kept);
        }
        const struct graph_plan *plan = &kept.plan;
        struct graph_stats stats = graph_query_stats(&kept);
        assert_int_equal(stats.pass_count + stats.culled_pass_count, PASSES);
        shared += stats.transient_bytes;
        unshared += stats.transient_bytes_unaliased;
        async_plans += plan->async;
        batches += stats.batch_count;
        barriers += stats.barrier_count;
        culled += stats.culled_pass_count;
        passes += stats.pass_count;
    }
    drop_plan(&kept);
    graph_destroy(&frame.graph);
    print_message("%llu passes, %llu culled, %llu barriers, %llu batches, %llu plans with async, memory %.2f of unaliased\n",
                  (unsigned long long)passes, (unsigned long long)culled, (unsigned long long)barriers,
                  (unsigned long long)batches, (unsigned long long)async_plans, (double)shared / (double)unshared);
    /* The frames must have had something to find. */
    assert_true(async_plans > GRAPHS / 4 && batches > 3 * async_plans && culled > GRAPHS &&
                (double)shared < 0.95 * (double)unshared);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_graphs_have_no_hazard)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
