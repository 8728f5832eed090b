/* SPDX-License-Identifier: MIT */
/* Hidden areas of round fields of view. */
#include "base/check.h"
#include "base/maths.h"
#include "fanal/stereo.h"

struct builder {
    fnl_vec2 *corners;
    uint32_t count;
};

static void add_triangle(struct builder *b, vec2 p, vec2 q, vec2 r) {
    b->corners[b->count++] = p;
    b->corners[b->count++] = q;
    b->corners[b->count++] = r;
}

static void add_quad(struct builder *b, vec2 p, vec2 q, vec2 r, vec2 s) {
    add_triangle(b, p, q, r);
    add_triangle(b, p, r, s);
}

/*
 * Each side of the polygon and the same side of one so large that all of the eye lies inside of it bound a quad; together they are a ring. It reaches beyond
 * the edges of the eye, where nothing is drawn.
 */
fnl_result fnl_hidden_area_round(const fnl_host *host, const fnl_eye *eye, fnl_vec2 center, float radius, uint32_t segments, fnl_vec2 *corners,
                                 fnl_hidden_area *out) {
    const fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "eye", eye));
    TRY(check_pointer(call, "corners", corners));
    TRY(check_pointer(call, "out", out));
    TRY(check_above(call, "radius", (double)radius, 0, 1e4, ""));
    TRY(check_count(call, "segments", segments, 3, 1024));
    TRY(check_range(call, "center.x", (double)center.x, -1e4, 1e4, ""));
    TRY(check_range(call, "center.y", (double)center.y, -1e4, 1e4, ""));
    TRY(check_range(call, "eye->left", (double)eye->left, -1e4, (double)eye->right, " (right)"));
    TRY(check_range(call, "eye->down", (double)eye->down, -1e4, (double)eye->up, " (up)"));
    TRY(check_range(call, "eye->right", (double)eye->right, -1e4, 1e4, ""));
    TRY(check_range(call, "eye->up", (double)eye->up, -1e4, 1e4, ""));
    struct builder b = {corners, 0};
    const float half = PI / (float)segments, around = radius / cosf(half); /* of the corners: the sides touch the circle */
    const float farthest = fmaxf(fmaxf(fabsf(eye->left - center.x), fabsf(eye->right - center.x)) + fmaxf(fabsf(eye->down - center.y), fabsf(eye->up - center.y)), radius);
    const float outer = 2 * farthest / cosf(half);
    for (uint32_t i = 0; i < segments; i++) {
        vec2 at[2], far[2];
        for (uint32_t k = 0; k < 2; k++) {
            const float angle = (float)(i + k == segments ? 0 : i + k) * 2 * half, x = cosf(angle), y = sinf(angle);
            at[k] = (vec2){center.x + around * x, center.y + around * y};
            far[k] = (vec2){center.x + outer * x, center.y + outer * y};
        }
        add_quad(&b, at[0], far[0], far[1], at[1]);
    }
    *out = (fnl_hidden_area){corners, b.count};
    return FNL_OK;
}
