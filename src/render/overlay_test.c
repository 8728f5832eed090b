/* SPDX-License-Identifier: MIT */
/* What is drawn over the picture: where, in which order, with which image, and what is refused. */
#include "tests/render_test.h"

static const uint32_t indices[] = {0, 1, 2, 2, 1, 3, 4, 5, 6};

static fnl_overlay_vertex corner(float x, float y, float u, float v, uint8_t alpha) { return (fnl_overlay_vertex){{x, y}, {u, v}, {255, 255, 255, alpha}}; }

struct layer {
    fnl_overlay_vertex vertices[7];
    fnl_overlay_draw draws[3];
    fnl_overlay overlay;
};

/* A square from 8 to 40 that shows the image, over a triangle of another colour. */
static void make_layer(struct layer *l, const fnl_image *image) {
    *l = (struct layer){.vertices = {corner(8, 8, 0, 0, 128), corner(40, 8, 1, 0, 128), corner(8, 40, 0, 1, 128), corner(40, 40, 1, 1, 128),
                                     corner(-100, -100, 1, 1, 255), corner(300, -100, 1, 1, 255), corner(-100, 300, 1, 1, 255)},
                        .draws = {{.first_index = 6, .index_count = 3, .x = -5, .y = 20, .width = 1000, .height = 10},
                                  {.index_count = 6, .width = 64, .height = 64},
                                  {.index_count = 6, .x = 64, .width = 5, .height = 64}}};
    for (uint32_t i = 4; i < 7; i++) memcpy(l->vertices[i].color, (uint8_t[4]){0, 51, 204, 255}, 4);
    l->overlay = (fnl_overlay){.vertices = l->vertices,
                               .vertex_count = 7,
                               .indices = indices,
                               .index_count = 9,
                               .draws = l->draws,
                               .draw_count = 3,
                               .images = {{image, 1}}};
}

static fnl_scene *quad_scene(void) {
    fnl_scene *scene = test_scene();
    test_place(scene, test_quad_mesh(scene, SCENE_NONE), vec3_make(0, 0, 0), vec3_make(0.7f, 0.7f, 0.7f));
    const fnl_light_params light = test_point(vec3_make(0.2f, 0.1f, 1), 3, 10);
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    return scene;
}

/* Draws lie over each other in their order, inside of their rectangles, and leave every other pixel as it is. */
static void test_draws_go_over_the_picture(void **state) {
    UNUSED(state);
    uint8_t texels[2 * 2 * 4];
    for (uint32_t i = 0; i < 4; i++) memcpy(texels + 4 * i, (uint8_t[4]){(uint8_t)(i % 2 ? 255 : 0), (uint8_t)(i / 2 ? 255 : 0), 255, 255}, 4);
    const fnl_image image = {2, 2, FNL_PIXEL_FORMAT_RGBA8, texels};
    struct layer layer;
    make_layer(&layer, &image);
    fnl_scene *scene = quad_scene();
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    fnl_image plain = test_render(scene, &frame, FNL_OUTPUT_COLOR);
    fnl_renderer *renderer = test_renderer(scene);
    frame.overlay = &layer.overlay;
    test_render_frame(renderer, &frame);
    fnl_image picture = test_read(renderer, FNL_OUTPUT_COLOR);
    for (uint32_t y = 0; y < 64; y++)
        for (uint32_t x = 0; x < 64; x++) {
            const uint8_t *before = test_pixel8(&plain, x, y), *found = test_pixel8(&picture, x, y);
            const bool stripe = y >= 20 && y < 30, square = x >= 8 && x < 40 && y >= 8 && y < 40;
            /* Of four texels, bilinear: constant in the outer quarters. */
            const double u = fmin(fmax((x + 0.5 - 8) / 32 * 2 - 0.5, 0), 1), v = fmin(fmax((y + 0.5 - 8) / 32 * 2 - 0.5, 0), 1);
            const double texel[3] = {255 * u, 255 * v, 255}, blue[3] = {0, 51, 204};
            for (int c = 0; c < 3; c++) {
                double wanted = stripe ? blue[c] : before[c];
                if (square) wanted += (texel[c] - wanted) * 128 / 255;
                if (!stripe && !square) assert_int_equal(found[c], before[c]);
                if (fabs(found[c] - wanted) > 1.6) fail_msg("pixel %u, %u, channel %d: %d, not %g", x, y, c, found[c], wanted);
            }
        }
    /* Another image under the same number is not looked at; under another number it is. */
    memset(texels, 255, sizeof texels);
    free_picture(&picture);
    test_render_frame(renderer, &frame);
    picture = test_read(renderer, FNL_OUTPUT_COLOR);
    assert_true(test_pixel8(&picture, 10, 25)[0] < 20);
    layer.overlay.images[0].version = 2;
    free_picture(&picture);
    test_render_frame(renderer, &frame);
    picture = test_read(renderer, FNL_OUTPUT_COLOR);
    assert_true(test_pixel8(&picture, 10, 25)[0] >= 127);
    /* Nothing to draw is nothing. */
    const fnl_overlay empty = {0};
    frame.overlay = &empty;
    free_picture(&picture);
    test_render_frame(renderer, &frame);
    picture = test_read(renderer, FNL_OUTPUT_COLOR);
    assert_true(test_equal(&picture, &plain));
    free_picture(&picture);
    free_picture(&plain);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Each draw shows the image that it names; each image is sent again when its own version is another. */
static void test_draws_show_their_own_images(void **state) {
    UNUSED(state);
    uint8_t texels[FNL_OVERLAY_IMAGES_MAX][4];
    fnl_image images[FNL_OVERLAY_IMAGES_MAX];
    fnl_overlay_vertex vertices[4 * FNL_OVERLAY_IMAGES_MAX];
    fnl_overlay_draw draws[FNL_OVERLAY_IMAGES_MAX];
    fnl_overlay overlay = {.vertices = vertices, .vertex_count = COUNT_OF(vertices), .indices = indices, .index_count = 6, .draws = draws, .draw_count = COUNT_OF(draws)};
    for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++) {
        const float left = 8.0f * (float)i;
        memcpy(texels[i], (uint8_t[4]){(uint8_t)(40 + 50 * i), (uint8_t)(200 - 60 * i), (uint8_t)i, 255}, 4);
        images[i] = (fnl_image){1, 1, FNL_PIXEL_FORMAT_RGBA8, texels[i]};
        overlay.images[i] = (fnl_overlay_image){i == 2 ? NULL : &images[i], 7};
        for (uint32_t k = 0; k < 4; k++) vertices[4 * i + k] = corner(left + 8.0f * (float)(k % 2), 16.0f * (float)(k / 2), 0, 0, 255);
        draws[i] = (fnl_overlay_draw){.index_count = 6, .first_vertex = 4 * i, .width = 64, .height = 64, .image = FNL_OVERLAY_IMAGES_MAX - 1 - i};
    }
    fnl_scene *scene = quad_scene();
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    frame.overlay = &overlay;
    for (uint32_t round = 0; round < 2; round++) {
        test_render_frame(renderer, &frame);
        fnl_image picture = test_read(renderer, FNL_OUTPUT_COLOR);
        for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++) {
            const uint32_t shown = FNL_OVERLAY_IMAGES_MAX - 1 - i;
            const uint8_t *found = test_pixel8(&picture, 8 * i + 4, 8), white[3] = {255, 255, 255};
            uint8_t wanted[3] = {(uint8_t)(40 + 50 * shown), (uint8_t)(200 - 60 * shown), (uint8_t)shown};
            if (round == 1 && shown == 3) wanted[2] = 99; /* that one's version alone has changed */
            assert_memory_equal(found, shown == 2 ? white : wanted, 3);
        }
        free_picture(&picture);
        for (uint32_t i = 0; i < FNL_OVERLAY_IMAGES_MAX; i++) texels[i][2] = 99;
        overlay.images[3].version = 8;
    }
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

