/* SPDX-License-Identifier: MIT */
/* The numbers of a session, as text and as JSON: docs/xr.md describes them. */
#include "xr/xr.h"

#include "json_text.h"
#include "output.h"
#include "print.h"
#include "program.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct spread {
    double median, p95, high;
};

static int compare_times(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static struct spread spread_of(const double *times, uint32_t count) {
    if (count > XR_TIMES) count = XR_TIMES;
    double *sorted = count ? malloc(count * sizeof *sorted) : NULL;
    if (!sorted) return (struct spread){0, 0, 0};
    memcpy(sorted, times, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_times);
    const struct spread s = {sorted[count / 2], sorted[(uint32_t)(0.95 * (count - 1))], sorted[count - 1]};
    free(sorted);
    return s;
}

static const char *state_name(uint32_t state) {
    static const char *const names[] = {"unknown", "idle", "ready", "synchronized", "visible", "focused", "stopping", "loss_pending", "exiting"};
    return state < sizeof names / sizeof *names ? names[state] : "unknown";
}

static const char *format_name(int64_t format) {
    switch (format) {
    case VK_FORMAT_R8G8B8A8_SRGB:
        return "R8G8B8A8_SRGB";
    case VK_FORMAT_B8G8R8A8_SRGB:
        return "B8G8R8A8_SRGB";
    case VK_FORMAT_R16G16B16A16_SFLOAT:
        return "R16G16B16A16_SFLOAT";
    case VK_FORMAT_R8G8B8A8_UNORM:
        return "R8G8B8A8_UNORM";
    default:
        return "B8G8R8A8_UNORM";
    }
}

static const char *space_name(const struct xr *x) { return x->space_type == XR_REFERENCE_SPACE_TYPE_STAGE ? "stage" : "local"; }

static double budget_of(const struct xr *x) { return x->options->budget > 0 ? x->options->budget : x->numbers.period; }

static double mean(double sum, uint32_t count) { return count ? sum / count : 0; }

void xr_print(const struct xr *x) {
    const struct xr_numbers *n = &x->numbers;
    const struct spread cpu = spread_of(n->cpu, n->time_count), gpu = spread_of(n->gpu, n->time_count);
    printf("%s, %s: %u views, %s, %s%s, space %s\n", x->system_name, x->runtime_name, x->view_count, x->device_info.name, format_name(x->color_format),
           x->depth_format ? " with depth" : "", space_name(x));
    printf("%u frames rendered of %u, %u missed; budget %.2f ms, of which %u frames took more\n", n->rendered, n->waited, n->missed, budget_of(x), n->over_budget);
    printf("CPU %.2f ms (median), %.2f (95 %%), %.2f (most); GPU %.2f ms, %.2f, %.2f\n", cpu.median, cpu.p95, cpu.high, gpu.median, gpu.p95, gpu.high);
    printf("resolution %.0f %% (least %.0f %%)\n", (double)(100 * x->scale), (double)(100 * n->least_scale));
    if (n->predictions)
        printf("head as predicted at the frame's start off by %.2f mm, %.2f mrad; when rendered by %.2f mm, %.2f mrad\n", 1e3 * mean(n->simulated_metres, n->predictions),
               1e3 * mean(n->simulated_radians, n->predictions), 1e3 * mean(n->rendered_metres, n->predictions), 1e3 * mean(n->rendered_radians, n->predictions));
    if (xr_wants_gaze(x))
        printf("foveation followed the eyes in %u frames, and lay in the middle in %u%s\n", n->gaze_frames, n->rendered - n->gaze_frames,
               n->gaze_frames ? "" : ": the headset does not tell where they look");
    if (n->losses) printf("the runtime lost the session %u times\n", n->losses);
}

/* ---- JSON ---- */

static json_t *vector(fnl_vec3 v) { return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z); }

static json_t *spread_json(struct spread s) { return json_pack("{s:f,s:f,s:f}", "median", s.median, "p95", s.p95, "max", s.high); }

