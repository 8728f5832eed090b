/* SPDX-License-Identifier: MIT */
#include "tests/fine_bench.h"

#include "passes/lights/light_proxy.h"
#include "tests/light_reference.h"

fnl_light_params params[FINE_LIGHTS_MAX];
struct list_light lights[FINE_LIGHTS_MAX];
uint32_t fine_kinds = 1u << GPU_ENTITY_LIGHT;

/* ---- building and reading back ---- */

/* `front`: depth of blended surfaces, or NULL. */
void (*fine_spoil)(const struct graph *graph);

struct fine_copy fine_build(const struct gpu_view *view, uint32_t light_count, const float *depth, const float *front,
                            const struct fine_params *given) {
    struct list_lab lab = list_lab_open(view, lights, light_count);
    lab.input.kinds = fine_kinds;
    struct fine_params p = *given;
    graph_image depth_handle = list_lab_depth(&lab, depth);
    p.blend_depth = list_lab_depth(&lab, front);
    p.eye_distance = vec3_length(view->eye);
    list_lab_begin(&lab);
    struct fine_lists lists = fine_add(lab.graph, harness_device(), &lab.input, &lab.in_view, depth_handle, &p);
    struct fine_copy copy = {.tile_size = p.tile_size,
                             .tiles_x = DIVIDE_UP(view->size.x, p.tile_size),
                             .tiles_y = DIVIDE_UP(view->size.y, p.tile_size),
                             .cell_count = lists.lights.cell_count,
                             .mask_size = depth && p.pruning ? MIN(p.mask_size, p.tile_size / 8) : 0};
    if (fine_spoil) fine_spoil(lab.graph);
    list_lab_run(&lab,
                 (graph_buffer[COPY_COUNT]){lists.lights.cells, lists.lights.ids, lists.lights.extra, lists.boxes,
                                            lab.in_view.ids, lists.lights.totals},
                 COPY_COUNT);
    for (uint32_t i = 0; i < COPY_COUNT; i++) {
        copy.data[i] = list_reads_take(&lab.reads, i);
        copy.sizes[i] = lab.reads.buffers[i].size;
    }
    memcpy(&copy.totals, copy.data[COPY_TOTALS], sizeof copy.totals);
    list_lab_close(&lab);
    return copy;
}

void fine_copy_free(struct fine_copy *copy) {
    for (int i = 0; i < COPY_COUNT; i++) free(copy->data[i]);
}

struct gpu_cell fine_cell_at(const struct fine_copy *c, uint32_t cell) {
    return ((struct gpu_cell *)c->data[COPY_CELLS])[cell];
}
const uint32_t *fine_ids_at(const struct fine_copy *c, uint32_t cell) {
    return (const uint32_t *)c->data[COPY_IDS] + fine_cell_at(c, cell).offset;
}

struct list_copy fine_list_of(const struct fine_copy *c) {
    return (struct list_copy){
        .cells = c->data[COPY_CELLS], .ids = c->data[COPY_IDS], .cell_count = c->cell_count, .totals = c->totals};
}

bool fine_holds(const struct fine_copy *c, uint32_t cell, uint32_t light) {
    struct list_copy list = fine_list_of(c);
    return list_holds(&list, cell, light);
}

/* Whether a pixel visits entry `entry` of its cell, as shaders/lights/fine.glsl finds it. */
bool fine_visits(const struct fine_copy *c, uint32_t cell, uint32_t x, uint32_t y, uint32_t entry) {
    if (!c->mask_size) return true;
    struct gpu_cell at = fine_cell_at(c, cell);
    uint32_t side = c->tile_size / c->mask_size, words = (at.count + 31) / 32;
    uint32_t square = y % c->tile_size / c->mask_size * side + x % c->tile_size / c->mask_size;
    uint64_t word = (uint64_t)(at.offset / 32 + cell) * side * side + square * words + entry / 32;
    assert_true((word + 1) * 4 <= c->sizes[COPY_EXTRA]);
    return ((const uint32_t *)c->data[COPY_EXTRA])[word] >> entry % 32 & 1;
}

void fine_check_form(const struct fine_copy *c, uint32_t light_count) {
    struct list_copy list = fine_list_of(c);
    list_check_form(&list, light_count);
    assert_int_equal(c->totals.overflow_cells, 0);
}

bool fine_is_equal(const struct fine_copy *a, const struct fine_copy *b, const struct gpu_view *view) {
    struct list_copy lists[] = {fine_list_of(a), fine_list_of(b)};
    if (!list_equal(&lists[0], &lists[1])) return false;
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            uint32_t cell = y / a->tile_size * a->tiles_x + x / a->tile_size;
            for (uint32_t i = 0; i < fine_cell_at(a, cell).count; i++)
                if (fine_visits(a, cell, x, y, i) != fine_visits(b, cell, x, y, i)) return false;
        }
    return true;
}

/* ---- the reference ---- */

static double length_of(const double v[3]) { return sqrt(light_dot(v, v)); }

