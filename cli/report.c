/* SPDX-License-Identifier: MIT */
/* The numbers of a run: a table for people, JSON for programs. */
#include "render.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct summary {
    double median, low, p95;
};

static struct summary summarise(const double *times, uint32_t count) {
    struct summary s = {0};
    double *sorted = malloc(count * sizeof *sorted);
    if (!sorted || count == 0) {
        free(sorted);
        return s;
    }
    memcpy(sorted, times, count * sizeof *sorted);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    s.median = count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
    s.low = sorted[0];
    s.p95 = sorted[(uint32_t)(0.95 * (count - 1) + 0.5)];
    free(sorted);
    return s;
}

static struct summary pass_summary(const struct render_report *r, uint32_t pass) {
    return summarise(r->pass_times + (size_t)pass * r->frame_count, r->frame_count);
}

void report_print_picture(const struct render_report *r, double seconds) {
    printf("%ux%u, %s, %s lists, %u lights: the frame took %.2f s on %s, everything %.2f s\n", r->frame.width,
           r->frame.height, fnl_shading_name(r->stats.shading), fnl_light_lists_name(r->stats.lists), r->stats.lights_total,
           r->stats.gpu_milliseconds * 1e-3, r->device.name, seconds);
}

void report_print(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    printf("%s, %s\n", r->device.name, r->device.driver);
    printf("%ux%u, %s, %s lists, MSAA %u: %" PRIu64 " triangles, %" PRIu64 " instances, %u lights\n", r->frame.width,
           r->frame.height, fnl_shading_name(s->shading), fnl_light_lists_name(s->lists), r->frame.msaa,
           r->scene.triangle_count, r->scene.instance_count, s->lights_total);
    if (s->choice[0]) printf("auto: %s\n", s->choice);
    struct summary gpu = summarise(r->gpu_times, r->frame_count), cpu = summarise(r->cpu_times, r->frame_count);
    printf("\n  %-28s %10s %10s %10s\n", "pass, ms", "median", "min", "p95");
    double small = 0;
    uint32_t small_count = 0;
    for (uint32_t i = 0; i < r->pass_count; i++) {
        struct summary p = pass_summary(r, i);
        if (p.median < 0.005 * gpu.median) { /* the table shows what matters; the JSON shows all */
            small += p.median;
            small_count++;
            continue;
        }
        printf("  %-28s %10.3f %10.3f %10.3f\n", r->names[i], p.median, p.low, p.p95);
    }
    char others[32];
    snprintf(others, sizeof others, "%u smaller passes", small_count);
    if (small_count) printf("  %-28s %10.3f\n", others, small);
    printf("  %-28s %10.3f %10.3f %10.3f\n", "all passes", gpu.median, gpu.low, gpu.p95);
    printf("  %-28s %10.3f %10.3f %10.3f\n", "CPU, record and submit", cpu.median, cpu.low, cpu.p95);
    printf("\n  lights in view %u of %u; list entries %" PRIu64 " in %u cells, %.1f KiB; overflow cells %u; dropped %u\n",
           s->lights_in_view, s->lights_total, s->list_entries, s->cells, (double)s->list_bytes / 1024, s->overflow_cells,
           s->lights_dropped);
    if (s->evaluations_counted)
        printf("  light evaluations %" PRIu64 ": %.2f per pixel, at most %u; %.2f times those that reach the surface\n",
               s->evaluations, s->mean_per_pixel, s->max_per_pixel,
               (double)s->evaluations / (double)(s->evaluations_useful ? s->evaluations_useful : 1));
    if (r->frame.culling != FNL_CULLING_INSTANCES && s->triangles_total) {
        double whole = 100 / (double)s->triangles_total;
        printf("  triangles drawn %" PRIu64 " of %" PRIu64
               " (%.1f%%); out of view %.1f%%, facing away %.1f%%, too small %.1f%%; clusters %" PRIu64 " of %" PRIu64
               "; whole items %u; by %s shaders\n",
               s->triangles_drawn, s->triangles_total, (double)s->triangles_drawn * whole,
               (double)s->triangles_outside * whole, (double)s->triangles_back * whole, (double)s->triangles_small * whole,
               s->clusters_drawn, s->clusters_total, s->items_whole, fnl_geometry_name(s->geometry));
    }
    if (r->frame.occlusion)
        printf("  items hidden by others %" PRIu64 "; triangles, by clusters and items: %" PRIu64 "\n", s->items_occluded,
               s->triangles_occluded);
    if (r->frame.class_blocks) {
        printf("  blocks of %u pixels by class:", r->frame.class_blocks);
        for (int i = 0; i < 9; i++) printf(" %u", s->shading_blocks[i]);
        puts(" (the last: nothing to shade)");
    }
    if (s->decals_total)
        printf("  decals %u; boxes in view %u; entries %" PRIu64 "; overflow %u\n", s->decals_total, s->decals_in_view,
               s->decal_entries, s->decal_overflow);
    if (s->msaa_pixels) {
        printf("  edge pixels %u of %u; surfaces %" PRIu64 ", samples %" PRIu64, s->msaa_edge_pixels, s->msaa_pixels,
               s->msaa_surfaces, s->msaa_samples);
        if (s->msaa_shaded) printf("; shaded %" PRIu64, s->msaa_shaded);
        puts("");
    }
    if (s->visibility_fragments) printf("  fragments of ids: %u\n", s->visibility_fragments);
    if (s->visibility_entries)
        printf("  to be shaded: %u, of %u classes\n", s->visibility_entries, s->visibility_classes);
    if (s->blend_fragments)
        printf("  blended fragments %" PRIu64 ", at most %u in a pixel; lists %.1f KiB; drawn as sorted: %u pixels\n",
               s->blend_fragments, s->blend_longest, (double)s->blend_bytes / 1024, s->blend_overflow);
    if (s->light_draws) printf("  light volumes: %u draw calls\n", s->light_draws);
    if (s->light_bytes)
        printf("  light apart from materials: %.1f KiB, %.0f bytes a pixel\n", (double)s->light_bytes / 1024,
               (double)s->light_bytes / ((double)r->frame.width * r->frame.height));
    if (s->gbuffer_bytes) {
        printf("  G-buffer %s: %.1f KiB, %.0f bytes a pixel", fnl_gbuffer_name(r->frame.gbuffer),
               (double)s->gbuffer_bytes / 1024, (double)s->gbuffer_bytes / ((double)r->frame.width * r->frame.height));
        if (s->items_forward) printf("; items lit forward %" PRIu64, s->items_forward);
        putchar('\n');
    }
    if (s->shading == FNL_SHADING_COARSE && s->coarse_blocks)
        printf("  blocks lit once %u of %u (%.1f%%); not for depth %u, normals %u, materials %u; lit %u times for %u pixels\n",
               s->coarse_shared, s->coarse_blocks, 100.0 * s->coarse_shared / s->coarse_blocks, s->coarse_by_depth,
               s->coarse_by_normal, s->coarse_by_material, s->coarse_shaded, s->coarse_pixels);
    if (s->shading == FNL_SHADING_DAIS) {
        printf("  dais %s: %u triangles stored", fnl_dais_mode_name(r->frame.dais.mode), s->dais.triangles);
        if (s->dais.unique) printf(", %u different", s->dais.unique);
        printf("; cache failures %u; overflow %u; %.1f KiB, %.1f bytes a sample", s->dais.cache_failures, s->dais.overflow,
               (double)s->dais.bytes / 1024,
               (double)s->dais.bytes / ((double)r->frame.width * r->frame.height * r->frame.msaa));
        if (r->frame.dais.mode == FNL_DAIS_LIST) printf("; list elements %u", s->dais.list_elements);
        if (r->frame.dais.multirate) printf("; shading samples %u", s->dais.shading_samples);
        if (s->dais.shaded) printf("; shaded %u", s->dais.shaded);
        putchar('\n');
    }
    if (s->atlas_pages)
        printf("  atlas: %u of %u pages there, room for %u, %.1f MiB; wanted %u, filled %u, without room %u, gone %u\n",
               s->atlas_resident, s->atlas_pages, s->atlas_capacity, (double)s->atlas_bytes / (1 << 20), s->atlas_wanted,
               s->atlas_filled, s->atlas_missing, s->atlas_evicted);
    if (s->shading == FNL_SHADING_MOBILE)
        printf("  mobile %s: %s, tone mapping %s\n", fnl_mobile_layout_name(r->frame.mobile.layout),
               s->mobile_merged ? "one scope" : "separate passes",
               s->mobile_tonemapped ? "inside" : "after it, from stored radiance (a fixed --exposure may spare that)");
    printf("  images: %.2f MiB read, %.2f MiB written by passes; %.2f MiB of attachments in tile memory%s\n",
           (double)s->image_bytes_read / (1 << 20), (double)s->image_bytes_written / (1 << 20),
           (double)s->tile_bytes / (1 << 20), s->lazy_bytes ? ", lazily allocated" : "");
    printf("  draws %u; items %" PRIu64 " of %" PRIu64 "; triangles %" PRIu64
           "; EV100 %.2f; device memory %.1f MiB (peak %.1f)\n",
           s->draws, s->items_visible, s->items, s->triangles_visible, (double)s->ev, (double)s->device_bytes / (1 << 20),
           (double)s->device_peak_bytes / (1 << 20));
}

