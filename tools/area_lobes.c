/* SPDX-License-Identifier: MIT */
/**
 * Fits the table of specular lobes that rectangle lights are integrated with (shaders/lights/area.glsl): linearly transformed cosines after Heitz,
 * Dupuy, Hill and Neubelt 2016, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines", for the lobe of shaders/brdf.glsl.
 *   area_lobes          prints the table, the text of src/render/device/light_lobes.c
 *   area_lobes check    prints by how much integrals over rectangles differ from sums in double precision
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define COUNT_OF(a) (sizeof(a) / sizeof *(a))
enum { ROWS = 16, COLUMNS = 32, VALUES = 6, SIDE = 32, PARAMS = 4 };

typedef struct vec {
    double x, y, z;
} vec;

static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec add(vec a, vec b, double scale) { return (vec){a.x + b.x * scale, a.y + b.y * scale, a.z + b.z * scale}; }
static vec cross(vec a, vec b) { return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static vec unit(vec a) {
    const double scale = 1 / sqrt(dot(a, a));
    return (vec){a.x * scale, a.y * scale, a.z * scale};
}

/* ---- the lobe, times the cosine; the normal is z, the viewer in the plane of x and z ---- */

struct lobe {
    double alpha2, masking;
    vec to_view;
};

static struct lobe lobe_make(double alpha, double cosine) {
    struct lobe b = {alpha * alpha, 0, {sqrt(fmax(1 - cosine * cosine, 0)), 0, cosine}};
    b.masking = PI * (cosine + sqrt(b.alpha2 + (1 - b.alpha2) * cosine * cosine));
    return b;
}

/* `density`: of lobe_sample(). */
static double lobe_at(const struct lobe *b, vec l, double *density, double *m5) {
    const vec h = unit(add(b->to_view, l, 1));
    const double d = b->alpha2 * h.z * h.z + h.x * h.x + h.y * h.y, v_h = dot(b->to_view, h);
    *m5 = pow(1 - v_h, 5);
    *density = 0;
    if (!(h.z > 0 && v_h > 0)) return 0;
    *density = b->alpha2 / (PI * d * d) * h.z / (4 * v_h);
    if (!(l.z > 0)) return 0;
    return b->alpha2 / (d * d * (l.z + sqrt(b->alpha2 + (1 - b->alpha2) * l.z * l.z)) * b->masking) * l.z;
}

static vec lobe_sample(const struct lobe *b, double u, double w) {
    const double tangent2 = b->alpha2 * u / (1 - u), c = 1 / sqrt(1 + tangent2), s = sqrt(tangent2) * c;
    const vec h = {s * cos(2 * PI * w), s * sin(2 * PI * w), c};
    return add((vec){-b->to_view.x, -b->to_view.y, -b->to_view.z}, h, 2 * dot(b->to_view, h));
}

/* ---- the cosine, transformed: stretched, sheared along the axis, and turned in the plane of x and z ---- */

struct transform {
    double along, across, shear, cosine, sine; /* of its turn */
};

static struct transform transform_make(double along, double across, double turn, double shear) {
    const double c = cos(turn) + shear * sin(turn), s = sin(turn) - shear * cos(turn), scale = 1 / sqrt(c * c + s * s);
    return (struct transform){along, across, shear, c * scale, s * scale};
}

static vec transform_back(const struct transform *t, vec p) {
    const double z = p.x * t->sine + p.z * t->cosine;
    return (vec){(p.x * t->cosine - p.z * t->sine - t->shear * z) / t->along, p.y / t->across, z};
}

static vec transform_to(const struct transform *t, vec q) {
    const double x = t->along * q.x + t->shear * q.z;
    return (vec){x * t->cosine + q.z * t->sine, t->across * q.y, q.z * t->cosine - x * t->sine};
}

