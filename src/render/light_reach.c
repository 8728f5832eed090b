/* SPDX-License-Identifier: MIT */
#include "render/light_reach.h"

enum { SAMPLES = 4096, ITEM_NODES = 256, ITEM_LIGHTS = 1024 };

/* What of an interval across, seen between two depths, is on the screen: NDC. False: nothing. */
static bool seen_between(float low, float high, float near, float far, float scale, float offset, float out[2]) {
    float a = ((low < 0 ? low / near : low / far) - offset) / scale;
    float b = ((high > 0 ? high / near : high / far) - offset) / scale;
    out[0] = fmaxf(fminf(a, b), -1);
    out[1] = fminf(fmaxf(a, b), 1);
    return out[0] <= out[1];
}

/* Tiles of one axis between two places in NDC. */
static double tiles_between(const float ndc[2], uint32_t size, uint32_t tile_size) {
    double first = floor(((double)ndc[0] * 0.5 + 0.5) * size / tile_size), last = floor(((double)ndc[1] * 0.5 + 0.5) * size / tile_size);
    return fmin(last, DIVIDE_UP(size, tile_size) - 1.0) - first + 1;
}

static double slice_at(const struct gpu_light_list *grid, float depth) {
    float slice = (grid->linear ? depth : log2f(fmaxf(depth, 1e-30f))) * grid->slice_scale + grid->slice_bias;
    return floor((double)fminf(fmaxf(slice, 0), (float)(grid->slices - 1)));
}

/* Tiles, slices and clusters of one light; all 0 where it is out of the view. */
static void reach_of(const struct gpu_view *view, const struct gpu_light_list *grid, const struct gpu_entity_bounds *light,
                     double out[4]) {
    out[0] = out[1] = out[2] = out[3] = 0;
    if (!(light->radius > 0)) return;
    vec3 at = mat4_point(&view->world_to_view, light->center);
    float radius = light->radius * 1.001f + 1e-3f, far = radius - at.z, near = fmaxf(-at.z - radius, view->near_distance);
    float x[2], y[2], near_spread = view->orthographic > 0.5f ? 1 : near, far_spread = view->orthographic > 0.5f ? 1 : far;
    if (!(far > near)) return;
    if (!seen_between(at.x - radius, at.x + radius, near_spread, far_spread, view->ndc_scale.x, view->ndc_offset.x, x)) return;
    if (!seen_between(at.y - radius, at.y + radius, near_spread, far_spread, view->ndc_scale.y, view->ndc_offset.y, y)) return;
    out[0] = 1;
    out[1] = tiles_between(x, view->size.x, grid->tile_size) * tiles_between(y, view->size.y, grid->tile_size);
    out[2] = slice_at(grid, far) - slice_at(grid, near) + 1;
    out[3] = out[1] * out[2];
}

/* One of each of `sampled` runs of `count` things, another place in each: scenes number theirs in patterns. */
static uint32_t sample_of(uint32_t count, uint32_t sampled, uint32_t i) {
    uint32_t first = (uint32_t)((uint64_t)count * i / sampled), end = (uint32_t)((uint64_t)count * (i + 1) / sampled);
    return first + i * 2654435761u % (end - first);
}

struct light_reach light_reach_estimate(const struct gpu_view *view, const struct gpu_entity_bounds *lights, uint32_t count,
                                        const struct clustered_params *params) {
    struct gpu_light_list grid = {0};
    clustered_grid(&grid, view->size.x, view->size.y, params);
    uint32_t sampled = MIN(count, (uint32_t)SAMPLES);
    double sums[4] = {0}, squares[4] = {0};
    for (uint32_t i = 0; i < sampled; i++) {
        double reach[4];
        reach_of(view, &grid, &lights[sample_of(count, sampled, i)], reach);
        for (int k = 0; k < 4; k++) {
            sums[k] += reach[k];
            squares[k] += reach[k] * reach[k];
        }
    }
    double scale = sampled ? (double)count / sampled : 0, totals[4];
    for (int k = 0; k < 4; k++) {
        double variance = sampled ? fmax(squares[k] - sums[k] * sums[k] / sampled, 0) : 0; /* of the sum */
        totals[k] = scale * (sums[k] + (count > sampled ? 3 * sqrt(variance) : 0));
    }
    return (struct light_reach){totals[0], totals[1], totals[2], totals[3]};
}

/* ---- items ---- */

/* How many of the lights touch an item of a node; all do where the item deforms, since it has no box. */
static uint32_t lights_at(const fnl_scene *scene, const struct scene_node *node, uint32_t item,
                          const struct gpu_entity_bounds *const *lights, uint32_t count) {
    const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
    const struct box *box = &scene->primitives.data[mesh->first_primitive + item % mesh->primitive_count].bounds;
    if (node->skin != SCENE_NONE || mesh->morph_target_count) return count;
    mat4 m = device_instance_matrix(scene, node, item / mesh->primitive_count);
    vec3 center = mat4_point(&m, vec3_scale(vec3_add(box->low, box->high), 0.5f));
    vec3 half = vec3_scale(vec3_sub(box->high, box->low), 0.5f), extent;
    extent.x = fabsf(m.m[0]) * half.x + fabsf(m.m[4]) * half.y + fabsf(m.m[8]) * half.z;
    extent.y = fabsf(m.m[1]) * half.x + fabsf(m.m[5]) * half.y + fabsf(m.m[9]) * half.z;
    extent.z = fabsf(m.m[2]) * half.x + fabsf(m.m[6]) * half.y + fabsf(m.m[10]) * half.z;
    uint32_t touching = 0;
    for (uint32_t i = 0; i < count; i++) {
        vec3 apart = vec3_sub(lights[i]->center, center);
        vec3 outside = {fmaxf(fabsf(apart.x) - extent.x, 0), fmaxf(fabsf(apart.y) - extent.y, 0),
                        fmaxf(fabsf(apart.z) - extent.z, 0)};
        touching += vec3_length(outside) <= lights[i]->radius;
    }
    return touching;
}

double light_reach_items(const struct gpu_view *view, const struct gpu_entity_bounds *lights, uint32_t count, const fnl_scene *scene) {
    const struct gpu_light_list grid = {.tile_size = 64, .slices = 1};
    const struct gpu_entity_bounds *seen[ITEM_LIGHTS];
    uint32_t sampled = MIN(count, (uint32_t)ITEM_LIGHTS), seen_count = 0;
    for (uint32_t i = 0; i < sampled; i++) {
        const struct gpu_entity_bounds *light = &lights[sample_of(count, sampled, i)];
        double reach[4];
        reach_of(view, &grid, light, reach);
        if (reach[0] > 0) seen[seen_count++] = light;
    }
    uint32_t node_count = scene->nodes.count, nodes = MIN(node_count, (uint32_t)ITEM_NODES);
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < nodes; i++) {
        const struct scene_node *node = &scene->nodes.data[sample_of(node_count, nodes, i)];
        uint32_t items = scene_node_draws(node)
                             ? scene->meshes.data[node->mesh].primitive_count * node->instance_count
                             : 0;
        if (!items) continue;
        double pairs = (double)items * lights_at(scene, node, i * 2246822519u % items, seen, seen_count);
        sum += pairs;
        squares += pairs * pairs;
    }
    if (!nodes || !sampled) return 0;
    double variance = fmax(squares - sum * sum / nodes, 0);
    return (double)node_count / nodes * ((double)count / sampled) * (sum + 3 * sqrt(variance));
}
