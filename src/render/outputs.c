/* SPDX-License-Identifier: MIT */
/** What the CPU reads of a frame: pictures and counts. */
#include "passes/post/post.h"
#include "render/frame_steps.h"
#include "render/shading.h"
#include "render/step.h"

static const char *const output_names[OUTPUT_COUNT] = {"read color",  "read radiance", "read surface",
                                                       "read normal", "read position", "read motion", "read objects"};

struct read_image_data {
    graph_image image;
    graph_buffer buffer;
    uint64_t offset;
};

static void execute_read_image(const struct graph_context *context, const void *data) {
    const struct read_image_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->image), graph_get_buffer(context, d->buffer),
                             d->offset);
}

/* Copies results into host-visible buffers; one last pass makes them visible to the CPU. */
static void add_outputs(struct frame_state *f) {
    graph_image images[OUTPUT_COUNT] = {f->color,      f->radiance,     f->nearest.aov.albedo,
                                        f->nearest.aov.normal, f->nearest.aov.position, f->temporal.motion,
                                        f->nearest.objects};
    if (f->frame->msaa > 1 && (f->frame->outputs & FNL_OUTPUT_RADIANCE)) {
        images[1] = frame_create_image(f, "radiance average", VK_FORMAT_R32G32B32A32_SFLOAT, 1);
        resolve_add(f->graph, f->radiance, images[1]);
    }
    graph_buffer buffers[OUTPUT_COUNT] = {0};
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) {
        if (!(f->frame->outputs & 1u << i)) continue;
        struct read_image_data data = {images[i], graph_import_buffer(f->graph, output_names[i], &f->input->outputs->pictures[i]),
                                       f->view_index * renderer_picture_size(f->frame, i)};
        struct graph_pass *pass =
            graph_add_pass(f->graph, output_names[i], GRAPH_QUEUE_GRAPHICS, execute_read_image, &data, sizeof data);
        graph_use_image(pass, data.image, GRAPH_COPY_FROM);
        graph_use_buffer(pass, data.buffer, GRAPH_COPY_TO);
        buffers[i] = data.buffer;
    }
    struct graph_pass *host = graph_add_pass(f->graph, "to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++)
        if (buffers[i].id) graph_use_buffer(host, buffers[i], GRAPH_READ_HOST);
}

/* ---- counts ---- */

struct counts_data {
    struct counters_copy copies[COUNTERS_COPIES];
    uint32_t count;
    graph_buffer counts;
    uint64_t offset; /* of the view's */
    /* With count_lights: what culling left of each draw. */
    graph_buffer all_draws, draws;
    uint64_t draw_bytes;
};

static void execute_counts(const struct graph_context *context, const void *data) {
    const struct counts_data *d = data;
    for (uint32_t i = 0; i < d->count; i++) {
        const struct counters_copy *c = &d->copies[i];
        gpu_copy_buffer(context->commands, graph_get_buffer(context, c->from), c->from_offset,
                        graph_get_buffer(context, d->counts), d->offset + c->to_offset, c->size);
    }
    if (d->draws.id)
        gpu_copy_buffer(context->commands, graph_get_buffer(context, d->all_draws), 0, graph_get_buffer(context, d->draws),
                        0, d->draw_bytes);
}

