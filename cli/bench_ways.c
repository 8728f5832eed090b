/* SPDX-License-Identifier: MIT */
/* What a candidate varies beside shading and lists. */
#include "bench.h"

#include "arguments.h"

#include <stdio.h>
#include <string.h>

static const char *gbuffer_name(int i) { return fnl_gbuffer_name((fnl_gbuffer)i); }
static const char *transparency_name(int i) { return fnl_transparency_name((fnl_transparency)i); }
static const char *decals_name(int i) { return fnl_decals_name((fnl_decals)i); }
static const char *msaa_method_name(int i) { return fnl_msaa_method_name((fnl_msaa_method)i); }

static const char *visibility_sort_name(int i) { return fnl_visibility_sort_name((fnl_visibility_sort)i); }
static const char *switch_name(int i) { return i == 0 ? "off" : i == 1 ? "on" : NULL; }
static const char *mobile_layout_name(int i) { return fnl_mobile_layout_name((fnl_mobile_layout)i); }
static const char *mobile_lights_name(int i) { return fnl_mobile_lights_name((fnl_mobile_lights)i); }
static const char *mobile_gamma_name(int i) { return fnl_mobile_gamma_name((fnl_mobile_gamma)i); }

static const char *dais_name(int i) { return fnl_dais_mode_name((fnl_dais_mode)i); }
static const char *culling_name(int i) { return fnl_culling_name((fnl_culling)i); }
static const char *geometry_name(int i) { return i == FNL_GEOMETRY_AUTO ? NULL : fnl_geometry_name((fnl_geometry)i); }

static const struct {
    const char *key, *column;
    const char *(*name_of)(int);
} ways[BENCH_WAY_COUNT] = {
    [BENCH_WAY_GBUFFER] = {"gbuffer", "gbuffer", gbuffer_name},
    [BENCH_WAY_TRANSPARENCY] = {"transparency", "transparency", transparency_name},
    [BENCH_WAY_DECALS] = {"decals", "decals", decals_name},
    [BENCH_WAY_MSAA_METHOD] = {"msaa-method", "msaa_method", msaa_method_name},
    [BENCH_WAY_VISIBILITY_SORT] = {"visibility-sort", "visibility_sort", visibility_sort_name},
    [BENCH_WAY_BARYCENTRICS] = {"visibility-barycentrics", "visibility_barycentrics", switch_name},
    [BENCH_WAY_GRID] = {"visibility-grid", "visibility_grid", switch_name},
    [BENCH_WAY_MOBILE_LAYOUT] = {"mobile-layout", "mobile_layout", mobile_layout_name},
    [BENCH_WAY_MOBILE_LIGHTS] = {"mobile-lights", "mobile_lights", mobile_lights_name},
    [BENCH_WAY_MOBILE_GAMMA] = {"mobile-gamma", "mobile_gamma", mobile_gamma_name},
    [BENCH_WAY_DAIS] = {"dais", "dais", dais_name},
    [BENCH_WAY_DAIS_MULTIRATE] = {"dais-multirate", "dais_multirate", switch_name},
    [BENCH_WAY_CULL] = {"cull", "cull", culling_name},
    [BENCH_WAY_GEOMETRY] = {"geometry", "geometry", geometry_name},
    [BENCH_WAY_OCCLUSION] = {"occlusion", "occlusion", switch_name},
};

const char *bench_way_key(enum bench_way way) { return ways[way].key; }
const char *bench_way_name(enum bench_way way, int value) { return ways[way].name_of(value); }