static double transform_density(const struct transform *t, vec l) {
    const vec q = transform_back(t, l);
    const double length2 = dot(q, q);
    return q.z > 0 ? q.z / (length2 * length2 * PI * t->along * t->across) : 0;
}

static vec transform_sample(const struct transform *t, double u, double w) {
    return unit(transform_to(t, (vec){sqrt(u) * cos(2 * PI * w), sqrt(u) * sin(2 * PI * w), sqrt(1 - u)}));
}

/* The part of the transformed cosine that lies above the surface. */
static double part_above(const struct transform *t) {
    enum { STEPS = 128 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) sum += transform_sample(t, (i / STEPS + 0.5) / STEPS, (i % STEPS + 0.5) / STEPS).z > 0;
    return sum / (STEPS * STEPS);
}

/* ---- fitting ---- */

struct target {
    struct lobe lobe;
    double alpha, angle, sum, value[SIDE * SIDE], density[SIDE * SIDE];
    vec direction[SIDE * SIDE];
};

static void target_make(struct target *t, double alpha, double cosine) {
    enum { STEPS = 512 };
    double density, m5;
    t->lobe = lobe_make(alpha, cosine);
    t->alpha = alpha;
    t->angle = acos(cosine);
    t->sum = 0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        const double value = lobe_at(&t->lobe, lobe_sample(&t->lobe, (i / STEPS + 0.5) / STEPS, (i % STEPS + 0.5) / STEPS), &density, &m5);
        if (density > 0) t->sum += value / density / (STEPS * STEPS);
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        t->direction[i] = lobe_sample(&t->lobe, (i / SIDE + 0.5) / SIDE, (i % SIDE + 0.5) / SIDE);
        t->value[i] = lobe_at(&t->lobe, t->direction[i], &t->density[i], &m5);
    }
}

/* Parameters: stretch along and across, in alphas; how far the axis lies from the mirror direction, in radians; shear. */
static struct transform transform_of(const struct target *t, const double *p) {
    return transform_make(fmax(fabs(p[0]), 1e-3) * t->alpha, fmax(fabs(p[1]), 1e-3) * t->alpha, p[2] - t->angle, p[3]);
}

/* Of cubes, so that peaks count; by samples of both lobes. Shears that change nothing are small ones. */
static double error_of(const struct target *t, const double *p) {
    const struct transform m = transform_of(t, p);
    vec direction[SIDE * SIDE];
    double above = 0, sum = 0, density, m5;
    for (int i = 0; i < SIDE * SIDE; i++) {
        direction[i] = transform_sample(&m, (i / SIDE + 0.5) / SIDE, (i % SIDE + 0.5) / SIDE);
        above += direction[i].z > 0;
    }
    above /= SIDE * SIDE;
    if (above < 0.05) return 1e30;
    for (int i = 0; i < SIDE * SIDE; i++) {
        if (t->direction[i].z > 0 && t->density[i] > 0) {
            const double g = transform_density(&m, t->direction[i]), d = fabs(t->value[i] / t->sum - g / above);
            sum += d * d * d / (t->density[i] + g);
        }
        if (direction[i].z > 0) {
            const double g = transform_density(&m, direction[i]), d = fabs(lobe_at(&t->lobe, direction[i], &density, &m5) / t->sum - g / above);
            sum += d * d * d / (density + g);
        }
    }
    return sum / (SIDE * SIDE) * (1 + 0.02 * p[3] * p[3]);
}

