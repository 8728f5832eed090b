/* SPDX-License-Identifier: MIT */
/* Frame times: what was missed, how large the next frame may be, and how good the predictions of poses were. */
#include "xr/xr.h"

#include <stdlib.h>

static double budget_of(const struct xr *x) { return x->options->budget > 0 ? x->options->budget : x->numbers.period; }

void xr_pace(struct xr *x, const XrFrameState *state) {
    struct xr_numbers *n = &x->numbers;
    n->waited++;
    n->period = (double)state->predictedDisplayPeriod * 1e-6;
    if (x->past_display && state->predictedDisplayPeriod > 0) {
        const int64_t steps = (state->predictedDisplayTime - x->past_display + state->predictedDisplayPeriod / 2) / state->predictedDisplayPeriod;
        if (steps > 1) n->missed += (uint32_t)(steps - 1);
    }
    x->past_display = state->predictedDisplayTime;
}

static int compare_times(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* By sixteenths: each new size makes the images of a frame anew. */
static void set_scale(struct xr *x, float scale) {
    scale = fminf(fmaxf(roundf(scale * 16) / 16, 0.5f), 1);
    x->calm = x->frames_of_scale = 0;
    if (scale == x->scale) return;
    x->scale = scale;
    x->numbers.scale_changes++;
    x->numbers.least_scale = fminf(x->numbers.least_scale, scale);
}

/* Pixels are what costs, so the time goes with the square of the scale. Falls at once, rises after a second of ease. */
static void choose_scale(struct xr *x) {
    enum { WINDOW = sizeof x->recent / sizeof *x->recent };
    const double budget = budget_of(x);
    double sorted[WINDOW];
    if (x->options->scale > 0 || budget <= 0 || x->frames_of_scale < WINDOW) return;
    for (uint32_t i = 0; i < WINDOW; i++) sorted[i] = x->recent[i];
    qsort(sorted, WINDOW, sizeof *sorted, compare_times);
    const double time = sorted[WINDOW / 2];
    if (time > 0.95 * budget) {
        set_scale(x, fminf(x->scale - 1.0f / 16, x->scale * (float)sqrt(0.85 * budget / time)));
        return;
    }
    x->calm = time < 0.75 * budget ? x->calm + 1 : 0;
    if (x->calm * x->numbers.period >= 1000) set_scale(x, x->scale + 1.0f / 16);
}

void xr_note_times(struct xr *x, double cpu, double gpu) {
    struct xr_numbers *n = &x->numbers;
    const double time = fmax(cpu, gpu);
    n->cpu[n->time_count % XR_TIMES] = cpu;
    n->gpu[n->time_count % XR_TIMES] = gpu;
    n->time_count++;
    n->over_budget += time > budget_of(x);
    x->recent[x->frames_of_scale++ % (sizeof x->recent / sizeof *x->recent)] = time;
    choose_scale(x);
}

static double distance(fnl_vec3 a, fnl_vec3 b) {
    const fnl_vec3 d = sub3(a, b);
    return sqrt((double)dot3(d, d));
}

void xr_note_prediction(struct xr *x, XrTime display, const fnl_rigid_pose *simulated, const fnl_rigid_pose *rendered) {
    struct xr_numbers *n = &x->numbers;
    struct xr_past *place = &x->past[x->past_count % XR_PAST];
    if (x->past_count >= XR_PAST) { /* shown long ago: the runtime knows where the head was then */
        XrSpaceLocation location = {.type = XR_TYPE_SPACE_LOCATION};
        const XrResult result = xrLocateSpace(x->head_space, x->space, place->display, &location);
        if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST) xr_good(x, "xrLocateSpace", result);
        const XrSpaceLocationFlags wanted = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
        if (XR_SUCCEEDED(result) && (location.locationFlags & wanted) == wanted && xr_is_pose(x, XR_POSE_HEAD, &location.pose)) {
            const double meter = (double)x->options->world_scale;
            const fnl_rigid_pose truth = xr_pose(x, &location.pose);
            n->predictions++;
            n->simulated_metres += distance(place->simulated.position, truth.position) / meter;
            n->rendered_metres += distance(place->rendered.position, truth.position) / meter;
            n->simulated_radians += (double)angle_between(place->simulated.rotation, truth.rotation);
            n->rendered_radians += (double)angle_between(place->rendered.rotation, truth.rotation);
        }
    }
    *place = (struct xr_past){display, *simulated, *rendered};
    x->past_count++;
}
