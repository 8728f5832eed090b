/* SPDX-License-Identifier: MIT */
/* The numbers of a run as a table for people; report_json.c has them for programs. */
#include "render.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct report_summary report_summarise(const double *times, uint32_t count) {
    struct report_summary s = {0};
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

static struct report_summary pass_summary(const struct render_report *r, uint32_t pass) {
    return report_summarise(r->pass_times + (size_t)pass * r->frame_count, r->frame_count);
}

void report_print_picture(const struct render_report *r, double seconds) {
    printf("%ux%u, %s, %s lists, %u lights: the frame took %.2f s on %s, everything %.2f s\n", r->frame.width,
           r->frame.height, fnl_value_name(FNL_ENUM_SHADING, r->stats.shading), fnl_value_name(FNL_ENUM_LISTS, r->stats.lists), r->stats.lights_total,
           r->stats.gpu_milliseconds * 1e-3, r->device.name, seconds);
}

void report_print(const struct render_report *r) {
    const fnl_frame_stats *s = &r->stats;
    printf("%s, %s\n", r->device.name, r->device.driver);
    printf("%ux%u, %s, %s lists, MSAA %u: %" PRIu64 " triangles, %" PRIu64 " instances, %u lights\n", r->frame.width,
           r->frame.height, fnl_value_name(FNL_ENUM_SHADING, s->shading), fnl_value_name(FNL_ENUM_LISTS, s->lists), r->frame.msaa,
           r->scene.triangle_count, r->scene.instance_count, s->lights_total);
    if (s->view_count) printf("%u views; the numbers of lights and triangles below are those of the first, --stats has all\n", s->view_count);
    if (s->choice[0]) printf("auto: %s\n", s->choice);
    struct report_summary gpu = report_summarise(r->gpu_times, r->frame_count), cpu = report_summarise(r->cpu_times, r->frame_count);
    printf("\n  %-28s %10s %10s %10s\n", "pass, ms", "median", "min", "p95");
    double small = 0;
    uint32_t small_count = 0;
    for (uint32_t i = 0; i < r->pass_count; i++) {
        struct report_summary p = pass_summary(r, i);
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
               s->clusters_drawn, s->clusters_total, s->items_whole, fnl_value_name(FNL_ENUM_GEOMETRY, s->geometry));
    }
    if (r->frame.occlusion)
        printf("  items hidden by others %" PRIu64 "; triangles, by clusters and items: %" PRIu64 "\n", s->items_occluded,
               s->triangles_occluded);
    if (r->frame.deferred.class_blocks) {
        printf("  blocks of %u pixels by class:", r->frame.deferred.class_blocks);
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
        printf("  G-buffer %s: %.1f KiB, %.0f bytes a pixel", fnl_value_name(FNL_ENUM_GBUFFER, r->frame.gbuffer.layout),
               (double)s->gbuffer_bytes / 1024, (double)s->gbuffer_bytes / ((double)r->frame.width * r->frame.height));
        if (s->items_forward) printf("; items lit forward %" PRIu64, s->items_forward);
        putchar('\n');
    }
    if (s->shading == FNL_SHADING_COARSE && s->coarse_blocks)
        printf("  blocks lit once %u of %u (%.1f%%); not for depth %u, normals %u, materials %u; lit %u times for %u pixels\n",
               s->coarse_shared, s->coarse_blocks, 100.0 * s->coarse_shared / s->coarse_blocks, s->coarse_by_depth,
               s->coarse_by_normal, s->coarse_by_material, s->coarse_shaded, s->coarse_pixels);
    if (s->shading == FNL_SHADING_DAIS) {
        printf("  dais %s: %u triangles stored", fnl_value_name(FNL_ENUM_DAIS_MODE, r->frame.dais.mode), s->dais.triangles);
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
        printf("  mobile %s: %s, tone mapping %s\n", fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, r->frame.mobile.layout),
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