/* Nelder and Mead 1965, "A simplex method for function minimization". */
static void fit(const struct target *t, double *p) {
    double at[PARAMS + 1][PARAMS], error[PARAMS + 1];
    for (int i = 0; i <= PARAMS; i++) {
        memcpy(at[i], p, sizeof at[i]);
        if (i) at[i][i - 1] += i == 3 ? 0.1 * t->alpha : 0.1;
        error[i] = error_of(t, at[i]);
    }
    for (int step = 0; step < 400; step++) {
        int low = 0, high = 0;
        for (int i = 1; i <= PARAMS; i++) {
            if (error[i] < error[low]) low = i;
            if (error[i] > error[high]) high = i;
        }
        double next = 0, middle[PARAMS] = {0}, tried[3][PARAMS], errors[3];
        for (int i = 0; i <= PARAMS; i++) {
            if (i == high) continue;
            next = fmax(next, error[i]);
            for (int k = 0; k < PARAMS; k++) middle[k] += at[i][k] / PARAMS;
        }
        if (error[high] - error[low] < 1e-7 * error[low]) break;
        const double steps[3] = {1, 2, -0.5};
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < PARAMS; k++) tried[j][k] = middle[k] + steps[j] * (middle[k] - at[high][k]);
            errors[j] = error_of(t, tried[j]);
        }
        int best = errors[0] < error[low] && errors[1] < errors[0] ? 1 : errors[0] < next ? 0 : 2;
        if (best < 2 || errors[2] < error[high]) {
            memcpy(at[high], tried[best], sizeof at[high]);
            error[high] = errors[best];
            continue;
        }
        for (int i = 0; i <= PARAMS; i++) {
            for (int k = 0; k < PARAMS; k++) at[i][k] = 0.5 * (at[i][k] + at[low][k]);
            error[i] = error_of(t, at[i]);
        }
    }
    for (int i = 0, low = 0; i <= PARAMS; i++) {
        if (error[i] < error[low]) low = i;
        if (i == PARAMS) memcpy(p, at[low], sizeof at[low]);
    }
    p[0] = fabs(p[0]);
    p[1] = fabs(p[1]);
}

static double alpha_of(int row) { return fmax(pow((double)row / (ROWS - 1), 2), 1e-3); }
static double cosine_of(int column) { return fmax(1 - pow((double)column / (COLUMNS - 1), 2), 1e-3); }

static float table[ROWS][COLUMNS][VALUES];

static void fill(void) {
    static struct target t;
    double first[PARAMS] = {1.1, 1.1, 0, 0};
    for (int row = ROWS - 1; row >= 0; row--) {
        double p[PARAMS];
        memcpy(p, first, sizeof p);
        for (int column = 0; column < COLUMNS; column++) {
            target_make(&t, alpha_of(row), cosine_of(column));
            fit(&t, p);
            fit(&t, p);
            if (column == 0) memcpy(first, p, sizeof p);
            const struct transform m = transform_of(&t, p);
            const double above = part_above(&m);
            const float values[VALUES] = {(float)p[0], (float)p[1], (float)sin(p[2]), (float)p[3], (float)(t.sum / above), (float)above};
            memcpy(table[row][column], values, sizeof values);
        }
    }
}

/* ---- what shaders do with it (shaders/lights/area.glsl), in double precision ---- */

static void look_up(double roughness, double cosine, double out[VALUES]) {
    const double y = fmin(fmax(roughness, sqrt(1e-3)), 1) * (ROWS - 1), x = sqrt(1 - cosine) * (COLUMNS - 1);
    const int row = (int)fmin(y, ROWS - 2), column = (int)fmin(x, COLUMNS - 2);
    const double down = y - row, right = x - column;
    for (int i = 0; i < VALUES; i++)
        out[i] = (1 - down) * ((1 - right) * (double)table[row][column][i] + right * (double)table[row][column + 1][i]) +
                 down * ((1 - right) * (double)table[row + 1][column][i] + right * (double)table[row + 1][column + 1][i]);
}

static int clip(const vec *in, int count, vec *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const vec a = in[i], b = in[(i + 1) % count];
        if (a.z > 0) out[kept++] = a;
        if ((a.z > 0) != (b.z > 0)) {
            out[kept] = add(a, add(b, a, -1), a.z / (a.z - b.z));
            out[kept++].z = 0;
        }
    }
    return kept;
}

