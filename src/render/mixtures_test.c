/* SPDX-License-Identifier: MIT */
/** Options together that nobody thought of together (tests/mixture.h). FANAL_MIXTURES=FIRST-LAST: these seeds instead of the usual ones. */
#include "tests/mixture.h"
#include "tests/render_harness.h"

#include <stdlib.h>

enum { USUAL = 12, WORLDS = 2 };

static void add_probes(fnl_scene *scene, const fnl_camera *camera) {
    for (int i = 0; i < 6; i++) {
        fnl_probe_params params = fnl_probe_params_default();
        fnl_probe_id id;
        params.centre = camera->target;
        params.centre.x += (float)i - 2.5f;
        params.half_size = (fnl_vec3){2, 2, 2};
        params.face_size = 16;
        params.blend = 0.3f;
        params.reflection = true;
        assert_int_equal(fnl_scene_add_probe(scene, &params, &id), FNL_OK);
    }
}

/* Room for bytes, from a generator whose numbers are the same everywhere (xorshift; Marsaglia 2003). */
static void fill(uint32_t seed, uint8_t bytes[64]) {
    uint32_t x = seed * 2654435761u + 1;
    for (int i = 0; i < 64; i++) {
        x ^= x << 13, x ^= x >> 17, x ^= x << 5;
        bytes[i] = (uint8_t)(x >> 11);
    }
}

static bool renders(const struct stage *stage, const fnl_frame *frame) {
    const fnl_result result = fnl_renderer_render(stage->renderer, frame);
    if (result != FNL_OK && result != FNL_ERROR_UNSUPPORTED && result != FNL_ERROR_INVALID) fail_msg("result %d", result);
    return result == FNL_OK;
}

static fnl_image radiance_of(const struct stage *stage) {
    fnl_image image;
    assert_int_equal(fnl_renderer_read(stage->renderer, FNL_OUTPUT_RADIANCE, &image), FNL_OK);
    return image;
}

static bool check(struct stage *stage, uint32_t seed) {
    static struct mixture m;
    uint8_t bytes[64];
    fill(seed, bytes);
    fnl_frame base = stage->frame;
    base.outputs = FNL_OUTPUT_RADIANCE;
    base.reset_history = true;
    base.shadow.page_rays = 64; /* not measured, or it is chance which lights get rays */
    mixture_make(&m, bytes, sizeof bytes, &base);
    if (!renders(stage, &m.frame)) return false;
    fnl_image image = radiance_of(stage);
    const uint64_t broken = count_broken(&image);
    fnl_frame plainest = mixture_plainest(&m);
    uint64_t differing = 0;
    if (renders(stage, &plainest)) {
        fnl_image want = radiance_of(stage);
        differing = count_differing(&image, &want);
        fnl_image_free(gpu_host(harness_device()), &want);
    }
    fnl_image_free(gpu_host(harness_device()), &image);
    if (broken || differing)
        fail_msg("%u: %s: %llu pixels are no radiance, %llu differ from the plain frame's", seed, m.text, (unsigned long long)broken, (unsigned long long)differing);
    return true;
}

static void test_mixtures_change_nothing_that_they_must_not(void **state) {
    UNUSED(state);
    static const char *const sources[WORLDS] = {"builtin:glass?lights=24", "builtin:hall?lights=60&decals=20"};
    const char *range = getenv("FANAL_MIXTURES");
    unsigned first = 0, last = USUAL - 1, rendered = 0;
    if (range && sscanf(range, "%u-%u", &first, &last) != 2) fail_msg("FANAL_MIXTURES is not FIRST-LAST");
    for (uint32_t w = 0; w < WORLDS; w++) {
        struct stage stage = stage_open(sources[w], 0);
        add_probes(stage.scene, &stage.frame.camera);
        for (uint32_t seed = first; seed <= last; seed++)
            if (seed % WORLDS == w) rendered += check(&stage, seed);
        stage_close(&stage);
    }
    print_message("%u of %u were rendered\n", rendered, last - first + 1);
    assert_true(2 * rendered > last - first);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(test_mixtures_change_nothing_that_they_must_not, harness_check)};
    return cmocka_run_group_tests(tests, harness_begin, harness_end);
}
