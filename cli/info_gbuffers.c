/* SPDX-License-Identifier: MIT */
/* fanal info --gbuffers: the layouts of the G-buffer, and what they cost. */
#include "info.h"
#include "print.h"

#include "fanal/renderer.h"

#include <inttypes.h>
#include <stdio.h>

/* One layout in so many bytes a pixel: all samples of all pixels, and what reading and writing them once a frame takes. */
static void print_cost(const char *what, uint32_t bits, const struct gbuffer_question *q) {
    uint64_t bytes = (uint64_t)q->width * q->height * q->samples * bits / 8;
    printf("  %-10s %4u bits %3u bytes a pixel   %13" PRIu64 " bytes   %6.2f GB/s\n", what, bits, bits / 8, bytes,
           (double)bytes * 2 * q->frames_per_second / 1e9);
}

static void print_layout(fnl_gbuffer layout, const struct gbuffer_question *q) {
    fnl_gbuffer_info info;
    if (fnl_gbuffer_query_info(layout, &info) != FNL_OK) return;
    printf("\n%s\n", fnl_value_name(FNL_ENUM_GBUFFER, layout));
    for (uint32_t t = 0; t < info.target_count; t++) {
        printf("  target %u, %u bits:", t, info.target_bits[t]);
        const char *separator = " ";
        for (uint32_t i = 0; i < info.field_count; i++) {
            if (info.fields[i].target != t) continue;
            printf("%s%s %u", separator, info.fields[i].name, info.fields[i].bits);
            separator = ", ";
        }
        putchar('\n');
    }
    printf("  normals: %s; can be", fnl_value_name(FNL_ENUM_NORMALS, info.normals));
    for (int e = FNL_NORMALS_OCTAHEDRAL; e < FNL_NORMALS_COUNT; e++)
        if (info.encodings >> e & 1) printf(" %s", fnl_value_name(FNL_ENUM_NORMALS, (fnl_normal_encoding)e));
    putchar('\n');
    if (info.material_count) printf("  material IDs: %u\n", info.material_count);
    print_cost("here", info.bits, q);
    print_cost("published", info.published_bits, q);
}

/* Of the order mobile, which keeps it in tile memory: merged, only the picture moves. */
static void print_mobile(fnl_mobile_layout layout, const struct gbuffer_question *q) {
    fnl_mobile_target targets[8];
    uint32_t count = fnl_mobile_layout_targets(layout, targets, 8), bits = 0, used = 0;
    printf("\nmobile %s\n", fnl_value_name(FNL_ENUM_MOBILE_LAYOUT, layout));
    for (uint32_t i = 0; i < count; i++) {
        printf("  target %u, %u bits: %s %u\n", i, targets[i].bits, targets[i].name, targets[i].used_bits);
        bits += targets[i].bits;
        used += targets[i].used_bits;
    }
    printf("  used: %u bits; light included\n", used);
    print_cost("separate", bits, q);
    print_cost("merged", 0, q);
}

void info_print_gbuffers(const struct gbuffer_question *q) {
    printf("G-buffers at %ux%u, %u sample%s a pixel, read and written once a frame at %g frames a second. Here: the targets "
           "alone;\n"
           "published: with depth, stencil and the target in which light is summed up.\n",
           q->width, q->height, q->samples, q->samples == 1 ? "" : "s", q->frames_per_second);
    for (int i = 0; i < FNL_GBUFFER_COUNT; i++) print_layout((fnl_gbuffer)i, q);
    for (int i = 0; i < FNL_MOBILE_LAYOUT_COUNT; i++) print_mobile((fnl_mobile_layout)i, q);
}
