/* SPDX-License-Identifier: MIT */
/*
 * Table 20.1 of Real-Time Rendering (4th edition, 2018) as measured numbers: the four pipelines that chapter 20 compares, on
 * one scene, beside what the table says of them.
 */
#include "bench.h"

#include <math.h>
#include <string.h>

static const char scene[] = "builtin:city";
enum { PIPELINES = 4 };
static const struct pipeline {
    const char *name;
    struct bench_candidate way;
} pipelines[PIPELINES] = {{"forward, lists per mesh", BENCH_RTR20_FORWARD},
                          {"deferred, light volumes", BENCH_RTR20_VOLUMES},
                          {"clustered deferred", BENCH_RTR20_DEFERRED},
                          {"clustered forward", BENCH_RTR20_PREPASS}};

/* The result of a pipeline; NULL: not measured. All have one size. */
static const json_t *find(const struct bench_data *data, const struct pipeline *of, const char *where, uint32_t msaa) {
    const json_t *first = json_array_get(json_object_get(data->root, "results"), 0);
    const struct bench_case at = {.scene = where,
                                  .lights = 256,
                                  .width = (uint32_t)bench_number(first, "width", 0),
                                  .height = (uint32_t)bench_number(first, "height", 0),
                                  .msaa = msaa};
    return bench_find(data, &at, &of->way);
}

static double lights_of(const json_t *result) { return bench_number(result, "per_pixel", NAN); }
static double lists_of(const json_t *result) { return bench_number(result, "list_used_bytes", 0) / 1024; }
static double passes_of(const json_t *result) { return result ? (double)json_array_size(json_object_get(result, "passes")) : NAN; }
static double bytes_of(const json_t *result) {
    return (bench_number(result, "image_bytes_read", NAN) + bench_number(result, "image_bytes_written", NAN)) /
           (bench_number(result, "width", NAN) * bench_number(result, "height", NAN));
}

/* A number of the plain case. Without `number`: the time of another case, relative to the plain one. */
static const struct quantity {
    const char *name, *source;
    double (*number)(const json_t *result);
    const char *scene;
    uint32_t msaa;
} quantities[] = {
    {"passes of a frame", "geometry 1, 1, 1, 1-2; lights 0, 1 per light, 1, 1", passes_of, NULL, 0},
    {"lights evaluated per pixel", "culled per mesh, per pixel, per volume, per volume", lights_of, NULL, 0},
    {"light lists, KiB", "", lists_of, NULL, 0},
    {"image bytes read and written per pixel", "low, high, medium, low", bytes_of, NULL, 0},
    {"time with 4 samples / with 1", "built-in, hard, hard, built-in", NULL, scene, 4},
    {"time with small triangles / as built", "slow, fast, fast, slow", NULL, BENCH_RTR20_SMALL, 1},
    {"time with 2000 decals / without", "expensive, cheap, cheap, expensive", NULL, BENCH_RTR20_DECALS, 1},
};

void bench_table_rtr20(const struct bench_data *data, json_t *tables) {
    json_t *table = json_pack("{s:s,s:s,s:[s],s:[],s:[s,s,s,s]}", "name", "pipelines", "title",
                              "Four pipelines on the city with 256 lights, beside table 20.1 of the source", "columns", "<quantity", "rows", "lines",
                              "Transparency (source: easy, no, with forward, easy): Fanal shades blended surfaces forward, with the frame's lists, in all four.",
                              "Registers (source: possibly high, low, possibly low, possibly high): see docs/performance.md, compiled for GPUs.",
                              "Reuse of one shadow map by all lights (source: no, yes, no, no): Fanal keeps pages of all lights; only lists=multipass draws one light at a time.",
                              "Ranking 9, shades that are reused every second frame, needs texture-space shading, which Fanal does not have.");
    json_t *columns = json_object_get(table, "columns"), *rows = json_object_get(table, "rows");
    for (int p = 0; p < PIPELINES; p++) json_array_append_new(columns, json_string(pipelines[p].name));
    json_array_append_new(columns, json_string("<source"));
    for (size_t i = 0; i < sizeof quantities / sizeof *quantities; i++) {
        const struct quantity *q = &quantities[i];
        json_t *row = json_pack("[s]", q->name);
        for (int p = 0; p < PIPELINES; p++) {
            const json_t *plain = find(data, &pipelines[p], scene, 1);
            const double value = q->number ? q->number(plain) : bench_median(find(data, &pipelines[p], q->scene, q->msaa), "gpu_ms") / bench_median(plain, "gpu_ms");
            json_array_append_new(row, plain && isfinite(value) ? json_real(value) : json_null());
        }
        json_array_append_new(row, json_string(q->source));
        json_array_append_new(rows, row);
    }
    json_array_append_new(tables, table);
}