static json_t *integer(uint64_t value) { return json_integer((json_int_t)value); }

static json_t *make_json(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_t *passes = json_array();
    for (uint32_t i = 0; i < r->pass_count; i++) {
        struct summary p = pass_summary(r, i);
        json_array_append_new(passes, json_pack("{s:s,s:f,s:f,s:f}", "name", r->names[i], "gpu_ms_median", p.median,
                                                "gpu_ms_min", p.low, "gpu_ms_p95", p.p95));
    }
    json_t *lights =
        json_pack("{s:o,s:o,s:o,s:o,s:o,s:o}", "total", integer(s->lights_total), "in_view", integer(s->lights_in_view),
                  "list_bytes", integer(s->list_bytes), "list_entries", integer(s->list_entries), "overflow_cells",
                  integer(s->overflow_cells), "dropped", integer(s->lights_dropped));
    json_object_set_new(lights, "list_used_bytes", integer(s->list_used_bytes));
    json_object_set_new(lights, "behind", integer(s->lights_behind));
    json_object_set_new(lights, "evaluations", integer(s->evaluations));
    json_object_set_new(lights, "evaluations_useful", integer(s->evaluations_useful));
    json_object_set_new(lights, "mean_per_pixel", json_real(s->mean_per_pixel));
    json_object_set_new(lights, "max_per_pixel", integer(s->max_per_pixel));
    json_t *choice = s->choice[0] ? json_string(s->choice) : json_null();
    return json_pack("{s:{s:s,s:s,s:s},s:{s:o,s:o,s:o},s:{s:i,s:i,s:s,s:s,s:i,s:o},s:o,s:{s:f,s:f},s:o,s:i,s:{s:o,s:o,s:o},"
                     "s:f,s:{s:o,s:o}}",
                     "device", "name", r->device.name, "driver", r->device.driver, "type",
                     fnl_device_type_name(r->device.type), "scene", "triangles", integer(r->scene.triangle_count),
                     "instances", integer(r->scene.instance_count), "lights", integer(s->lights_total), "view", "width",
                     (int)r->frame.width, "height", (int)r->frame.height, "shading", fnl_shading_name(s->shading), "lists",
                     fnl_light_lists_name(s->lists), "msaa", (int)r->frame.msaa, "choice", choice, "passes", passes, "frame",
                     "gpu_ms_median", summarise(r->gpu_times, r->frame_count).median, "cpu_ms_median",
                     summarise(r->cpu_times, r->frame_count).median, "lights", lights, "draws", (int)s->draws, "culling",
                     "items", integer(s->items), "items_visible", integer(s->items_visible), "triangles_visible",
                     integer(s->triangles_visible), "ev", (double)s->ev, "memory", "device_bytes", integer(s->device_bytes),
                     "peak_bytes", integer(s->device_peak_bytes));
}

