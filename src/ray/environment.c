/* SPDX-License-Identifier: MIT */
#include "ray/environment.h"

static dvec3 rgb_of(const struct panorama *p, uint32_t column, uint32_t row) {
    const float *texel = p->texels + 3 * ((size_t)row * p->width + column);
    return dvec3_make((double)texel[0], (double)texel[1], (double)texel[2]);
}

/* Where a direction is in the picture, in texels from the middle of the first one. */
static void place_of(const struct ray_environment *e, dvec3 d, double *x, double *y) {
    const struct panorama *p = &e->scene->panorama;
    const dvec3 turned = dvec3_normalize(dvec3_make(dvec3_dot(e->axes[0], d), dvec3_dot(e->axes[1], d), dvec3_dot(e->axes[2], d)));
    *x = (atan2(turned.z, turned.x) / (2 * DPI) + 0.5) * p->width - 0.5;
    *y = acos(CLAMP(turned.y, -1.0, 1.0)) / DPI * p->height - 0.5;
}

/* A cell lies between the middles of four texels: column to column + 1, row - 1 to row. The first and last row are half as high. */
struct cell {
    uint32_t columns[2], rows[2];
};

static struct cell cell_at(const struct panorama *p, uint32_t column, uint32_t row) {
    return (struct cell){{column, (column + 1) % p->width}, {row ? row - 1 : 0, MIN(row, p->height - 1)}};
}

static uint32_t cell_column(const struct panorama *p, double x) { return (uint32_t)((int64_t)floor(x) + p->width) % p->width; }
static uint32_t cell_row(const struct panorama *p, double y) { return (uint32_t)CLAMP((int64_t)floor(y) + 1, (int64_t)0, (int64_t)p->height); }

dvec3 ray_environment_from(const struct ray_environment *e, dvec3 d) {
    const struct panorama *p = &e->scene->panorama;
    double x, y;
    place_of(e, d, &x, &y);
    const double fx = x - floor(x), fy = y - floor(y);
    const struct cell cell = cell_at(p, cell_column(p, x), cell_row(p, y));
    dvec3 out = {0, 0, 0};
    for (int k = 0; k < 4; k++)
        out = dvec3_add_scaled(out, rgb_of(p, cell.columns[k % 2], cell.rows[k / 2]), (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy) * e->scale);
    return out;
}

static double mean_of(const struct ray_environment *e) {
    const struct panorama *p = &e->scene->panorama;
    double sum = 0;
    for (uint32_t y = 0; y < p->height; y++) {
        const double share = (cos(DPI * y / p->height) - cos(DPI * (y + 1) / p->height)) / 2 / p->width;
        double row = 0;
        for (uint32_t x = 0; x < p->width; x++) row += dvec3_luminance(rgb_of(p, x, y));
        sum += row * share;
    }
    return sum * e->scale;
}

/* ---- bright parts ---- */

/* The cosine of the angle from above at which a row of cells begins. */
static double row_cosine(const struct panorama *p, uint32_t row) { return cos(DPI * fmin(fmax(row - 0.5, 0), p->height) / p->height); }

/* By how much a cell is brighter than the mean, as luminance of texels. */
static double cell_excess(const struct panorama *p, uint32_t column, uint32_t row, double mean) {
    const struct cell cell = cell_at(p, column, row);
    double sum = 0;
    for (int k = 0; k < 4; k++) sum += dvec3_luminance(rgb_of(p, cell.columns[k % 2], cell.rows[k / 2]));
    return fmax(sum / 4 - mean * 1.001, 0); /* texels that are all the same have a mean that is rounded */
}

