/* SPDX-License-Identifier: MIT */
/** What the CPU reads of a frame: pictures and counts. */
#include "passes/post/post.h"
#include "render/frame_steps.h"
#include "render/shading.h"

static const char *const output_names[OUTPUT_COUNT] = {"read color",  "read radiance", "read surface",
                                                       "read normal", "read position", "read motion"};

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

static void execute_nothing(const struct graph_context *context, const void *data) {
    UNUSED(context);
    UNUSED(data);
}

/* Copies results into host-visible buffers; one last pass makes them visible to the CPU. */
void frame_add_outputs(struct frame_state *f) {
    graph_image images[OUTPUT_COUNT] = {f->color,      f->radiance,     f->aov.albedo,
                                        f->aov.normal, f->aov.position, f->temporal.motion};
    if (f->frame->msaa > 1 && (f->frame->outputs & FNL_OUTPUT_RADIANCE)) {
        images[1] = frame_create_image(f, "radiance average", VK_FORMAT_R32G32B32A32_SFLOAT, 1);
        resolve_add(f->graph, f->radiance, images[1]);
    }
    graph_buffer buffers[OUTPUT_COUNT] = {0};
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++) {
        if (!(f->frame->outputs & 1u << i)) continue;
        struct read_image_data data = {images[i], graph_import_buffer(f->graph, output_names[i], &f->r->outputs[i]),
                                       f->view_index * renderer_picture_size(f->frame, i)};
        struct graph_pass *pass =
            graph_add_pass(f->graph, output_names[i], GRAPH_QUEUE_GRAPHICS, execute_read_image, &data, sizeof data);
        graph_use_image(pass, data.image, GRAPH_COPY_FROM);
        graph_use_buffer(pass, data.buffer, GRAPH_COPY_TO);
        buffers[i] = data.buffer;
    }
    struct graph_pass *host = graph_add_pass(f->graph, "to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    for (uint32_t i = 0; i < OUTPUT_COUNT; i++)
        if (buffers[i].id) graph_use_buffer(host, buffers[i], GRAPH_READ_HOST);
}

/* ---- counts ---- */

struct count_copy {
    graph_buffer from, to;
    uint64_t from_offset, to_offset, size;
};
struct counts_data {
    struct count_copy copies[16]; /* more than there are kinds of counts */
    uint32_t count;
};

static void execute_counts(const struct graph_context *context, const void *data) {
    const struct counts_data *d = data;
    for (uint32_t i = 0; i < d->count; i++) {
        const struct count_copy *c = &d->copies[i];
        gpu_copy_buffer(context->commands, graph_get_buffer(context, c->from), c->from_offset,
                        graph_get_buffer(context, c->to), c->to_offset, c->size);
    }
}

