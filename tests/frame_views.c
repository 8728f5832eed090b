/* SPDX-License-Identifier: MIT */
#include "tests/frame_views.h"

void views_place(const struct stage *stage, fnl_camera cameras[VIEWS_MOST]) {
    vec3 target = stage->frame.camera.target, eye = stage->frame.camera.position;
    vec3 back = vec3_sub(eye, target);
    for (int i = 0; i < VIEWS_MOST; i++) {
        float angle = 1.1f * (float)i, scale = 1 - 0.12f * (float)i, c = cosf(angle), s = sinf(angle);
        cameras[i] = stage->frame.camera;
        cameras[i].position =
            vec3_add(target, vec3_scale((vec3){c * back.x + s * back.z, back.y, c * back.z - s * back.x}, scale));
    }
    cameras[1].shift = (vec2){0.3f, -0.2f};
    cameras[2].orthographic = true;
    cameras[2].vertical_extent = 0.8f * vec3_length(back);
    cameras[2].far_distance = 4 * vec3_length(back);
    cameras[3].vertical_fov = 1.5f;
}

void views_check_picture(const fnl_image *all, uint32_t view, const fnl_image *one, const char *what) {
    size_t size = (size_t)one->width * one->height * (one->format == FNL_PIXEL_FORMAT_RGBA8 ? 4 : 16);
    assert_int_equal(all->width, one->width);
    assert_int_equal(all->format, one->format);
    assert_int_equal(all->height % one->height, 0);
    assert_true(view < all->height / one->height);
    if (memcmp((const char *)all->pixels + view * size, one->pixels, size) != 0)
        fail_msg("%s: view %u differs from the frame with its camera", what, view);
}

void views_check(struct stage *stage, const fnl_frame *frame, const fnl_camera *cameras, uint32_t count, const char *what) {
    fnl_frame many = *frame, single = *frame;
    many.views = cameras;
    many.view_count = count;
    struct shot all = stage_shoot(stage, &many);
    assert_int_equal(all.stats.view_count, count);
    if (frame->outputs & FNL_OUTPUT_COLOR) assert_int_equal(all.color.height, count * frame->height);
    const fnl_frame_stats *stats = all.stats.views;
    for (uint32_t i = 0; i < count; i++) {
        single.camera = cameras[i];
        struct shot one = stage_shoot(stage, &single);
        if (frame->outputs & FNL_OUTPUT_COLOR) views_check_picture(&all.color, i, &one.color, what);
        if (frame->outputs & FNL_OUTPUT_RADIANCE) views_check_picture(&all.radiance, i, &one.radiance, what);
        if (frame->outputs & FNL_OUTPUT_POSITION) views_check_picture(&all.position, i, &one.position, what);
        assert_int_equal(one.stats.view_count, 0);
        assert_int_equal(stats[i].items_visible, one.stats.items_visible);
        assert_int_equal(stats[i].lights_in_view, one.stats.lights_in_view);
        assert_int_equal(stats[i].list_entries, one.stats.list_entries);
        assert_int_equal(stats[i].triangles_drawn, one.stats.triangles_drawn);
        assert_int_equal(stats[i].evaluations, one.stats.evaluations);
        assert_int_equal(stats[i].triangles_visible, one.stats.triangles_visible);
        assert_int_equal(stats[i].counter_count, one.stats.counter_count);
        for (uint32_t k = 0; k < one.stats.counter_count; k++) {
            const fnl_counter *own = &one.stats.counters[k];
            if (counter(&stats[i], own->key) != own->value)
                fail_msg("%s: view %u has another %s than the frame with its camera", what, i, own->key);
        }
        assert_memory_equal(&stats[i].ev, &one.stats.ev, sizeof one.stats.ev);
        shot_free(&one);
    }
    shot_free(&all);
}
