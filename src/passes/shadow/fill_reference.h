/* SPDX-License-Identifier: MIT */
/** What a page of a shadow map must hold, found on the CPU in double precision: rays from the light through its texels, triangle by triangle. */
#ifndef FNL_PASSES_SHADOW_FILL_REFERENCE_H
#define FNL_PASSES_SHADOW_FILL_REFERENCE_H

#include "passes/shadow/fill_shared.h"
#include "tests/render_test.h"

enum { SIDE = 1024, CELLS = SIDE / 128, MOST_PAGES = 160 }; /* of the atlas: texels and cells across */

/* ---- pages, as maps_shared.h defines them ---- */

struct page {
    uint32_t row, face, level, x, y, place_x, place_y; /* place: texels of the atlas */
    bool draw;
};
uint32_t page_side(uint32_t level); /* how many lie across a face */
uint32_t page_size(const struct page *p);
uint32_t page_bit(const struct page *p);

/** Pages in places that no two share. */
struct pages {
    struct page data[MOST_PAGES];
    uint32_t count, cell, used; /* used: small pages in the cell, all of one size */
    uint32_t small;
};
void pages_put(struct pages *pages, struct page page);

/* ---- the scene as the CPU sees it ---- */

struct point {
    double x[3];
};
struct triangle {
    struct point p[3];
    double alpha[3], cutoff; /* cutoff 0: opaque */
    uint32_t item;
};
struct triangles {
    struct triangle *data; /* free() */
    uint32_t count;
};
/** All that cast shadows, in the poses of the device's scene. Frees those before. */
void triangles_gather(struct triangles *out, const struct device_scene *d);

struct face {
    struct point origin, u, v, along;
    bool is_box;
    double size[3], range; /* size: of a box */
};
struct face face_of(const struct gpu_shape *s, uint32_t face);
/** Where a texel of a page, counted with its border, lies on the face: -1 .. 1 across it. */
void texel_on_face(const struct page *p, double x, double y, double out[2]);

struct hit {
    double depth; /* 0: nothing */
    uint32_t item;
    bool is_beyond; /* the light's range */
};
/** What is nearest of the triangles along the ray through a point of the face. */
struct hit hit_nearest(const struct triangles *triangles, const struct face *f, const double at[2]);
/** Those triangles that may show in the page, and how many items they are of. */
struct triangles triangles_of_page(const struct triangles *all, const struct page *p, const struct face *f, uint32_t *out_items);

#endif
