/* SPDX-License-Identifier: MIT */
#include "passes/shadow/rays.h"

#include "passes/geometry/radix_sort.h"
#include "passes/shadow/rays_build_shared.h"
#include "shaders.h"

/* Where the parts of a tree lie in its buffer; behind them what else it keeps. */
struct parts {
    uint64_t next, ids, rest;
};

static struct parts parts_of(uint32_t leaves) {
    const uint64_t count = MAX(leaves, 1u), next = count * sizeof(struct gpu_ray_node);
    return (struct parts){.next = next, .ids = next + count * 4, .rest = next + count * 8};
}

uint64_t rays_mesh_bytes(uint32_t triangle_count, uint32_t primitive_count) {
    return parts_of(triangle_count).rest + primitive_count * 4ull;
}

/* Where the boxes of primitives lie: behind the items. */
static uint64_t boxes_of(uint32_t item_count) {
    return parts_of(item_count).rest + item_count * sizeof(struct gpu_ray_item);
}

uint64_t rays_item_bytes(uint32_t item_count, uint32_t primitive_count) {
    return boxes_of(item_count) + primitive_count * (uint64_t)sizeof(struct gpu_ray_box);
}

static struct gpu_ray_tree tree_of(const struct gpu_buffer *buffer, uint32_t leaves) {
    const struct parts parts = parts_of(leaves);
    return (struct gpu_ray_tree){.nodes = buffer->address,
                                 .next = buffer->address + parts.next,
                                 .ids = buffer->address + parts.ids,
                                 .root = leaves == 0 ? RAY_END : leaves == 1 ? RAY_LEAF : 0};
}

/* What one build passes from step to step. */
struct build {
    struct graph *graph;
    const struct rays_input *input;
    struct rays rays;
    uint32_t shift; /* of the primitive's number in the keys of triangles */
    graph_buffer item_boxes;
};

static graph_buffer sort(const struct build *b, const char *what, graph_buffer pairs, uint32_t count, uint32_t bits) {
    return radix_sort_add(b->graph,
                          &(struct radix_sort_params){.what = what, .pairs = pairs, .capacity = count, .bits = bits});
}

/* The tree over `count` leaves, which `pairs` puts into order. */
static void add_tree(const struct build *b, bool meshes, graph_buffer pairs, uint32_t count) {
    struct graph *graph = b->graph;
    const struct parts parts = parts_of(count);
    const graph_buffer out = meshes ? b->rays.meshes : b->rays.items;
    const char *what = meshes ? "ray meshes" : "ray items";
    graph_buffer parents = graph_create_buffer(graph, graph_name(graph, "%s parents", what), count * 8ull);
    struct gpu_ray_links_push links = {.count = count, .shift = meshes ? b->shift : 32, .has_roots = meshes};
    graph_dispatch(graph, &(struct graph_dispatch){.name = graph_name(graph, "%s links", what),
                                                   .pipeline = {.shader = &shader_rays_links_comp},
                                                   .groups = {DIVIDE_UP(count, 64u)},
                                                   GRAPH_PUSH(links),
                                                   GRAPH_ROWS(graph_reads(&links.pairs, pairs), graph_changes(&links.nodes, out),
                                                              graph_row_at(parts.next, graph_changes(&links.next, out)),
                                                              graph_row_at(parts.ids, graph_changes(&links.ids, out)),
                                                              graph_row_at(parts.rest, graph_changes(&links.roots, out)),
                                                              graph_writes(&links.parents, parents))});
    graph_buffer arrived = graph_create_buffer(graph, graph_name(graph, "%s arrived", what), count * 4ull);
    graph_add_clear(graph, graph_name(graph, "%s clear", what), GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {arrived}});
    struct gpu_ray_boxes_push push = {
        .rays = b->rays.address, .count = count, .primitive_count = meshes ? b->input->primitive_count : 0};
    graph_dispatch(
        graph, &(struct graph_dispatch){.name = graph_name(graph, "%s boxes", what),
                                        .pipeline = {.shader = &shader_rays_boxes_comp},
                                        .groups = {DIVIDE_UP(count, 64u)},
                                        GRAPH_PUSH(push),
                                        GRAPH_ROWS(graph_changes(&push.nodes, out),
                                                   graph_row_at(parts.next, graph_changes(&push.next, out)),
                                                   graph_row_at(parts.ids, graph_changes(&push.ids, out)),
                                                   graph_reads(&push.parents, parents), graph_changes(&push.arrived, arrived),
                                                   graph_reads(NULL, b->input->vertices),
                                                   graph_row_if(!meshes, graph_reads(&push.boxes, b->item_boxes)))});
}