static void add_decals(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_object_set_new(json, "decals",
                        json_pack("{s:s,s:o,s:o,s:o,s:o}", "way", fnl_decals_name(r->frame.decals), "total",
                                  integer(s->decals_total), "in_view", integer(s->decals_in_view), "entries",
                                  integer(s->decal_entries), "overflow", integer(s->decal_overflow)));
}

static void add_culling(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_t *culling = json_object_get(json, "culling");
    json_object_set_new(culling, "kind", json_string(fnl_culling_name(r->frame.culling)));
    json_object_set_new(culling, "geometry", json_string(fnl_geometry_name(s->geometry)));
    json_object_set_new(culling, "triangles_total", integer(s->triangles_total));
    json_object_set_new(culling, "triangles_drawn", integer(s->triangles_drawn));
    json_object_set_new(culling, "triangles_outside", integer(s->triangles_outside));
    json_object_set_new(culling, "triangles_back", integer(s->triangles_back));
    json_object_set_new(culling, "items_occluded", integer(s->items_occluded));
    json_object_set_new(culling, "triangles_occluded", integer(s->triangles_occluded));
    json_object_set_new(culling, "triangles_small", integer(s->triangles_small));
    json_object_set_new(culling, "clusters_total", integer(s->clusters_total));
    json_object_set_new(culling, "clusters_drawn", integer(s->clusters_drawn));
    json_object_set_new(culling, "items_whole", integer(s->items_whole));
}