/* Lambert's formula, as a vector: along it most light comes. */
static vec polygon_flux(const vec *p, int count) {
    vec sum = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        const vec a = unit(p[i]), b = unit(p[(i + 1) % count]), c = cross(a, b);
        const double sine = sqrt(dot(c, c));
        if (sine > 1e-14) sum = add(sum, c, atan2(sine, dot(a, b)) / sine / (2 * PI));
    }
    return sum.z < 0 ? (vec){-sum.x, -sum.y, -sum.z} : sum;
}

/* Over the rectangle, of the lobe times f0 + (1 - f0) m5. */
static double by_table(double roughness, double cosine, const vec corners[4], double f0) {
    const double alpha = fmax(roughness * roughness, 1e-3);
    const struct lobe b = lobe_make(alpha, cosine);
    double v[VALUES], density, m5;
    vec above[6], turned[6], seen[8];
    look_up(roughness, cosine, v);
    const struct transform m = transform_make(v[0] * alpha, v[1] * alpha, asin(v[2]) - acos(cosine), v[3]);
    int count = clip(corners, 4, above);
    for (int i = 0; i < count; i++) turned[i] = transform_back(&m, above[i]);
    count = clip(turned, count, seen);
    const vec flux = polygon_flux(seen, count);
    if (!(flux.z > 0)) return 0;
    const vec l = unit(transform_to(&m, flux));
    const double value = lobe_at(&b, l, &density, &m5), fitted = v[4] * transform_density(&m, l), rest = 1 - fmin(flux.z / v[5], 1);
    const double ratio = fitted > 0 ? fmin(value / fitted, 4) : 1;
    return v[4] * flux.z * (1 + (ratio - 1) * rest * rest) * (f0 + (1 - f0) * m5);
}

static double by_sum(double roughness, double cosine, const vec corners[4], double f0) {
    const double alpha = fmax(roughness * roughness, 1e-3);
    const struct lobe b = lobe_make(alpha, cosine);
    const vec side = add(corners[1], corners[0], -1), up = add(corners[3], corners[0], -1), normal = cross(side, up);
    double sum = 0, density, m5;
    if (alpha >= 0.1) { /* over the rectangle */
        enum { STEPS = 128 };
        for (int i = 0; i < STEPS * STEPS; i++) {
            const vec p = add(add(corners[0], side, (i / STEPS + 0.5) / STEPS), up, (i % STEPS + 0.5) / STEPS), l = unit(p);
            const double value = lobe_at(&b, l, &density, &m5);
            sum += value * (f0 + (1 - f0) * m5) * fabs(dot(l, normal)) / dot(p, p) / (STEPS * STEPS);
        }
        return sum;
    }
    enum { STEPS = 384 }; /* over the lobe */
    for (int i = 0; i < STEPS * STEPS; i++) {
        const vec l = lobe_sample(&b, (i / STEPS + 0.5) / STEPS, (i % STEPS + 0.5) / STEPS);
        const double high = dot(corners[0], normal) / dot(l, normal);
        if (!(high > 0)) continue;
        const vec on = add((vec){l.x * high, l.y * high, l.z * high}, corners[0], -1);
        const double x = dot(on, side) / dot(side, side), y = dot(on, up) / dot(up, up);
        if (x < 0 || x > 1 || y < 0 || y > 1) continue;
        const double value = lobe_at(&b, l, &density, &m5);
        if (density > 0) sum += value * (f0 + (1 - f0) * m5) / density / (STEPS * STEPS);
    }
    return sum;
}

static double chance(void) { return rand() / (RAND_MAX + 1.0); }

static void place(vec middle, vec normal, double half_width, double half_height, double spin, vec out[4]) {
    const vec a = unit(cross(normal, fabs(normal.z) < 0.7 ? (vec){0, 0, 1} : (vec){1, 0, 0})), b = cross(normal, a);
    const vec side = add((vec){a.x * cos(spin), a.y * cos(spin), a.z * cos(spin)}, b, sin(spin)), up = cross(normal, side);
    for (int i = 0; i < 4; i++) out[i] = add(add(middle, side, i == 0 || i == 3 ? -half_width : half_width), up, i < 2 ? -half_height : half_height);
}

