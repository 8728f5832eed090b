/* SPDX-License-Identifier: MIT */
#include "passes/geometry/geometry.h"

#include "constants_shared.h"
#include "passes/geometry/clusters_shared.h"
#include "passes/geometry/layered_shared.h"
#include "lighting/lighting_shared.h"
#include "shaders.h"

_Static_assert(FEATURES_ID == GPU_FEATURES_ID, "src/gpu gives the features this id");

static bool bucket_in_set(const struct geometry_bucket *bucket, enum geometry_set set) {
    bool wanted = set < GEOMETRY_NOT_IN_FIRST || bucket->forward_layouts >> ((int)set - GEOMETRY_NOT_IN_FIRST) & 1;
    return wanted && (set == GEOMETRY_BLEND ? bucket->blend : set == GEOMETRY_GLASS || geometry_bucket_opaque(bucket));
}

/* Materials without layers are shaded by pipelines that know of none. */
static bool bucket_is_layered(const struct geometry_bucket *bucket) { return bucket->blend || bucket->forward_layouts >> GEOMETRY_LAYERED & 1; }

static bool bucket_is_sorted(const struct geometry_bucket *bucket) {
    return bucket->blend && bucket->topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

static void use_vertices(struct graph_pass *pass, const struct geometry_scene *scene, const struct geometry_draws *draws,
                         enum geometry_set set) {
    graph_use_buffer(pass, scene->vertices, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, draws->visible, GRAPH_READ_VERTEX);
    graph_use_buffer(pass, draws->draws, GRAPH_INDIRECT);
    if (draws->item_draws.id) {
        graph_use_buffer(pass, draws->item_draws, GRAPH_INDIRECT);
        graph_use_buffer(pass, draws->totals, GRAPH_INDIRECT);
        graph_use_buffer(pass, draws->indices, GRAPH_INDEX);
        graph_use_buffer(pass, draws->triangles, GRAPH_READ_FRAGMENT);
    }
    if (draws->mesh_draws.id) {
        graph_use_buffer(pass, draws->mesh_draws, GRAPH_INDIRECT);
        const graph_buffer read[] = {scene->vertices,   draws->mesh_draws, draws->mesh_list,
                                     draws->mesh_slots, draws->mesh_sums,  draws->mesh_masks};
        for (uint32_t i = 0; i < COUNT_OF(read); i++)
            if (read[i].id) graph_use_buffer(pass, read[i], GRAPH_READ_MESH);
    }
    if (set == GEOMETRY_BLEND && draws->blend_draws.id) {
        graph_use_buffer(pass, draws->blend_visible, GRAPH_READ_VERTEX);
        graph_use_buffer(pass, draws->blend_draws, GRAPH_INDIRECT);
    }
}

void geometry_use(struct graph_pass *pass, const struct geometry_scene *scene, const struct geometry_draws *draws,
                  enum geometry_set set) {
    use_vertices(pass, scene, draws, set);
    geometry_use_features(pass, scene, GRAPH_READ_FRAGMENT);
}

void geometry_use_features(struct graph_pass *pass, const struct geometry_scene *scene, enum graph_use use) {
    for (uint32_t i = 0; i < COUNT_OF(scene->feature_buffers); i++)
        if (scene->feature_buffers[i].id) graph_use_buffer(pass, scene->feature_buffers[i], use);
}

void geometry_draw(const struct graph_context *context, const struct geometry_scene *scene,
                   const struct geometry_draws *draws, enum geometry_set set, const struct gpu_graphics_params *state,
                   const struct gpu_shader *mask_fragment, struct gpu_geometry_push push) {
    geometry_draw_with(context, scene, draws, set, state, mask_fragment, &push, sizeof push);
}

/* The variant that writes all that a fragment shader reads, and the least besides. */
static const struct gpu_shader *find_vertex(const struct gpu_shader *fragment) {
    static const struct gpu_shader *const variants[] = {&shader_geometry_ids_vert, &shader_geometry_cutout_vert,
                                                        &shader_geometry_surface_vert};
    for (uint32_t i = 0; i < COUNT_OF(variants); i++)
        if (!(fragment->inputs & ~variants[i]->outputs)) return variants[i];
    return &shader_geometry_vert;
}

/* The vertex shader of draws for several views. */
static const struct gpu_shader *views_vertex(const struct geometry_draws *draws, bool depth_only) {
    if (draws->layers == GEOMETRY_LAYERS_MULTIVIEW) return depth_only ? &shader_depth_views_vert : &shader_geometry_views_vert;
    return depth_only ? &shader_depth_layered_vert : &shader_geometry_layered_vert;
}

/* The shader that makes the corners of triangles. `own`, or NULL, is that of the caller; `views`: draws for several views, or NULL. */
static void set_corners(struct gpu_graphics_params *params, const struct gpu_shader *own, bool meshes, const struct geometry_draws *views) {
    params->mesh = !meshes ? NULL : params->fragment ? &shader_geometry_mesh : &shader_depth_mesh;
    params->vertex = own || meshes      ? own
                     : views            ? views_vertex(views, !params->fragment)
                     : params->fragment ? find_vertex(params->fragment)
                                        : &shader_depth_vert;
}

/* The draws of a bucket, each of which goes to all views. */
static void draw_groups(const struct graph_context *context, const struct geometry_draws *draws, const struct geometry_bucket *bucket,
                        const struct gpu_geometry_push *push, uint32_t size) {
    const uint32_t views = geometry_view_count(draws), calls = draws->layers == GEOMETRY_LAYERS_DRAWS ? views : 1;
    for (uint32_t i = 0; i < calls; i++) {
        if (draws->layers == GEOMETRY_LAYERS_MULTIVIEW) {
            gpu_push(context->commands, push, size);
        } else {
            const struct gpu_layered_push layered = {.first = i, .count = views / calls};
            char all[LAYERED_AT + sizeof layered] = {0};
            memcpy(all, push, MIN(size, (uint32_t)LAYERED_AT));
            memcpy(all + LAYERED_AT, &layered, sizeof layered);
            gpu_push(context->commands, all, sizeof all);
        }
        gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, draws->draws), bucket->first_group * sizeof(struct gpu_draw),
                                  bucket->group_count);
    }
}

