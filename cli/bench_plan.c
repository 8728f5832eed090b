/* SPDX-License-Identifier: MIT */
/* What is measured: cases, and of each the ways to render that are compared. */
#include "bench.h"

#include "json_text.h"
#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- cases and candidates ---- */

static bool same_case(const struct bench_case *a, const struct bench_case *b) {
    return strcmp(a->scene, b->scene) == 0 && a->lights == b->lights && a->width == b->width && a->height == b->height &&
           a->msaa == b->msaa;
}

struct bench_case *bench_plan_case(struct bench_plan *plan, const struct bench_case *wanted) {
    for (uint32_t i = 0; i < plan->case_count; i++)
        if (same_case(&plan->cases[i], wanted)) return &plan->cases[i];
    struct bench_case *bigger = realloc(plan->cases, (plan->case_count + 1) * sizeof *bigger);
    if (!bigger) return NULL;
    plan->cases = bigger;
    struct bench_case *added = &bigger[plan->case_count++];
    *added = *wanted;
    added->candidates = NULL;
    added->candidate_count = 0;
    return added;
}

static bool skip(struct bench_plan *plan, const struct bench_case *where, const struct bench_candidate *what,
                 const char *reason) {
    json_t *entry = bench_key(where, what);
    const json_t *other;
    size_t i;
    if (!entry) return false;
    json_object_set_new(entry, "reason", json_text(reason));
    json_array_foreach(plan->skipped, i, other) {
        if (!json_equal(entry, other)) continue;
        json_decref(entry);
        return true;
    }
    return json_array_append_new(plan->skipped, entry) == 0;
}

bool bench_plan_candidate(struct bench_plan *plan, struct bench_case *to, const struct bench_candidate *candidate) {
    for (uint32_t i = 0; i < to->candidate_count; i++) {
        const struct bench_candidate *other = &to->candidates[i];
        if (other->shading == candidate->shading && other->lists == candidate->lists &&
            strcmp(other->options, candidate->options) == 0)
            return true;
    }
    if (!fnl_shading_supports(candidate->shading, candidate->lists, 1))
        return skip(plan, to, candidate, "these lists do not go with this shading path");
    if (!fnl_shading_supports(candidate->shading, candidate->lists, to->msaa))
        return skip(plan, to, candidate, "this shading path has no MSAA");
    if (strstr(candidate->options, "visibility.barycentrics=on") && strstr(candidate->options, "visibility.grid=on"))
        return skip(plan, to, candidate, "the grid stores no barycentrics");
    if (strstr(candidate->options, "geometry=mesh") && !strstr(candidate->options, "culling="))
        return skip(plan, to, candidate, "mesh shaders draw what culling by clusters or triangles leaves");
    struct bench_candidate *bigger = realloc(to->candidates, (to->candidate_count + 1) * sizeof *bigger);
    if (!bigger) return false;
    to->candidates = bigger;
    bigger[to->candidate_count] = *candidate;
    bigger[to->candidate_count].options = strdup(candidate->options);
    return bigger[to->candidate_count++].options != NULL;
}

/* ---- the matrix of the command ---- */

/*
 * The likely ways, where no orders or lists are named: the pairs that `auto` would measure in a scene of so many lights. Its rules, which are
 * the library's (fnl_shading_likely), are the one table of them. Brute force, which `auto` tries with few lights alone, joins as
 * what the others are to be compared with, as long as it takes no more than a few times as long: of the orders that `auto` takes, with the default
 * one; of orders that are named, with each.
 */
enum { BRUTE_LIGHTS = 4096, MAPS_LIGHTS = 65536 };
static bool lists_likely(const struct bench_matrix *m, fnl_shading shading, fnl_light_lists lists, uint32_t lights,
                         uint32_t msaa) {
    if (lists == FNL_LISTS_ALL && lights <= BRUTE_LIGHTS &&
        (m->shading_count || m->every_shading || shading == bench_frame().shading))
        return true;
    return fnl_shading_likely(shading, lists, lights, msaa) & FNL_LIKELY_LISTS;
}

/* Otherwise times and pictures are the same with all lists but for transparent surfaces: one stands for all. */
static bool lists_matter(fnl_shading shading) {
    return !(fnl_shading_likely(shading, FNL_LISTS_AUTO, 0, 1) & FNL_LIKELY_BLENDED);
}

/* Sets what makes a difference. */
static bool set_heeded(fnl_frame *frame, const fnl_option *option, const char *value, fnl_shading shading, fnl_light_lists lists,
                       uint32_t msaa) {
    return !bench_way_heeded(option, value, shading, lists, msaa) || options_set(frame, "set", option->key, value);
}

static bool set_fixed(fnl_frame *frame, const char *set, fnl_shading shading, fnl_light_lists lists, uint32_t msaa) {
    char copy[512], *rest = copy;
    fnl_option option;
    snprintf(copy, sizeof copy, "%s", set);
    for (char *part; *set && (part = strsep(&rest, ","));) {
        char *value = strchr(part, '=');
        *value++ = 0; /* bench.c has tried them */
        if (!fnl_option_find(part, &option) || !set_heeded(frame, &option, value, shading, lists, msaa)) return false;
    }
    return true;
}

