/* SPDX-License-Identifier: MIT */
/* Frames with any options together (tests/mixture.h): no crash, no message of the validation layer, no NaN, and the same picture without what must not change it. */
#include "tests/mixture.h"

#include "render/renderer_internal.h"
#include "tests/fuzz/fuzz.h"

#define EXPECT(condition)           \
    do {                            \
        if (!(condition)) abort();  \
    } while (0)

/* Never destroyed, as the driver's own leaks are none of ours. */
static fnl_renderer *find_renderer(fnl_device **device, fnl_frame *base) {
    static fnl_renderer *renderer;
    static fnl_device *made;
    static fnl_frame frame;
    if (!renderer) {
        const fnl_host host = fuzz_host();
        fnl_device_params params = fnl_device_params_default();
        fnl_scene *scene;
        params.host = host;
        params.host.thread_count = 1;
        params.cache_folder = "";
        params.validate = true;
        EXPECT(fnl_device_create(&params, &made) == FNL_OK);
        EXPECT(scene_load_plain(&host, "builtin:glass?lights=24", NULL, &scene) == FNL_OK);
        frame = frame_plain();
        EXPECT(fnl_scene_query_camera(scene, 0, &frame.camera) == FNL_OK);
        for (int i = 0; i < 6; i++) {
            fnl_probe_params probe = fnl_probe_params_default();
            fnl_probe_id id;
            probe.centre = frame.camera.target;
            probe.centre.x += (float)i - 2.5f;
            probe.half_size = (fnl_vec3){2, 2, 2};
            probe.face_size = 16;
            probe.reflection = true;
            EXPECT(fnl_scene_add_probe(scene, &probe, &id) == FNL_OK);
        }
        EXPECT(fnl_renderer_create(made, scene, &renderer) == FNL_OK);
        frame.outputs = FNL_OUTPUT_RADIANCE;
        frame.exposure = FNL_EXPOSURE_EV;
        frame.ev = 5;
        frame.timers = false;
        frame.reset_history = true;
        frame.shadow.page_rays = 64; /* not measured */
    }
    *device = made;
    *base = frame;
    return renderer;
}

static bool renders(fnl_renderer *renderer, const fnl_frame *frame, fnl_image *image) {
    const fnl_result result = fnl_renderer_render(renderer, frame);
    EXPECT(result == FNL_OK || result == FNL_ERROR_UNSUPPORTED || result == FNL_ERROR_INVALID);
    if (result != FNL_OK) return false;
    EXPECT(fnl_renderer_read(renderer, FNL_OUTPUT_RADIANCE, image) == FNL_OK);
    const float *values = image->pixels;
    for (size_t i = 0; i < (size_t)image->width * image->height * 4; i++) EXPECT(isfinite(values[i]));
    return true;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static struct mixture m;
    const fnl_host host = fuzz_host();
    fnl_device *device;
    fnl_frame base;
    fnl_image image, want;
    fnl_renderer *renderer = find_renderer(&device, &base);
    mixture_make(&m, bytes, size, &base);
    if (!renders(renderer, &m.frame, &image)) return 0;
    const fnl_frame plainest = mixture_plainest(&m);
    if (renders(renderer, &plainest, &want)) {
        EXPECT(memcmp(image.pixels, want.pixels, (size_t)image.width * image.height * 16) == 0);
        fnl_image_free(&host, &want);
    }
    fnl_image_free(&host, &image);
    EXPECT(fnl_device_validation_count(device) == 0);
    return 0;
}