static void add_meshes(const struct build *b) {
    struct graph *graph = b->graph;
    const struct rays_input *in = b->input;
    graph_buffer pairs = graph_create_buffer(graph, "ray keys", in->triangle_count * 8ull);
    struct gpu_ray_keys_push push = {.scene = in->scene,
                                     .indices = in->indices,
                                     .mesh_table = in->mesh_table,
                                     .triangle_count = in->triangle_count,
                                     .primitive_count = in->primitive_count,
                                     .shift = b->shift};
    graph_dispatch(graph, &(struct graph_dispatch){.name = "ray keys",
                                                   .pipeline = {.shader = &shader_rays_keys_comp},
                                                   .groups = {DIVIDE_UP(in->triangle_count, 64u)},
                                                   GRAPH_PUSH(push),
                                                   GRAPH_ROWS(graph_reads(NULL, in->vertices), graph_writes(&push.pairs, pairs))});
    pairs = sort(b, "ray meshes", pairs, in->triangle_count, 32);
    add_tree(b, true, pairs, in->triangle_count);
}

static void add_primitives(const struct build *b) {
    const struct rays_input *in = b->input;
    struct gpu_ray_primitives_push push = {.scene = in->scene, .indices = in->indices, .primitive_count = in->primitive_count};
    graph_dispatch(b->graph, &(struct graph_dispatch){.name = "ray primitives",
                                                      .pipeline = {.shader = &shader_rays_primitives_comp},
                                                      .groups = {in->primitive_count},
                                                      GRAPH_PUSH(push),
                                                      GRAPH_ROWS(graph_reads(NULL, in->vertices),
                                                                 graph_row_at(boxes_of(in->item_count),
                                                                              graph_changes(&push.boxes, b->rays.items)))});
}

static void add_items(struct build *b) {
    struct graph *graph = b->graph;
    const struct rays_input *in = b->input;
    graph_buffer pairs = graph_create_buffer(graph, "ray item keys", in->item_count * 8ull);
    b->item_boxes = graph_create_buffer(graph, "ray item boxes", in->item_count * sizeof(struct gpu_ray_box));
    const vec3 size = vec3_sub(in->high, in->low);
    struct gpu_ray_place_push push = {
        .rays = b->rays.address,
        .item_count = in->item_count,
        .low = in->low,
        .scale = {size.x > 0 ? 1 / size.x : 0, size.y > 0 ? 1 / size.y : 0, size.z > 0 ? 1 / size.z : 0}};
    graph_dispatch(graph, &(struct graph_dispatch){
                              .name = "ray items",
                              .pipeline = {.shader = &shader_rays_place_comp},
                              .groups = {DIVIDE_UP(in->item_count, 64u)},
                              GRAPH_PUSH(push),
                              GRAPH_ROWS(graph_reads(NULL, in->vertices),
                                         graph_row_at(parts_of(in->item_count).rest, graph_changes(&push.placed, b->rays.items)),
                                         graph_writes(&push.boxes, b->item_boxes), graph_writes(&push.pairs, pairs))});
    pairs = sort(b, "ray items", pairs, in->item_count, 30);
    add_tree(b, false, pairs, in->item_count);
}

struct rays rays_add(struct graph *graph, gpu_device *device, const struct rays_input *input) {
    struct gpu_slice table = gpu_frame_allocate(device, sizeof(struct gpu_rays));
    struct build b = {.graph = graph,
                      .input = input,
                      .rays = {.items = graph_import_buffer(graph, "ray items", input->items),
                               .vertices = input->vertices,
                               .address = table.address},
                      .shift = 32};
    while (b.shift > 3 && input->primitive_count > 1ull << (32 - b.shift)) b.shift--;
    if (!table.data) return b.rays;
    *(struct gpu_rays *)table.data =
        (struct gpu_rays){.items = tree_of(input->items, input->item_count),
                          .mesh_table = input->mesh_table,
                          .primitive_boxes = input->items->address + boxes_of(input->item_count),
                          .placed = input->items->address + parts_of(input->item_count).rest,
                          .scene = input->scene,
                          .indices = input->indices};
    if (input->meshes) {
        struct gpu_rays *rays = table.data;
        rays->meshes = tree_of(input->meshes, input->triangle_count);
        rays->roots = input->meshes->address + parts_of(input->triangle_count).rest;
        b.rays.meshes = graph_import_buffer(graph, "ray meshes", input->meshes);
        if (input->make_meshes && input->triangle_count > 0) add_meshes(&b);
    }
    if (input->query) {
        const VkDeviceAddress top = input->query->top->address;
        ((struct gpu_rays *)table.data)->top = (uvec2){(uint32_t)top, (uint32_t)(top >> 32)};
        ray_query_add(graph, device, input, input->items->address + parts_of(input->item_count).rest, &b.rays);
    }
    if (input->place && input->item_count > 0) {
        add_primitives(&b);
        add_items(&b);
    }
    return b.rays;
}

void rays_use(struct graph_pass *pass, const struct rays *rays, enum graph_use use) {
    if (rays->meshes.id) graph_use_buffer(pass, rays->meshes, use);
    const enum graph_use trace = use == GRAPH_READ_COMPUTE ? GRAPH_TRACE_COMPUTE : GRAPH_TRACE_FRAGMENT;
    if (rays->top.id) {
        graph_use_buffer(pass, rays->bottoms, trace);
        graph_use_buffer(pass, rays->top, trace);
    }
    graph_use_buffer(pass, rays->items, use);
    graph_use_buffer(pass, rays->vertices, use);
}