/* Whether the light's volume, widened by what the builder may allow itself, holds the point. */
static bool nearly_reaches(const struct gpu_view *view, const fnl_light_params *light, const double point[3]) {
    double axes[3][3], from[3], at[3], range = light_reference_range(light);
    double slack = 4e-5 * (length_of(point) + (double)vec3_length(view->eye)) + 1e-5 * range;
    const float origin[3] = {light->position.x, light->position.y, light->position.z};
    for (int i = 0; i < 3; i++) from[i] = point[i] - (double)origin[i];
    double distance = length_of(from);
    if (light->kind == FNL_LIGHT_POINT) return distance <= range + slack;
    light_axes(light, axes);
    for (int i = 0; i < 3; i++) at[i] = light_dot(from, axes[i]);
    switch (light->kind) {
    case FNL_LIGHT_SPOT:
        return distance <= range + slack &&
               at[2] + 2 * slack + 4e-6 * distance >= cos((double)light->outer_cone_angle) * distance;
    case FNL_LIGHT_CAPSULE: {
        double half = (double)light->length / 2, along = fmin(fmax(at[2], -half), half);
        return sqrt(at[0] * at[0] + at[1] * at[1] + (at[2] - along) * (at[2] - along)) <= range + slack;
    }
    case FNL_LIGHT_WEDGE:
        return distance <= range + slack && at[2] >= -slack &&
               fabs(at[0]) <= tan((double)light->wedge_angles[0]) * (at[2] + slack) + slack &&
               fabs(at[1]) <= tan((double)light->wedge_angles[1]) * (at[2] + slack) + slack;
    default:
        return fabs(at[0]) <= (double)light->box_size.x / 2 + slack &&
               fabs(at[1]) <= (double)light->box_size.y / 2 + slack && fabs(at[2]) <= (double)light->box_size.z / 2 + slack;
    }
}

/*
 * The lists of opaque surfaces: a tile holds each light that reaches one of its pixels, and none that comes near to none; a pixel's mask
 * the same. Returns the pairs of pixel and light that are lit.
 */
uint64_t fine_check_sets(const struct gpu_view *view, const float *depth, uint32_t light_count, const struct fine_copy *c) {
    uint64_t lit = 0;
    uint32_t tile_count = c->tiles_x * c->tiles_y;
    uint8_t *near = calloc((size_t)tile_count * light_count + 1, 1);
    assert_non_null(near);
    for (uint32_t y = 0; y < view->size.y; y++)
        for (uint32_t x = 0; x < view->size.x; x++) {
            double point[3];
            uint32_t cell = y / c->tile_size * c->tiles_x + x / c->tile_size, count = fine_cell_at(c, cell).count, entry = 0;
            bool solid = list_position_of(view, depth, x, y, point);
            for (uint32_t light = 0; light < light_count; light++) {
                while (entry < count && fine_ids_at(c, cell)[entry] < light) entry++;
                bool held = entry < count && fine_ids_at(c, cell)[entry] == light,
                     visited = held && fine_visits(c, cell, x, y, entry);
                bool reached = solid && light_reaches(&params[light], point);
                bool nearly = solid && nearly_reaches(view, &params[light], point);
                assert_true(nearly || !reached);
                if (reached && !visited)
                    fail_msg("pixel %u %u misses light %u, a %s", x, y, light, fnl_value_name(FNL_ENUM_LIGHT_KIND, params[light].kind));
                if (c->mask_size == 1 && visited && !nearly)
                    fail_msg("pixel %u %u visits light %u, a %s far from it", x, y, light,
                             fnl_value_name(FNL_ENUM_LIGHT_KIND, params[light].kind));
                if (nearly) near[(size_t)cell * light_count + light] = 1;
                lit += reached;
            }
        }
    for (uint32_t cell = 0; cell < tile_count; cell++)
        for (uint32_t i = 0; i < fine_cell_at(c, cell).count; i++)
            if (!near[(size_t)cell * light_count + fine_ids_at(c, cell)[i]])
                fail_msg("tile %u holds light %u, which reaches none of its pixels", cell, fine_ids_at(c, cell)[i]);
    free(near);
    return lit;
}

/* Lights of all five shapes before and around the viewer. */
void fine_random_lights(const struct gpu_view *view, struct random_state *random, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        fnl_light_params light = fnl_light_params_default();
        double seen[3], world[3], depth = exp2((double)random_range(random, -1, 5));
        view_of_pixel(view, (double)random_range(random, -0.2f, 1.2f) * view->size.x,
                      (double)random_range(random, -0.2f, 1.2f) * view->size.y, i % 11 == 3 ? -depth * 0.1 : depth, seen);
        view_to_world(view, seen, world);
        light.kind = (fnl_light_kind)(FNL_LIGHT_POINT + i % 5);
        light.position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
        light.range = exp2f(random_range(random, -2, 3.5f));
        light.direction =
            vec3_normalize(vec3_make(random_range(random, -1, 1), random_range(random, -1, 1), random_range(random, -1, 1)));
        light.up = vec3_normalize(vec3_cross(light.direction, vec3_make(0.3f, 1, 0.1f)));
        light.outer_cone_angle = random_range(random, 0.04f, 1.57f);
        light.inner_cone_angle = light.outer_cone_angle * random_range(random, 0, 0.99f);
        light.length = random_range(random, 0, 6);
        light.wedge_angles[0] = random_range(random, 0.02f, 1.4f);
        light.wedge_angles[1] = random_range(random, 0.02f, 1.4f);
        light.box_size =
            vec3_make(random_range(random, 0.1f, 8), random_range(random, 0.1f, 8), random_range(random, 0.1f, 8));
        params[i] = light;
        lights[i] = list_light_of(&light, i);
    }
}

void fine_place(const struct gpu_view *view, uint32_t index, double x, double y, double view_depth, float range, bool spot) {
    double seen[3], world[3];
    view_of_pixel(view, x, y, view_depth, seen);
    view_to_world(view, seen, world);
    params[index] = fnl_light_params_default();
    params[index].position = vec3_make((float)world[0], (float)world[1], (float)world[2]);
    params[index].range = range;
    if (spot) {
        params[index].kind = FNL_LIGHT_SPOT;
        params[index].direction = vec3_make(1, 0, 0);
        params[index].outer_cone_angle = 0.2f;
    }
    lights[index] = list_light_of(&params[index], index);
}