static void fill_chances(struct ray_environment *e) {
    const struct panorama *p = &e->scene->panorama;
    const double mean = e->scale > 0 ? e->mean / e->scale : 0;
    double all = 0;
    for (uint32_t y = 0; y <= p->height; y++) {
        float *ends = e->ends + (size_t)y * p->width;
        double row = 0, sum = 0;
        for (uint32_t x = 0; x < p->width; x++) row += cell_excess(p, x, y, mean);
        for (uint32_t x = 0; x < p->width; x++) ends[x] = row > 0 ? (float)((sum += cell_excess(p, x, y, mean)) / row) : 0;
        if (row > 0) ends[p->width - 1] = 1;
        const double angle = row_cosine(p, y) - row_cosine(p, y + 1);
        e->rows[y] = (struct ray_environment_row){all += row * angle, row / (2 * DPI)};
    }
    for (uint32_t y = 0; y <= p->height && all > 0; y++) {
        e->rows[y].end /= all;
        e->rows[y].density *= p->width / all;
    }
}

static size_t rows_size(const struct panorama *p) { return ((size_t)p->height + 1) * sizeof(struct ray_environment_row); }
static size_t ends_size(const struct panorama *p) { return ((size_t)p->height + 1) * p->width * sizeof(float); }

fnl_result ray_environment_create(const fnl_host *host, const struct scene_environment *scene, const struct ray_albedos *albedos, struct ray_environment *out) {
    struct ray_environment *e = out;
    vec3 axes[3];
    *e = (struct ray_environment){.scene = scene, .albedos = albedos, .scale = (double)scene_environment_scale(scene)};
    scene_environment_axes(scene, axes);
    for (int i = 0; i < 3; i++) e->axes[i] = dvec3_from(axes[i]);
    if (!ray_environment_is(e)) return FNL_OK;
    e->mean = mean_of(e);
    e->rows = host_allocate(host, rows_size(&scene->panorama));
    e->ends = host_allocate(host, ends_size(&scene->panorama));
    if (!e->rows || !e->ends) return FNL_ERROR_MEMORY;
    fill_chances(e);
    if (!(e->rows[scene->panorama.height].end > 0)) ray_environment_destroy(host, e);
    return FNL_OK;
}

void ray_environment_destroy(const fnl_host *host, struct ray_environment *e) {
    if (!e->scene) return;
    host_free(host, e->rows, rows_size(&e->scene->panorama));
    host_free(host, e->ends, ends_size(&e->scene->panorama));
    e->rows = NULL;
    e->ends = NULL;
}

double ray_environment_sample(const struct ray_environment *e, const double random[2], dvec3 *direction) {
    const struct panorama *p = &e->scene->panorama;
    uint32_t row = 0, column = 0;
    if (!e->rows) return 0;
    for (uint32_t high = p->height; row < high;) { /* the first whose end is above */
        const uint32_t middle = (row + high) / 2;
        if (e->rows[middle].end > random[0]) high = middle;
        else row = middle + 1;
    }
    const float *ends = e->ends + (size_t)row * p->width;
    for (uint32_t high = p->width - 1; column < high;) {
        const uint32_t middle = (column + high) / 2;
        if ((double)ends[middle] > random[1]) high = middle;
        else column = middle + 1;
    }
    const double row_begin = row ? e->rows[row - 1].end : 0, begin = column ? (double)ends[column - 1] : 0;
    const double chances[2] = {e->rows[row].end - row_begin, (double)ends[column] - begin};
    if (!(chances[0] > 0 && chances[1] > 0)) return 0;
    const double down = clamp01((random[0] - row_begin) / chances[0]), across = clamp01((random[1] - begin) / chances[1]);
    const double above = row_cosine(p, row), y = above + (row_cosine(p, row + 1) - above) * down, sine = sqrt(fmax(1 - y * y, 0));
    const double longitude = ((column + 0.5 + across) / p->width - 0.5) * 2 * DPI;
    *direction = dvec3_combine(e->axes[0], e->axes[1], e->axes[2], dvec3_make(sine * cos(longitude), y, sine * sin(longitude)));
    return e->rows[row].density * chances[1];
}

double ray_environment_density(const struct ray_environment *e, dvec3 direction) {
    const struct panorama *p = &e->scene->panorama;
    double x, y;
    if (!e->rows) return 0;
    place_of(e, direction, &x, &y);
    const uint32_t row = cell_row(p, y), column = cell_column(p, x);
    const float *ends = e->ends + (size_t)row * p->width;
    return e->rows[row].density * ((double)ends[column] - (column ? (double)ends[column - 1] : 0));
}