/* Whatever reaches outside of the arrays is refused before anything is drawn. */
static void test_what_reaches_outside_is_refused(void **state) {
    UNUSED(state);
    fnl_scene *scene = quad_scene();
    fnl_renderer *renderer = test_renderer(scene);
    fnl_frame frame = test_frame(FNL_OUTPUT_COLOR);
    for (uint32_t fault = 0; fault < 12; fault++) {
        struct layer layer;
        uint8_t texel[16] = {0};
        fnl_image image = {1, 1, FNL_PIXEL_FORMAT_RGBA8, texel};
        make_layer(&layer, &image);
        frame.overlay = &layer.overlay;
        if (fault == 0) layer.draws[1].index_count = 5;
        if (fault == 1) layer.draws[1].first_index = 6;
        if (fault == 2) layer.draws[1].first_vertex = 4;
        if (fault == 3) layer.draws[1].first_index = UINT32_MAX;
        if (fault == 4) layer.overlay.vertices = NULL;
        if (fault == 5) image.width = 0;
        if (fault == 6) image.format = FNL_PIXEL_FORMAT_RGBA32F;
        if (fault == 7) image.pixels = NULL;
        if (fault == 8) layer.draws[2].image = FNL_OVERLAY_IMAGES_MAX;
        if (fault == 9) layer.draws[0].image = UINT32_MAX;
        const fnl_image tall = {1, 16385, FNL_PIXEL_FORMAT_RGBA8, texel}, empty = {0};
        if (fault == 10) layer.overlay.images[3].image = &tall;
        if (fault == 11) layer.overlay.images[2].image = &empty;
        assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_INVALID);
    }
    struct layer layer;
    const fnl_camera cameras[2] = {test_front_camera(), test_front_camera()};
    make_layer(&layer, NULL);
    frame.overlay = &layer.overlay;
    frame.views = cameras;
    frame.view_count = 2;
    assert_int_equal(fnl_renderer_render(renderer, &frame), FNL_ERROR_UNSUPPORTED);
    frame.view_count = 0;
    test_render_frame(renderer, &frame);
    fnl_image picture = test_read(renderer, FNL_OUTPUT_COLOR);
    assert_int_equal(test_pixel8(&picture, 60, 25)[2], 204); /* without an image: white */
    free_picture(&picture);
    fnl_renderer_destroy(&renderer);
    fnl_scene_destroy(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_draws_go_over_the_picture), cmocka_unit_test(test_draws_show_their_own_images),
                                       cmocka_unit_test(test_what_reaches_outside_is_refused)};
    return cmocka_run_group_tests(tests, test_group_begin, test_group_end);
}