/* The clusters of a bucket, by mesh shaders. */
static void draw_meshes(const struct graph_context *context, const struct geometry_draws *draws, uint32_t bucket,
                        const struct gpu_graphics_params *params, struct gpu_geometry_push *push, uint32_t size) {
    VkDeviceAddress visible = push->visible;
    gpu_bind(context->commands, graph_pipeline(context, params));
    for (uint32_t i = 0; i < draws->mesh_draw_count; i++) {
        uint64_t offset = ((uint64_t)bucket * draws->mesh_draw_count + i) * sizeof(struct gpu_mesh_draw);
        push->visible = graph_address(context, draws->mesh_draws) + offset;
        gpu_push(context->commands, push, size);
        gpu_draw_mesh_indirect(context->commands, graph_get_buffer(context, draws->mesh_draws),
                               offset + offsetof(struct gpu_mesh_draw, groups));
    }
    push->visible = visible;
}

static void draw_set(const struct graph_context *context, const struct geometry_scene *scene,
                        const struct geometry_draws *draws, enum geometry_set set, const struct gpu_graphics_params *state,
                        const struct gpu_shader *mask_fragment, struct gpu_geometry_push *push, uint32_t size) {
    gpu_bind_indices(context->commands, scene->indices, 0);
    struct gpu_graphics_params params = *state;
    push->scene = scene->scene;
    push->visible = graph_address(context, draws->visible);
    push->triangles = draws->triangles.id ? graph_address(context, draws->triangles) : 0;
    for (uint32_t i = 0; i < scene->bucket_count; i++) {
        const struct geometry_bucket *bucket = &scene->buckets[i];
        if (!bucket_in_set(bucket, set) || bucket_is_sorted(bucket)) continue;
        params.topology = bucket->topology;
        params.geometry = bucket->topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST ? state->geometry : NULL;
        params.cull = bucket->double_sided ? VK_CULL_MODE_NONE
                      : bucket->mirrored   ? VK_CULL_MODE_FRONT_BIT
                                           : VK_CULL_MODE_BACK_BIT;
        params.fragment = bucket->mask && mask_fragment ? mask_fragment : state->fragment;
        params.constants[LIGHTING_ID] = state->constants[LIGHTING_ID] & ~(bucket_is_layered(bucket) ? 0 : GPU_LIGHTING_LAYERS);
        bool clustered = geometry_bucket_clustered(bucket), compacted = draws->item_draws.id && clustered;
        params.features = (state->features | scene->features) | (compacted ? GPU_FEATURE_COMPACTED : 0);
        bool meshes = draws->mesh_draws.id && clustered;
        set_corners(&params, state->vertex, meshes, draws->view_mask ? draws : NULL);
        if (meshes) {
            draw_meshes(context, draws, i, &params, push, size);
            continue;
        }
        gpu_bind(context->commands, graph_pipeline(context, &params));
        if (compacted) {
            gpu_push(context->commands, push, size);
            gpu_draw_indexed_indirect_count(context->commands, graph_get_buffer(context, draws->item_draws),
                                            (uint64_t)bucket->first_item * sizeof(struct gpu_draw),
                                            graph_get_buffer(context, draws->totals),
                                            sizeof(struct gpu_cluster_totals) + i * 4ull, bucket->item_count);
            continue;
        }
        draw_groups(context, draws, bucket, push, size);
    }
    if (set == GEOMETRY_BLEND && scene->blend_item_count) {
        /* One order over all states: the fragment shader culls back faces itself. */
        params.features = state->features | scene->features;
        memcpy(params.constants, state->constants, sizeof params.constants);
        params.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        params.cull = VK_CULL_MODE_NONE;
        params.fragment = state->fragment;
        set_corners(&params, state->vertex, false, NULL);
        push->visible = graph_address(context, draws->blend_visible);
        gpu_bind(context->commands, graph_pipeline(context, &params));
        gpu_push(context->commands, push, size);
        gpu_draw_indexed_indirect(context->commands, graph_get_buffer(context, draws->blend_draws), 0,
                                  scene->blend_item_count);
    }
}