static void check(void) {
    const double roughnesses[] = {0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1}, cosines[] = {0.98, 0.8, 0.6, 0.4, 0.25, 0.1}, sizes[] = {0.05, 0.2, 0.5, 1, 2};
    printf("Errors of integrals over rectangles a metre away, in %% of the most that one of the size gives: mean square root / worst\n%9s %7s", "roughness", "cosine");
    for (size_t s = 0; s < COUNT_OF(sizes); s++) printf("   %4g m wide", 2 * sizes[s]);
    printf("\n");
    for (size_t r = 0; r < COUNT_OF(roughnesses); r++)
        for (size_t c = 0; c < COUNT_OF(cosines); c++) {
            printf("%9g %7g", roughnesses[r], cosines[c]);
            for (size_t s = 0; s < COUNT_OF(sizes); s++) {
                enum { PLACES = 24, PEAKS = 12 };
                const struct lobe b = lobe_make(fmax(pow(roughnesses[r], 2), 1e-3), cosines[c]);
                double peak = 0, worst = 0, squares = 0;
                vec corners[4];
                srand(1);
                for (int i = 0; i < PEAKS; i++) {
                    const double angle = -(acos(cosines[c]) + (PI / 2 - acos(cosines[c])) * (i - 4) / PEAKS);
                    const vec at = {sin(angle), 0, cos(angle)};
                    place(at, (vec){-at.x, -at.y, -at.z}, sizes[s], sizes[s], 0, corners);
                    peak = fmax(peak, by_sum(roughnesses[r], cosines[c], corners, 1));
                }
                for (int i = 0; i < PLACES; i++) {
                    const double z = chance() * 1.2 - 0.2, turn = 2 * PI * chance(), u = chance(), w = chance();
                    const vec any = {sqrt(1 - z * z) * cos(turn), sqrt(1 - z * z) * sin(turn), z};
                    const vec at = i & 1 ? any : lobe_sample(&b, u, w);
                    const vec normal = unit((vec){-at.x + 0.5 * (chance() - 0.5), -at.y + 0.5 * (chance() - 0.5), -at.z + 0.5 * (chance() - 0.5)});
                    place(at, normal, sizes[s], sizes[s] * (0.3 + 0.7 * chance()), 6 * chance(), corners);
                    const double error =
                        fabs(by_table(roughnesses[r], cosines[c], corners, 1) - by_sum(roughnesses[r], cosines[c], corners, 1)) / peak;
                    worst = fmax(worst, error);
                    squares += error * error / PLACES;
                }
                printf("  %4.1f / %4.1f", 100 * sqrt(squares), 100 * worst);
            }
            printf("\n");
            fflush(stdout);
        }
}

int main(int argc, char **argv) {
    fill();
    if (argc > 1 && strcmp(argv[1], "check") == 0) {
        check();
        return 0;
    }
    printf("/* SPDX-License-Identifier: MIT */\n/* Made by tools/area_lobes.c, which says what these are. */\n#include \"render/device/light_lobes.h\"\n\n");
    printf("const float light_lobes[AREA_LOBE_ROWS * AREA_LOBE_COLUMNS * AREA_LOBE_VALUES] = {\n");
    for (int row = 0; row < ROWS; row++)
        for (int column = 0; column < COLUMNS; column++) {
            printf(column % 2 ? " " : "    ");
            for (int i = 0; i < VALUES; i++) {
                char text[32];
                snprintf(text, sizeof text, "%.5g", (double)table[row][column][i]);
                if (!strpbrk(text, ".e")) strcat(text, ".0");
                printf("%sf,%s", text, i + 1 < VALUES ? " " : "");
            }
            if (column % 2) printf("\n");
        }
    printf("};\n");
}
