/* SPDX-License-Identifier: MIT */
/** What rasterising starts from: how much larger than lights their meshes are, and the tiles and slices that each mesh is looked for in. */
#include "passes/lights/raster_mesh.h"
#include "tests/raster_bench.h"

enum { LIGHTS = 300, WIDTH = 301, HEIGHT = 173 };

static fnl_light_params params[LIGHTS];
static struct list_light lights[LIGHTS];

/* A cone of twelve sides, a rim and a flat cap: hardly larger than a narrow spot, and less than a prism where it is wide. */
static void test_cone_volumes_CL_2(void **state) {
    UNUSED(state);
    double narrow = 0, wide = 0;
    for (uint32_t i = 1; i <= 157; i++) {
        fnl_light_params light = fnl_light_params_default();
        light.kind = FNL_LIGHT_SPOT;
        light.direction = vec3_normalize(vec3_make(0.3f, -1, 0.2f));
        light.range = 3;
        light.outer_cone_angle = 0.01f * (float)i;
        struct list_light g = list_light_of(&light, 0);
        vec3 corners[3 * GPU_CONE_TRIANGLES];
        double volume = 0, exact = 2.0 / 3 * M_PI * 27 * (1 - cos((double)light.outer_cone_angle));
        uint32_t triangles = light_mesh(&g.shape, &g.bounds, corners);
        for (uint32_t t = 0; t < triangles; t++)
            volume += fabs((double)vec3_dot(vec3_sub(corners[t * 3], light.position),
                                            vec3_cross(vec3_sub(corners[t * 3 + 1], light.position),
                                                       vec3_sub(corners[t * 3 + 2], light.position)))) /
                      6;
        assert_true(volume > exact);
        *(light.outer_cone_angle < 0.5f ? &narrow : &wide) =
            fmax(light.outer_cone_angle < 0.5f ? narrow : wide, volume / exact);
    }
    print_message("cones take %.3f of the volume of narrow spots, %.3f of wide ones at most\n", narrow, wide);
    assert_true(narrow < 1.15 && wide < 1.65);
}

/* Left, right, top and bottom in pixels, near and far in metres; false: unknown, the light is about the viewer. */
static bool extent_of(const struct gpu_view *view, const struct list_light *light, double out[6]) {
    const double world[3] = {(double)light->bounds.center.x, (double)light->bounds.center.y, (double)light->bounds.center.z};
    double at[3], radius = (double)light->bounds.radius, near = (double)view->near_distance / 2, slopes[2][2];
    bool orthographic = view->orthographic > 0.5f;
    world_to_view(view, world, at);
    out[4] = -at[2] - radius;
    out[5] = -at[2] + radius;
    if (!orthographic && !(-at[2] > radius * 1.03 + near)) return false;
    for (int axis = 0; axis < 2; axis++) {
        slopes[axis][0] = at[axis] - radius;
        slopes[axis][1] = at[axis] + radius;
        if (!orthographic) reference_slopes(at[axis], -at[2], radius, 1e-6, slopes[axis]);
    }
    vec3 corners[3 * GPU_CONE_TRIANGLES];
    uint32_t count = light->shape.kind == GPU_SHAPE_SPHERE ? 0 : 3 * light_mesh(&light->shape, &light->bounds, corners);
    double mesh[2][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}}, depths[2] = {INFINITY, -INFINITY};
    for (uint32_t i = 0; i < count; i++) {
        const double corner[3] = {(double)corners[i].x, (double)corners[i].y, (double)corners[i].z};
        double seen[3];
        world_to_view(view, corner, seen);
        depths[0] = fmin(depths[0], -seen[2]);
        depths[1] = fmax(depths[1], -seen[2]);
        for (int axis = 0; axis < 2; axis++) {
            double slope = seen[axis] / (orthographic ? 1 : fmax(-seen[2], 1e-9));
            mesh[axis][0] = fmin(mesh[axis][0], slope);
            mesh[axis][1] = fmax(mesh[axis][1], slope);
        }
    }
    bool known = count && (orthographic || depths[0] > near * 1.01);
    for (int axis = 0; axis < 2 && known; axis++) {
        slopes[axis][0] = fmax(slopes[axis][0], mesh[axis][0]);
        slopes[axis][1] = fmin(slopes[axis][1], mesh[axis][1]);
    }
    if (count) {
        out[4] = fmax(out[4], depths[0]);
        out[5] = fmin(out[5], depths[1]);
    }
    for (int axis = 0; axis < 2; axis++) {
        double size = axis ? view->size.y : view->size.x,
               scale = axis ? (double)view->ndc_scale.y : (double)view->ndc_scale.x,
               offset = axis ? (double)view->ndc_offset.y : (double)view->ndc_offset.x, parts[2];
        for (int i = 0; i < 2; i++) parts[i] = ((slopes[axis][i] - offset) / scale * (axis ? -1 : 1) + 1) / 2 * size;
        out[axis * 2] = fmin(parts[0], parts[1]);
        out[axis * 2 + 1] = fmax(parts[0], parts[1]);
    }
    return true;
}

