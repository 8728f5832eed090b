/* SPDX-License-Identifier: MIT */
/* Lit glass before a lit wall, against shading in double precision: with every way to blend, shading path and list. */
#include "render/shading.h"
#include "tests/render_test.h"
#include "tests/shade_reference.h"

/* Two lit panes before a wall, overlapping in the middle, added with the nearest first. */
static const float heights[3] = {0, 1, 2};
static const float centers[3] = {0, -0.4f, 0.4f}, half_widths[3] = {1.2f, 0.9f, 0.9f};

static void glass_materials(struct scene_material out[3]) {
    for (int i = 0; i < 3; i++) {
        out[i] = scene_material_default();
        out[i].metallic = 0;
        out[i].roughness = 0.5f;
    }
    out[0].base_color = (vec4){0.7f, 0.6f, 0.5f, 1};
    out[1].base_color = (vec4){0.9f, 0.1f, 0.1f, 0.4f};
    out[2].base_color = (vec4){0.1f, 0.9f, 0.1f, 0.7f};
    out[1].alpha_mode = out[2].alpha_mode = FNL_ALPHA_BLEND;
}

/* Largest relative error against shading in double precision; weighted is judged where one pane covers the wall. */
static double glass_error(const fnl_image *radiance, const fnl_light_params *lights, uint32_t light_count, bool everywhere) {
    struct scene_material materials[3];
    glass_materials(materials);
    double worst = 0;
    for (uint32_t y = 1; y < radiance->height; y += 4)
        for (uint32_t x = 1; x < radiance->width; x += 4) {
            double expected[3] = {0}, to_view[3] = {0, 0, 1}, at = (x + 0.5) * 2 / radiance->width - 1;
            int covered = 0;
            for (int k = 0; k < 3; k++) {
                if (fabs(at - (double)centers[k]) > (double)half_widths[k]) continue;
                covered++;
                struct reference_surface s = reference_surface_default();
                s.position[0] = at;
                s.position[1] = 1 - (y + 0.5) * 2 / radiance->height;
                s.position[2] = (double)heights[k];
                s.base_color[0] = (double)materials[k].base_color.x;
                s.base_color[1] = (double)materials[k].base_color.y;
                s.base_color[2] = (double)materials[k].base_color.z;
                s.metallic = 0;
                s.roughness = 0.5;
                double layer[3], alpha = (double)materials[k].base_color.w;
                reference_shade(&s, to_view, lights, light_count, (fnl_vec3){0, 0, 0}, (fnl_vec3){0, 0, 0}, layer);
                for (int c = 0; c < 3; c++) expected[c] += alpha * (layer[c] - expected[c]);
            }
            if (covered == 3 && !everywhere) continue;
            for (int c = 0; c < 3; c++) worst = fmax(worst, fabs((double)test_pixel(radiance, x, y)[c] / expected[c] - 1));
        }
    return worst;
}

static double relative_difference(const fnl_image *a, const fnl_image *b) {
    double worst = 0;
    for (uint32_t i = 0; i < a->width * a->height * 4; i++) {
        double x = (double)((const float *)a->pixels)[i], y = (double)((const float *)b->pixels)[i];
        worst = fmax(worst, fabs(x - y) / fmax(fmax(fabs(x), fabs(y)), 0.01));
    }
    return worst;
}

static void test_glass_lights(void **state) {
    UNUSED(state);
    fnl_scene *scene = test_scene();
    struct scene_material materials[3];
    glass_materials(materials);
    static const int order[3] = {2, 0, 1};
    for (int i = 0; i < 3; i++) {
        int k = order[i];
        test_place(scene, test_quad_mesh(scene, scene_add_material(scene, &materials[k])), (vec3){centers[k], 0, heights[k]},
                   (vec3){half_widths[k], 1.2f, 1});
    }
    fnl_light_params lights[12]; /* some between the panes, which light only what they are in front of */
    for (uint32_t i = 0; i < COUNT_OF(lights); i++) {
        lights[i] = test_point((vec3){(float)(i % 4) * 0.5f - 0.75f, (float)(i / 4) * 0.6f - 0.6f, 0.4f + 0.25f * (float)i},
                               0.5f + 0.1f * (float)i, 2.5f);
        fnl_light_id id;
        assert_int_equal(fnl_scene_add_light(scene, &lights[i], &id), FNL_OK);
    }
    fnl_renderer *renderer = test_renderer(scene);
    for (int shading = 0; shading < FNL_SHADING_AUTO; shading++) {
        fnl_image first[FNL_TRANSPARENCY_COUNT] = {{0}};
        bool approximate = shading_is((fnl_shading)shading, SHADING_APPROXIMATE);
        for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++)
            for (int lists = 0; lists < FNL_LISTS_AUTO; lists++) {
                fnl_frame frame = test_frame(FNL_OUTPUT_RADIANCE);
                frame.transparency = (fnl_transparency)t;
                frame.width = frame.height = 40;
                frame.shading = (fnl_shading)shading;
                frame.lists = (fnl_light_lists)lists;
                /* All lists where they know depth; elsewhere a tile and a cluster will do. */
                bool depth = shading == FNL_SHADING_FORWARD_PREPASS || shading == FNL_SHADING_DEFERRED;
                if (!depth && lists != FNL_LISTS_ALL && lists != FNL_LISTS_TILED && lists != FNL_LISTS_CLUSTERED) continue;
                if (!fnl_shading_supports(frame.shading, frame.lists, frame.msaa)) continue;
                test_render_frame(renderer, &frame);
                fnl_image radiance = test_read(renderer, FNL_OUTPUT_RADIANCE);
                double worst = glass_error(&radiance, lights, COUNT_OF(lights), t != FNL_TRANSPARENCY_WEIGHTED);
                /* Where there is a G-buffer the wall's colour has 8 bits, off by half a per cent. */
                if (!approximate && worst >= (shading < FNL_SHADING_DEFERRED ? 1e-3 : 1e-2))
                    fail_msg("%s, %s, %s: off by %g", fnl_value_name(FNL_ENUM_SHADING, frame.shading), fnl_value_name(FNL_ENUM_LISTS, frame.lists),
                             fnl_value_name(FNL_ENUM_TRANSPARENCY, frame.transparency), worst);
                if (!first[t].pixels) {
                    first[t] = radiance;
                    continue;
                }
                assert_true(test_equal(&first[t], &radiance));
                free_picture(&radiance);
            }
        double difference = relative_difference(&first[FNL_TRANSPARENCY_SORTED], &first[FNL_TRANSPARENCY_LINKED]);
        bool stippled = shading == FNL_SHADING_INFERRED; /* sorted glass has light of its own resolution, in a pattern */
        if (!stippled && difference > (approximate ? 0.05 : 1e-5))
            fail_msg("%s: linked differs from sorted by %g", fnl_value_name(FNL_ENUM_SHADING, (fnl_shading)shading), difference);
        for (int t = 0; t < FNL_TRANSPARENCY_COUNT; t++) free_picture(&first[t]);
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"ES-19, ES-44: glass has the lights of the wall behind it with every way to blend", test_glass_lights, NULL, NULL, NULL},
    };
    return cmocka_run_group_tests_name("transparency_lights", tests, test_group_begin, test_group_end);
}