/* Exact counts of this very frame. */
void frame_add_counts(struct frame_state *f) {
    uint32_t slot = gpu_frame_slot(f->r->device);
    graph_buffer counts = graph_import_buffer(f->graph, "frame counts", &f->r->counts[slot]), draws = {0};
    struct counts_data data = {.count = 1};
    data.copies[0] = (struct count_copy){f->draws.sums, counts, f->scene->geometry.item_count * 4ull,
                                         offsetof(struct frame_counts, visible_items), 4};
    if (f->lights.totals.id)
        data.copies[data.count++] = (struct count_copy){f->lights.totals, counts, 0, offsetof(struct frame_counts, lights),
                                                        sizeof(struct light_totals)};
    if (f->blend_lights.totals.id && f->blend_lights.totals.id != f->lights.totals.id)
        data.copies[data.count++] = (struct count_copy){
            f->blend_lights.totals, counts, 0, offsetof(struct frame_counts, blend_lights), sizeof(struct light_totals)};
    if (f->class_counts.id)
        data.copies[data.count++] = (struct count_copy){f->class_counts, counts, 0, offsetof(struct frame_counts, blocks),
                                                        sizeof ((struct frame_counts *)0)->blocks};
    if (f->edge_counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->edge_counts, counts, 0, offsetof(struct frame_counts, edges), EDGES_COUNTS * 4};
    if (f->visible_ranges.id)
        data.copies[data.count++] = (struct count_copy){f->visible_ranges, counts, 0, offsetof(struct frame_counts, visible),
                                                        sizeof(((struct frame_counts *)0)->visible)};
    if (f->coarse_counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->coarse_counts, counts, 0, offsetof(struct frame_counts, coarse), COARSE_COUNTS * 4};
    if (f->visible_fragments.id)
        data.copies[data.count++] =
            (struct count_copy){f->visible_fragments, counts, 0, offsetof(struct frame_counts, visible_fragments), 4};
    if (f->dais.counts.id)
        data.copies[data.count++] =
            (struct count_copy){f->dais.counts, counts, 0, offsetof(struct frame_counts, dais), DAIS_COUNTS * 4};
    if (f->lights.culled.id)
        data.copies[data.count++] =
            (struct count_copy){f->lights.culled, counts, 0, offsetof(struct frame_counts, lights_behind), 4};
    if (f->decals.list.totals.id)
        data.copies[data.count++] = (struct count_copy){f->decals.list.totals, counts, 0,
                                                        offsetof(struct frame_counts, decals), sizeof(struct light_totals)};
    if (f->decals.fragments.id)
        data.copies[data.count++] =
            (struct count_copy){f->decals.fragments, counts, 0, offsetof(struct frame_counts, decal_fragments), 12};
    if (f->draws.totals.id)
        data.copies[data.count++] = (struct count_copy){f->draws.totals, counts, 0, offsetof(struct frame_counts, clusters),
                                                        sizeof(struct gpu_cluster_totals)};
    if (f->draws.hidden.id)
        data.copies[data.count++] = (struct count_copy){f->draws.hidden, counts, f->scene->geometry.item_count * 4ull,
                                                        offsetof(struct frame_counts, hidden_items), 4};
    if (f->linked.totals.id)
        data.copies[data.count++] = (struct count_copy){f->linked.totals, counts, 0, offsetof(struct frame_counts, blend),
                                                        sizeof(struct linked_totals)};
    if (f->page_commands.id)
        data.copies[data.count++] = (struct count_copy){f->page_commands, counts, 16, offsetof(struct frame_counts, pages),
                                                        sizeof(struct gpu_virtual_counts)};
    if (f->exposure.id)
        data.copies[data.count++] = (struct count_copy){f->exposure, counts, 0, offsetof(struct frame_counts, exposure), 8};
    if (f->frame->count_lights) {
        draws = graph_import_buffer(f->graph, "read draws", &f->kept->draws);
        data.copies[data.count++] = (struct count_copy){f->draws.draws, draws, 0, 0,
                                                        MAX(f->scene->geometry.group_count, 1u) * sizeof(struct gpu_draw)};
    }
    for (uint32_t i = 0; i < data.count; i++)
        if (data.copies[i].to.id == counts.id) data.copies[i].to_offset += f->counts_offset;
    struct graph_pass *pass =
        graph_add_pass(f->graph, "read counts", GRAPH_QUEUE_GRAPHICS, execute_counts, &data, sizeof data);
    for (uint32_t i = 0; i < data.count; i++) graph_use_buffer(pass, data.copies[i].from, GRAPH_COPY_FROM);
    graph_use_buffer(pass, counts, GRAPH_COPY_TO);
    if (draws.id) graph_use_buffer(pass, draws, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(f->graph, "counts to host", GRAPH_QUEUE_GRAPHICS, execute_nothing, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, counts, GRAPH_READ_HOST);
    if (draws.id) graph_use_buffer(host, draws, GRAPH_READ_HOST);
    if (f->frame->count_lights) graph_use_buffer(host, f->counters, GRAPH_READ_HOST);
}

/* What is known before the GPU has run. */
void frame_note_stats(struct frame_state *f) {
    fnl_renderer *r = f->r;
    const struct geometry_scene *scene = &f->scene->geometry;
    struct renderer_view *kept = f->kept;
    fnl_frame_stats *s = &kept->stats;
    const struct light_input *lights = &f->scene->lights;
    *s = (fnl_frame_stats){.lights_total = lights->local_count - lights->unlit_count + lights->directional_count,
                           .items = scene->item_count,
                           .triangles_total = scene->triangle_count,
                           .clusters_total = scene->cluster_count,
                           .geometry = f->draws.mesh_draws.id ? FNL_GEOMETRY_MESH : FNL_GEOMETRY_VERTEX,
                           .lists = f->drawn_lists};
    bool second = f->blend_lights.header != f->lights.header;
    s->list_bytes = f->lights.byte_count + (second ? f->blend_lights.byte_count : 0);
    s->cells = f->lights.cell_count + (second ? f->blend_lights.cell_count : 0);
    s->draws = shading_draw_count(f);
    kept->forward_layouts = f->forward_layouts;
    s->gbuffer_bytes = shading_gbuffer_bytes(f);
    if (f->page_commands.id) {
        s->atlas_bytes = r->atlas.bytes;
        s->atlas_pages = r->atlas.page_count;
        s->atlas_capacity = r->atlas.across * r->atlas.across;
    }
    s->light_bytes = f->light_bytes;
    s->light_draws = f->light_draws;
    s->decals_total = f->decals.set ? f->r->device_scene.decals.order.count : 0;
    s->blend_bytes = f->blend_bytes;
    if (f->frame->exposure == FNL_EXPOSURE_EV) s->ev = f->frame->ev;
    s->mobile_merged = f->mobile_merged;
    s->mobile_tonemapped = f->mobile_merged && f->mobile_tonemapped;
    kept->fixed_bytes = f->lights.fixed_bytes + (second ? f->blend_lights.fixed_bytes : 0);
    kept->entry_bytes = f->lights.entry_bytes;
    kept->blend_entry_bytes = f->blend_lights.entry_bytes;
    kept->totals_known = f->lights.totals_known;
    kept->known_totals = f->lights.known;
}