void geometry_draw_with(const struct graph_context *context, const struct geometry_scene *scene,
                        const struct geometry_draws *draws, enum geometry_set set, const struct gpu_graphics_params *state,
                        const struct gpu_shader *mask_fragment, struct gpu_geometry_push *push, uint32_t size) {
    const bool counts = draws->counts_vertices && set == GEOMETRY_OPAQUE;
    if (counts) gpu_begin_vertex_count(context->commands, draws->first_query, geometry_query_count(draws));
    draw_set(context, scene, draws, set, state, mask_fragment, push, size);
    if (counts) gpu_end_vertex_count(context->commands, draws->first_query, geometry_query_count(draws));
}

void geometry_set_layers(struct graph_pass *pass, const struct geometry_draws *draws) {
    if (draws->layers == GEOMETRY_LAYERS_MULTIVIEW)
        graph_view_mask(pass, draws->view_mask);
    else
        graph_vertex_layers(pass, geometry_view_count(draws));
}

uint32_t geometry_draw_count(const struct geometry_scene *scene, enum geometry_set set) {
    uint32_t count = set == GEOMETRY_BLEND && scene->blend_item_count ? 1 : 0;
    for (uint32_t i = 0; i < scene->bucket_count; i++)
        count += bucket_in_set(&scene->buckets[i], set) && !bucket_is_sorted(&scene->buckets[i]);
    return count;
}

struct prepass_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view;
    uint32_t samples;
    enum geometry_set set;
};

static void execute_prepass(const struct graph_context *context, const void *data) {
    const struct prepass_data *d = data;
    struct gpu_graphics_params state = {.depth_format = GEOMETRY_DEPTH_FORMAT,
                                        .depth_test = true,
                                        .depth_write = true,
                                        .depth_compare = VK_COMPARE_OP_GREATER,
                                        .samples = d->samples};
    geometry_draw(context, d->scene, &d->draws, d->set, &state, &shader_depth_frag,
                  (struct gpu_geometry_push){.view = d->view});
}

void prepass_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                 VkDeviceAddress view, graph_image depth) {
    geometry_depth_add(graph, "depth prepass", scene, draws, view, depth);
}

void geometry_depth_add(struct graph *graph, const char *name, const struct geometry_scene *scene,
                        const struct geometry_draws *draws, VkDeviceAddress view, graph_image depth) {
    struct prepass_data data = {scene, *draws, view, graph_image_info(graph, depth).samples, GEOMETRY_OPAQUE};
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_prepass, &data, sizeof data);
    use_vertices(pass, scene, draws, GEOMETRY_OPAQUE);
    graph_depth(pass, depth, geometry_depth_load(draws), 0);
    geometry_set_layers(pass, draws);
}

void blend_depth_add(struct graph *graph, const struct geometry_scene *scene, const struct geometry_draws *draws,
                     VkDeviceAddress view, graph_image depth) {
    struct prepass_data data = {scene, *draws, view, graph_image_info(graph, depth).samples, GEOMETRY_BLEND};
    struct graph_pass *pass =
        graph_add_pass(graph, "blend depth", GRAPH_QUEUE_GRAPHICS, execute_prepass, &data, sizeof data);
    use_vertices(pass, scene, draws, GEOMETRY_BLEND);
    graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
}