static void add_msaa(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    if (s->msaa_pixels == 0) return;
    json_object_set_new(json, "msaa",
                        json_pack("{s:s,s:o,s:o,s:o,s:o,s:o}", "method", fnl_msaa_method_name(r->frame.msaa_method),
                                  "pixels", integer(s->msaa_pixels), "edge_pixels", integer(s->msaa_edge_pixels), "surfaces",
                                  integer(s->msaa_surfaces), "samples", integer(s->msaa_samples), "shaded",
                                  integer(s->msaa_shaded)));
}

static void add_dais(json_t *json, const struct render_report *r) {
    const struct fnl_dais_stats *d = &r->stats.dais;
    if (r->stats.shading != FNL_SHADING_DAIS) return;
    json_object_set_new(
        json, "dais",
        json_pack("{s:s,s:b,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "mode", fnl_dais_mode_name(r->frame.dais.mode), "multirate",
                  r->frame.dais.multirate, "bytes", integer(d->bytes), "triangles", integer(d->triangles), "unique",
                  integer(d->unique), "cache_failures", integer(d->cache_failures), "overflow", integer(d->overflow),
                  "list_elements", integer(d->list_elements), "shading_samples", integer(d->shading_samples), "shaded",
                  integer(d->shaded)));
}

static void add_transparency(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_object_set_new(json, "transparency",
                        json_pack("{s:s,s:o,s:o,s:o,s:o}", "kind", fnl_transparency_name(r->frame.transparency), "fragments",
                                  integer(s->blend_fragments), "longest", integer(s->blend_longest), "bytes",
                                  integer(s->blend_bytes), "overflow_pixels", integer(s->blend_overflow)));
}

static void add_gbuffer(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_object_set_new(json, "gbuffer",
                        json_pack("{s:s,s:s,s:b,s:o,s:o}", "layout", fnl_gbuffer_name(r->frame.gbuffer), "normals",
                                  fnl_normal_encoding_name(r->frame.normals), "chroma", r->frame.chroma, "bytes",
                                  integer(s->gbuffer_bytes), "items_forward", integer(s->items_forward)));
}