static json_t *last_json(const struct xr_numbers *n) {
    json_t *views = json_array();
    for (uint32_t i = 0; i < n->last_count; i++) {
        const fnl_camera *c = &n->last_cameras[i];
        json_array_append_new(views, json_pack("{s:[i,i],s:o,s:o,s:o,s:f,s:[f,f],s:f,s:f,s:f}", "size", (int)n->last_width[i], (int)n->last_height[i], "position",
                                               vector(c->position), "target", vector(c->target), "up", vector(c->up), "vertical_fov", (double)c->vertical_fov,
                                               "shift", (double)c->shift.x, (double)c->shift.y, "pixel_aspect", (double)c->pixel_aspect, "near_distance",
                                               (double)c->near_distance, "hidden", n->last_hidden[i]));
    }
    const fnl_vec4 r = n->last_rig.rotation;
    return json_pack("{s:I,s:{s:o,s:[f,f,f,f]},s:o}", "display_time", (json_int_t)n->last_display, "rig", "position", vector(n->last_rig.position), "rotation",
                     (double)r.x, (double)r.y, (double)r.z, (double)r.w, "views", views);
}

static json_t *states_json(const struct xr_numbers *n) {
    json_t *states = json_array();
    for (uint32_t i = 0; i < n->state_count; i++) json_array_append_new(states, json_string(state_name(n->states[i])));
    return states;
}

static json_t *prediction_json(const struct xr_numbers *n) {
    return json_pack("{s:i,s:{s:f,s:f},s:{s:f,s:f}}", "frames", (int)n->predictions, "simulated", "metres", mean(n->simulated_metres, n->predictions), "radians",
                     mean(n->simulated_radians, n->predictions), "rendered", "metres", mean(n->rendered_metres, n->predictions), "radians",
                     mean(n->rendered_radians, n->predictions));
}

static json_t *all_json(const struct xr *x) {
    const struct xr_numbers *n = &x->numbers;
    json_t *j = json_pack("{s:i,s:s,s:s,s:s,s:s,s:s,s:i,s:s,s:s,s:b}", "version", 1, "fanal", fnl_version(), "commit", program_commit, "runtime", x->runtime_name,
                          "system", x->system_name, "device", x->device_info.name, "views", (int)x->view_count, "space", space_name(x), "format",
                          format_name(x->color_format), "depth", x->depth_format != 0);
    json_object_set_new(j, "sessions", json_pack("{s:i,s:i,s:i,s:o}", "connections", (int)n->connections, "lost", (int)n->losses, "recentered", (int)n->recenters, "states", states_json(n)));
    json_object_set_new(j, "frames",
                        json_pack("{s:i,s:i,s:i,s:i,s:i}", "waited", (int)n->waited, "rendered", (int)n->rendered, "discarded", (int)n->discarded, "missed",
                                  (int)n->missed, "over_budget", (int)n->over_budget));
    json_object_set_new(j, "times",
                        json_pack("{s:f,s:f,s:o,s:o}", "period_ms", n->period, "budget_ms", budget_of(x), "cpu_ms", spread_json(spread_of(n->cpu, n->time_count)),
                                  "gpu_ms", spread_json(spread_of(n->gpu, n->time_count))));
    json_object_set_new(j, "resolution", json_pack("{s:f,s:f,s:i}", "scale", (double)x->scale, "least", (double)n->least_scale, "changes", (int)n->scale_changes));
    json_object_set_new(j, "world_scale", json_real((double)x->options->world_scale));
    json_object_set_new(j, "prediction", prediction_json(n));
    json_object_set_new(j, "mask", json_pack("{s:i,s:i,s:i}", "reads", (int)n->mask_reads, "changes", (int)n->mask_changes, "frames", (int)n->mask_frames));
    json_object_set_new(j, "input", json_pack("{s:i,s:i,s:i,s:o}", "teleports", (int)n->teleports, "grabs", (int)n->grabs, "light_moves", (int)n->light_moves, "light",
                                            n->light_moves ? vector(n->last_light) : json_null()));
    json_object_set_new(j, "gaze", json_pack("{s:i,s:o}", "frames", (int)n->gaze_frames, "point", n->gaze_last ? vector(n->last_gaze) : json_null()));
    json_object_set_new(j, "last", last_json(n));
    return j;
}

bool xr_save_stats(const struct xr *x) {
    json_t *json = all_json(x);
    char *text = json ? json_text_write(json, JSON_INDENT(1) | JSON_REAL_PRECISION(12)) : NULL;
    json_decref(json);
    bool good = text != NULL;
    if (!text) fputs("fanal: error: --stats: memory ran out\n", stderr);
    else if (strcmp(x->options->stats, "-") == 0) puts(text); /* own text */
    else {
        const size_t length = strlen(text);
        text[length] = '\n'; /* in place of the zero */
        good = output_save(x->options->stats, text, length + 1);
    }
    free(text);
    return good;
}