struct bench_ways bench_ways_default(void) {
    fnl_frame frame = fnl_frame_default();
    return (struct bench_ways){.values = {[BENCH_WAY_GBUFFER] = (int)frame.gbuffer,
                                          [BENCH_WAY_TRANSPARENCY] = (int)frame.transparency,
                                          [BENCH_WAY_DECALS] = (int)frame.decals,
                                          [BENCH_WAY_MSAA_METHOD] = (int)frame.msaa_method,
                                          [BENCH_WAY_VISIBILITY_SORT] = (int)frame.visibility.sort,
                                          [BENCH_WAY_BARYCENTRICS] = frame.visibility.barycentrics,
                                          [BENCH_WAY_GRID] = frame.visibility.grid,
                                          [BENCH_WAY_MOBILE_LAYOUT] = (int)frame.mobile.layout,
                                          [BENCH_WAY_MOBILE_LIGHTS] = (int)frame.mobile.lights,
                                          [BENCH_WAY_MOBILE_GAMMA] = (int)frame.mobile.gamma,
                                          [BENCH_WAY_DAIS] = (int)frame.dais.mode,
                                          [BENCH_WAY_DAIS_MULTIRATE] = frame.dais.multirate,
                                          [BENCH_WAY_CULL] = (int)frame.culling,
                                          [BENCH_WAY_GEOMETRY] = (int)frame.geometry,
                                          [BENCH_WAY_OCCLUSION] = frame.occlusion}};
}

bool bench_way_heeded(enum bench_way way, int value, fnl_shading shading, uint32_t msaa) {
    bool has_gbuffer = shading == FNL_SHADING_DEFERRED || shading == FNL_SHADING_DEFERRED_VOLUMES;
    switch (way) {
    case BENCH_WAY_GBUFFER:
        return has_gbuffer;
    case BENCH_WAY_TRANSPARENCY:
        return shading != FNL_SHADING_INFERRED; /* which stipples blended surfaces, always */
    case BENCH_WAY_DECALS:                      /* without a G-buffer, and with samples, lists step in for it */
        return value != FNL_DECALS_GBUFFER || ((has_gbuffer || shading == FNL_SHADING_MOBILE) && msaa == 1);
    case BENCH_WAY_MSAA_METHOD:
        return shading == FNL_SHADING_DEFERRED && msaa > 1;
    case BENCH_WAY_VISIBILITY_SORT:
        return shading == FNL_SHADING_VISIBILITY;
    case BENCH_WAY_BARYCENTRICS:
    case BENCH_WAY_GRID:
        return shading == FNL_SHADING_VISIBILITY && msaa == 1;
    case BENCH_WAY_MOBILE_LAYOUT:
    case BENCH_WAY_MOBILE_LIGHTS:
    case BENCH_WAY_MOBILE_GAMMA:
        return shading == FNL_SHADING_MOBILE;
    case BENCH_WAY_DAIS:
    case BENCH_WAY_DAIS_MULTIRATE:
        return shading == FNL_SHADING_DAIS;
    case BENCH_WAY_CULL:
    case BENCH_WAY_GEOMETRY:
        return true;
    case BENCH_WAY_OCCLUSION:
        return shading != FNL_SHADING_LOW_RES && shading != FNL_SHADING_INFERRED;
    default:
        return false;
    }
}

void bench_ways_print(const struct bench_ways *chosen, const char *list_options, char *text, size_t capacity) {
    const struct bench_ways usual = bench_ways_default();
    size_t length = 0;
    *text = 0;
    for (int w = 0; w < BENCH_WAY_COUNT && length < capacity; w++)
        if (chosen->values[w] != usual.values[w])
            length += (size_t)snprintf(text + length, capacity - length, "%s%s=%s", length ? "," : "", ways[w].key,
                                       ways[w].name_of(chosen->values[w]));
    if (*list_options && length < capacity)
        snprintf(text + length, capacity - length, "%s%s", length ? "," : "", list_options);
}