/*
 * The rectangle is that of the sphere, cut by that of the mesh, and the slices are those of their depths; every tile of the rectangle has a slot,
 * but a light in one tile needs none.
 */
static void test_rectangles_ES_60(void **state) {
    UNUSED(state);
    struct random_state random = {33};
    uint64_t slots = 0, all = 0, in_one = 0, checked = 0;
    for (uint32_t kind = 0; kind < LIST_VIEWS; kind++) {
        struct gpu_view view = list_random_view(kind, &random, WIDTH + kind, HEIGHT);
        list_random_shapes(&view, &random, LIGHTS, params, lights);
        for (uint32_t i = 0; i < LIGHTS; i += 2) { /* half of them small */
            params[i].range *= 0.1f;
            params[i].box_size = vec3_scale(params[i].box_size, 0.1f);
            params[i].length *= 0.1f;
            lights[i] = list_light_of(&params[i], i);
        }
        struct raster_request r = raster_request_of(&view, lights, LIGHTS);
        struct raster_copy copy = raster_build(&r);
        const struct gpu_light_list *g = &copy.list.grid;
        for (uint32_t i = 0; i < copy.list.totals.in_view; i++) {
            struct gpu_raster_light q = copy.rectangles[i];
            uint32_t low[2] = {q.columns & 0xffff, q.rows & 0xffff}, high[2] = {q.columns >> 16, q.rows >> 16},
                     count = copy.slot_sums[i + 1] - copy.slot_sums[i], tiles[2] = {g->tiles_x, g->tiles_y};
            double e[6];
            bool known = extent_of(&view, &lights[copy.visible[i]], e), one = true;
            if (low[0] > high[0] || low[1] > high[1]) {
                assert_int_equal(count, 0);
                continue;
            }
            assert_true(count == 0 || count == (high[0] - low[0] + 1) * (high[1] - low[1] + 1));
            assert_true(count > 0 || (low[0] == high[0] && low[1] == high[1]));
            slots += count;
            all += (uint64_t)g->tiles_x * g->tiles_y;
            uint32_t first = list_slice_at(g, e[4] * (1 - 3e-4) - 1e-4 * (1 + fabs(e[4]))),
                     last = list_slice_at(g, e[5] * (1 + 3e-4) + 1e-4 * (1 + fabs(e[5])));
            assert_true((q.slices & 0xffff) >= first && q.slices >> 16 <= last);
            if (!known) continue;
            checked++;
            for (int axis = 0; axis < 2; axis++) {
                double slack = 0.5 + 1e-3 * (e[axis * 2 + 1] - e[axis * 2]), size = g->tile_size;
                double least = floor((e[axis * 2] - slack) / size), most = floor((e[axis * 2 + 1] + slack) / size);
                assert_true((double)low[axis] >= fmin(least, tiles[axis] - 1.0) && (double)high[axis] <= fmax(most, 0));
                one = one && least == most && least >= 0 && least < tiles[axis];
                one = one && e[axis * 2 + 1] + slack < (axis ? view.size.y : view.size.x); /* no tile that is cut short */
            }
            if (one) assert_int_equal(count, 0);
            in_one += one;
        }
        raster_copy_free(&copy);
    }
    print_message("slots for %.3f of all tiles; %llu of %llu lights lie in one tile\n", (double)slots / (double)all,
                  (unsigned long long)in_one, (unsigned long long)checked);
    assert_true(checked > 300 && in_one > 50);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cone_volumes_CL_2),
        cmocka_unit_test_teardown(test_rectangles_ES_60, harness_check),
    };
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