/* Every combination of the options that were asked for; those that a path or list does not heed add nothing. */
static bool plan_ways(const struct bench_matrix *m, struct bench_plan *plan, struct bench_case *to, uint32_t lights, fnl_shading shading,
                      fnl_light_lists lists) {
    uint32_t combinations = 1;
    for (uint32_t v = 0; v < m->vary_count; v++) combinations *= m->varied[v].count;
    for (uint32_t i = 0; i < combinations; i++) {
        fnl_frame frame = bench_frame();
        char options[1024];
        bool good = set_fixed(&frame, m->set, shading, lists, to->msaa);
        for (uint32_t v = 0, rest = i; v < m->vary_count && good; v++) {
            const struct bench_vary *vary = &m->varied[v];
            good = set_heeded(&frame, &vary->option, vary->values[rest % vary->count], shading, lists, to->msaa);
            rest /= vary->count;
        }
        if (m->usual_shadows && (lights == 0 || lights > MAPS_LIGHTS)) frame.shadows = FNL_SHADOWS_OFF;
        bench_ways_print(&frame, true, options, sizeof options);
        struct bench_candidate candidate = {shading, lists, options};
        if (!good || !bench_plan_candidate(plan, to, &candidate)) return false;
    }
    return true;
}

/* All but the choosers, which are none of their own, or those that were named. */
static uint32_t values_of(uint32_t count, const uint32_t *named, const char *(*name_of)(int),
                          uint32_t out[BENCH_VALUES_MAX]) {
    if (count) {
        memcpy(out, named, count * sizeof *out);
        return count;
    }
    for (int i = 0; name_of(i) && count < BENCH_VALUES_MAX; i++)
        if (strcmp(name_of(i), "auto") != 0) out[count++] = (uint32_t)i;
    return count;
}

static const char *shading_name(int i) { return fnl_value_name(FNL_ENUM_SHADING, (uint32_t)i); }
static const char *lists_name(int i) { return fnl_value_name(FNL_ENUM_LISTS, (uint32_t)i); }

static bool plan_case(const struct bench_matrix *m, struct bench_plan *plan, const struct bench_case *wanted,
                      uint32_t lights) {
    uint32_t orders[BENCH_VALUES_MAX], lists[BENCH_VALUES_MAX],
        order_count = values_of(m->shading_count, m->shading, shading_name, orders),
        lists_count = values_of(m->lists_count, m->lists, lists_name, lists);
    struct bench_case *to = bench_plan_case(plan, wanted);
    for (uint32_t s = 0; to && s < order_count; s++) {
        fnl_shading shading = (fnl_shading)orders[s];
        bool one = false;
        for (uint32_t l = 0; l < lists_count; l++) {
            fnl_light_lists kind = (fnl_light_lists)lists[l];
            if (!m->shading_count && !m->every_shading &&
                !(fnl_shading_likely(shading, kind, lights, wanted->msaa) & FNL_LIKELY_SHADING))
                continue;
            if (!m->lists_count && !m->every_lists && !lists_likely(m, shading, kind, lights, wanted->msaa)) continue;
            if (!m->lists_count && !lists_matter(shading) && one) continue;
            one = true;
            if (!plan_ways(m, plan, to, lights, shading, kind)) return false;
        }
        if (m->ideal && one && lists_matter(shading) && fnl_shading_supports(shading, FNL_LISTS_FINE, wanted->msaa) &&
            !plan_ways(m, plan, to, lights, shading, FNL_LISTS_FINE))
            return false;
    }
    return to != NULL;
}

bool bench_plan_matrix(const struct bench_matrix *m, const char *const *scenes, const uint32_t *scene_lights,
                       int scene_count, struct bench_plan *plan) {
    plan->likely = !(m->shading_count || m->every_shading) || !(m->lists_count || m->every_lists);
    for (int scene = 0; scene < scene_count; scene++)
        for (uint32_t lights = 0; lights < m->light_count + !m->light_count; lights++)
            for (uint32_t size = 0; size < m->size_count; size++)
                for (uint32_t i = 0; i < m->msaa_count; i++) {
                    struct bench_case wanted = {.scene = scenes[scene],
                                                .camera = m->camera,
                                                .lights = m->light_count ? (int64_t)m->lights[lights] : -1,
                                                .width = m->sizes[size][0],
                                                .height = m->sizes[size][1],
                                                .msaa = m->msaa[i]};
                    if (!plan_case(m, plan, &wanted, bench_scene_lights(wanted.scene, scene_lights[scene], wanted.lights)))
                        return false;
                }
    return true;
}

void bench_plan_free(struct bench_plan *plan) {
    for (uint32_t i = 0; i < plan->case_count; i++) {
        for (uint32_t c = 0; c < plan->cases[i].candidate_count; c++) free(plan->cases[i].candidates[c].options);
        free(plan->cases[i].candidates);
    }
    free(plan->cases);
    json_decref(plan->skipped);
}