bool bench_ways_parse(const char *options, struct bench_ways *chosen, char *list_options, size_t capacity) {
    *chosen = bench_ways_default();
    size_t used = 0;
    *list_options = 0;
    for (const char *from = options, *next; *from; from = next) {
        size_t length = strcspn(from, ","), key = strcspn(from, "=");
        int way = 0;
        next = from + length + (from[length] == ',');
        while (way < BENCH_WAY_COUNT && (key != strlen(ways[way].key) || strncmp(from, ways[way].key, key) != 0)) way++;
        if (way < BENCH_WAY_COUNT) {
            char value[64];
            snprintf(value, sizeof value, "%.*s", key < length ? (int)(length - key - 1) : 0,
                     key < length ? from + key + 1 : "");
            if (!argument_name(ways[way].key, value, ways[way].name_of, &chosen->values[way])) return false;
        } else {
            if (used + length + 2 > capacity) return false;
            used += (size_t)snprintf(list_options + used, capacity - used, "%s%.*s", used ? "," : "", (int)length, from);
        }
    }
    return true;
}

bool bench_ways_apply(const char *options, fnl_frame *frame) {
    struct bench_ways chosen;
    char list_options[512];
    if (!bench_ways_parse(options, &chosen, list_options, sizeof list_options)) return false;
    frame->gbuffer = (fnl_gbuffer)chosen.values[BENCH_WAY_GBUFFER];
    frame->transparency = (fnl_transparency)chosen.values[BENCH_WAY_TRANSPARENCY];
    frame->decals = (fnl_decals)chosen.values[BENCH_WAY_DECALS];
    frame->msaa_method = (fnl_msaa_method)chosen.values[BENCH_WAY_MSAA_METHOD];
    frame->visibility.sort = (fnl_visibility_sort)chosen.values[BENCH_WAY_VISIBILITY_SORT];
    frame->visibility.barycentrics = chosen.values[BENCH_WAY_BARYCENTRICS];
    frame->visibility.grid = chosen.values[BENCH_WAY_GRID];
    frame->mobile.layout = (fnl_mobile_layout)chosen.values[BENCH_WAY_MOBILE_LAYOUT];
    frame->mobile.lights = (fnl_mobile_lights)chosen.values[BENCH_WAY_MOBILE_LIGHTS];
    frame->mobile.gamma = (fnl_mobile_gamma)chosen.values[BENCH_WAY_MOBILE_GAMMA];
    frame->dais.mode = (fnl_dais_mode)chosen.values[BENCH_WAY_DAIS];
    frame->dais.multirate = chosen.values[BENCH_WAY_DAIS_MULTIRATE];
    frame->culling = (fnl_culling)chosen.values[BENCH_WAY_CULL];
    frame->geometry = (fnl_geometry)chosen.values[BENCH_WAY_GEOMETRY];
    frame->occlusion = chosen.values[BENCH_WAY_OCCLUSION];
    return argument_list_options("list-option", list_options, &frame->list_options);
}

void bench_ways_of(const char *options, char *text, size_t capacity) {
    struct bench_ways chosen;
    char list_options[512];
    *text = 0;
    if (!bench_ways_parse(options, &chosen, list_options, sizeof list_options)) return;
    chosen.values[BENCH_WAY_CULL] = bench_ways_default().values[BENCH_WAY_CULL];
    chosen.values[BENCH_WAY_OCCLUSION] = bench_ways_default().values[BENCH_WAY_OCCLUSION];
    bench_ways_print(&chosen, "", text, capacity);
}

void bench_ways_describe(const struct bench_candidate *candidate, uint32_t msaa, json_t *result) {
    struct bench_ways chosen;
    char list_options[512], text[256];
    if (!bench_ways_parse(candidate->options, &chosen, list_options, sizeof list_options)) return;
    for (int w = 0; w < BENCH_WAY_COUNT; w++) {
        bool heeded = bench_way_heeded((enum bench_way)w, chosen.values[w], candidate->shading, msaa);
        json_object_set_new(result, ways[w].column, json_string(heeded ? ways[w].name_of(chosen.values[w]) : ""));
    }
    bench_ways_of(candidate->options, text, sizeof text);
    json_object_set_new(result, "ways", json_string(text));
}