static void add_traffic(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    json_object_set_new(json, "images",
                        json_pack("{s:o,s:o,s:o,s:o,s:o}", "bytes_read", integer(s->image_bytes_read), "bytes_written",
                                  integer(s->image_bytes_written), "tile_bytes", integer(s->tile_bytes), "lazy_bytes",
                                  integer(s->lazy_bytes), "lazy_committed_bytes", integer(s->lazy_committed_bytes)));
    json_object_set_new(json, "light_bytes", integer(s->light_bytes));
    if (s->shading == FNL_SHADING_VISIBILITY)
        json_object_set_new(json, "visibility",
                            json_pack("{s:s,s:b,s:b,s:o,s:o,s:o}", "sort", fnl_visibility_sort_name(r->frame.visibility.sort),
                                      "barycentrics", r->frame.visibility.barycentrics, "grid", r->frame.visibility.grid,
                                      "fragments", integer(s->visibility_fragments), "entries",
                                      integer(s->visibility_entries), "classes", integer(s->visibility_classes)));
    json_object_set_new(json, "light_draws", integer(s->light_draws));
    if (s->atlas_pages)
        json_object_set_new(json, "atlas",
                            json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "pages", integer(s->atlas_pages), "capacity",
                                      integer(s->atlas_capacity), "wanted", integer(s->atlas_wanted), "resident",
                                      integer(s->atlas_resident), "filled", integer(s->atlas_filled), "missing",
                                      integer(s->atlas_missing), "evicted", integer(s->atlas_evicted), "bytes", integer(s->atlas_bytes)));
    if (s->shading != FNL_SHADING_MOBILE) return;
    json_object_set_new(json, "mobile",
                        json_pack("{s:s,s:b,s:b}", "layout", fnl_mobile_layout_name(r->frame.mobile.layout), "merged",
                                  s->mobile_merged, "tonemapped_inside", s->mobile_tonemapped));
}

static void add_coarse(json_t *json, const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    if (s->shading != FNL_SHADING_COARSE) return;
    const fnl_coarse_options *o = &r->frame.coarse;
    json_object_set_new(
        json, "coarse",
        json_pack("{s:i,s:s,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "size", (int)o->size, "criterion",
                  fnl_coarse_criterion_name(o->criterion), "split", fnl_coarse_split_name(o->split), "blocks",
                  integer(s->coarse_blocks), "shared", integer(s->coarse_shared), "by_depth", integer(s->coarse_by_depth),
                  "by_normal", integer(s->coarse_by_normal), "by_material", integer(s->coarse_by_material), "pixels",
                  integer(s->coarse_pixels), "shaded", integer(s->coarse_shaded), "ao_shaded",
                  integer(s->coarse_ao_shaded)));
}

bool report_save(const struct render_report *r, const char *path) {
    json_t *json = make_json(r);
    add_gbuffer(json, r);
    add_decals(json, r);
    add_culling(json, r);
    add_transparency(json, r);
    add_msaa(json, r);
    add_coarse(json, r);
    add_dais(json, r);
    add_traffic(json, r);
    char temporary[4096] = "";
    struct stat status;
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) { /* a device or a pipe, which no file may take the place of */
        bool written = json && json_dump_file(json, path, JSON_INDENT(2)) == 0;
        json_decref(json);
        if (!written) fprintf(stderr, "fanal: error: %s: cannot be written\n", path);
        return written;
    }
    bool good = json && snprintf(temporary, sizeof temporary, "%s.part", path) < (int)sizeof temporary &&
                json_dump_file(json, temporary, JSON_INDENT(2)) == 0 && rename(temporary, path) == 0;
    json_decref(json);
    if (!good) {
        fprintf(stderr, "fanal: error: %s: cannot be written\n", path);
        unlink(temporary);
    }
    return good;
}