/* Exact counts of this very frame: those of every frame, and what its steps have counted. */
static void add_counts(struct frame_state *f) {
    uint64_t items = f->scene->geometry.item_count * 4ull;
    COUNTERS_COPY(f, f->draws.sums, items, culling, visible_items);
    COUNTERS_COPY(f, f->lights.list.totals, 0, lists, lights);
    if (f->blend_lights.list.totals.id != f->lights.list.totals.id) COUNTERS_COPY(f, f->blend_lights.list.totals, 0, lists, blend_lights);
    COUNTERS_COPY(f, f->lights.list.culled, 0, lists, behind);
    COUNTERS_COPY(f, f->draws.totals, 0, culling, clusters);
    COUNTERS_COPY(f, f->draws.hidden, items, culling, hidden_items);
    COUNTERS_COPY(f, f->exposure, 0, exposure, metered);
    struct counts_data data = {
        .counts = graph_import_buffer(f->graph, "frame counts", &f->r->slots.counts[gpu_frame_slot(f->r->device)]),
        .offset = f->counts_offset,
        .count = f->made->numbers.copy_count};
    memcpy(data.copies, f->made->numbers.copies, sizeof data.copies);
    if (f->frame->count_lights) {
        data.draws = graph_import_buffer(f->graph, "read draws", &f->kept->draws);
        data.all_draws = f->draws.draws;
        data.draw_bytes = MAX(f->scene->geometry.group_count, 1u) * sizeof(struct gpu_draw);
    }
    struct graph_pass *pass =
        graph_add_pass(f->graph, "read counts", GRAPH_QUEUE_GRAPHICS, execute_counts, &data, sizeof data);
    for (uint32_t i = 0; i < data.count; i++) graph_use_buffer(pass, data.copies[i].from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, data.counts, GRAPH_COPY_TO);
    if (data.draws.id) graph_use_buffer(pass, data.all_draws, GRAPH_COPY_FROM);
    if (data.draws.id) graph_use_buffer(pass, data.draws, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(f->graph, "counts to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, data.counts, GRAPH_READ_HOST);
    if (data.draws.id) graph_use_buffer(host, data.draws, GRAPH_READ_HOST);
    if (f->frame->count_lights) graph_use_buffer(host, f->counters, GRAPH_READ_HOST);
}

/* What is known before the GPU has run. */
static void note_stats(struct frame_state *f) {
    const struct geometry_scene *scene = &f->scene->geometry;
    struct view_made *made = f->made;
    fnl_frame_stats *s = &made->stats;
    const struct light_set *lights = &f->scene->lights;
    *s = (fnl_frame_stats){.lights_total = lights->local_count - lights->unlit_count + lights->directional_count,
                           .items = scene->item_count,
                           .triangles_total = scene->triangle_count,
                           .clusters_total = scene->cluster_count,
                           .geometry = f->draws.mesh_draws.id ? FNL_GEOMETRY_MESH : FNL_GEOMETRY_VERTEX,
                           .occlusion = frame_culls_hidden(f->frame),
                           .lists = f->lists.drawn,
                           .msaa = f->frame->msaa};
    bool second = f->blend_lights.list.header != f->lights.list.header;
    s->list_bytes = f->lights.list.byte_count + (second ? f->blend_lights.list.byte_count : 0);
    s->cells = f->lights.list.cell_count + (second ? f->blend_lights.list.cell_count : 0);
    s->draws = shading_draw_count(f);
    made->forward_layouts = f->forward_layouts;
    if (f->frame->exposure == FNL_EXPOSURE_EV) s->ev = f->frame->ev;
    made->fixed_bytes = f->lights.list.fixed_bytes + (second ? f->blend_lights.list.fixed_bytes : 0);
    made->entry_bytes = f->lights.list.entry_bytes;
    made->blend_entry_bytes = f->blend_lights.list.entry_bytes;
    made->totals_known = f->lights.list.totals_known;
    made->known_totals = f->lights.list.known;
}

void outputs_add_counts(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_READ);
    add_counts(f);
    note_stats(f);
}

/* ---- the steps ---- */

static fnl_result name_objects(struct frame_state *shared) {
    const struct device_scene *d = shared->r->device_scene;
    if (!(shared->frame->outputs & FNL_OUTPUT_OBJECT)) return FNL_OK;
    struct gpu_slice slice = gpu_frame_allocate(shared->r->device, d->item_count * sizeof(struct device_object));
    if (!slice.data) return gpu_status(shared->r->device);
    shared->nearest.object_table = slice.address;
    return device_items_name(d, slice.data);
}

static void draw_surfaces(struct frame_state *f) {
    const fnl_frame *frame = f->frame;
    graph_set_role(f->graph, GRAPH_ROLE_REST);
    if (frame_shows_surfaces(frame)) f->nearest.aov = aov_add(f->graph, &f->scene->geometry, &f->draws, f->view_address, frame->width, frame->height);
    if (frame->outputs & FNL_OUTPUT_OBJECT)
        f->nearest.objects = objects_add(f->graph, f->r->device, &f->scene->geometry, &f->draws, f->view_address, f->nearest.object_table, frame->width, frame->height);
}

/* What outputs and debug views show of the nearest surface of each pixel. */
const struct frame_step step_surfaces = {.name = "surfaces", .begin_frame = name_objects, .light_view = draw_surfaces};

static void finish_view(struct frame_state *f) {
    graph_set_role(f->graph, GRAPH_ROLE_READ);
    add_outputs(f);
    outputs_add_counts(f);
}

const struct frame_step step_outputs = {.name = "outputs", .finish_view = finish_view};
