/* SPDX-License-Identifier: MIT */
/* Headsets of --hmd: whatever the bytes, an error, or two eyes that a frame can be rendered for and poses that are finite at any time. */
#include "cli/headset.h"
#include "tests/fuzz/fuzz.h"

static bool finite_pose(fnl_rigid_pose pose) {
    const fnl_vec3 p = pose.position;
    const fnl_vec4 q = pose.rotation;
    return isfinite(p.x) && isfinite(p.y) && isfinite(p.z) && fabsf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-3f;
}

static void check_eye(const struct headset_eye *eye) {
    const fnl_eye *e = &eye->eye;
    if (!(e->left < e->right && e->down < e->up && isfinite(e->left) && isfinite(e->right) && isfinite(e->down) && isfinite(e->up))) abort();
    if (!finite_pose(e->pose) || eye->width > 16384 || eye->height > 16384 || !eye->width != !eye->height || eye->hidden_count % 3) abort();
    for (uint32_t i = 0; i < eye->hidden_count; i++)
        if (!isfinite(eye->hidden[i].x) || !isfinite(eye->hidden[i].y)) abort();
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < HEADSET_LENS_TERMS; k++)
            if (!isfinite(eye->lens.k[c][k])) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static const double times[] = {-1, 0, 0.3, 1, 1e9, -1e300, 1e300};
    struct headset h;
    if (!headset_load(fuzz_file("headset.json", bytes, size), &h)) {
        if (h.poses || h.eyes[0].hidden || h.eyes[1].hidden) abort();
        return 0;
    }
    for (int i = 0; i < HEADSET_EYES; i++) check_eye(&h.eyes[i]);
    for (size_t i = 0; i < COUNT_OF(times); i++) {
        const fnl_vec3 gaze = headset_gaze_at(&h, times[i]);
        if (!finite_pose(headset_pose_at(&h, times[i])) || !isfinite(gaze.x) || !isfinite(gaze.y) || !isfinite(gaze.z)) abort();
    }
    headset_set_ipd(&h, 0.07f);
    if (!isfinite(headset_ipd(&h))) abort();
    headset_free(&h);
    return 0;
}
