/* SPDX-License-Identifier: MIT */
/* Panoramas that are made by code: a studio in relative values, skies in cd/m^2. They know their bright sources and list them apart. */
#include "scene/query.h"
#include "scene/scene_environment.h"

#define DEGREES (PI / 180)

static float smooth(float x) {
    const float t = CLAMP(x, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/* ---- the studio ---- */

/* A rectangle on the sphere with soft edges, and its light. */
struct soft_box {
    vec3 out, side, up, color;
    float strength, half_width, half_height, edge; /* the last three: tangents */
};

/* Angles in degrees, `azimuth` anticlockwise from +X to -Z. */
static struct soft_box soft_box(vec3 color, float strength, float azimuth, float elevation, float half_width, float half_height, float edge) {
    const float a = azimuth * DEGREES, e = elevation * DEGREES;
    const vec3 out = vec3_make(cosf(e) * cosf(a), sinf(e), -cosf(e) * sinf(a)), side = vec3_make(sinf(a), 0, cosf(a));
    return (struct soft_box){out, side, vec3_cross(side, out), color, strength, tanf(half_width * DEGREES), tanf(half_height * DEGREES), edge};
}

/* 1 inside. */
static float soft_box_part(const struct soft_box *box, vec3 d) {
    const float along = vec3_dot(d, box->out);
    if (along <= 0) return 0;
    const float x = fabsf(vec3_dot(d, box->side)) / along, y = fabsf(vec3_dot(d, box->up)) / along;
    return smooth((box->half_width - x) / box->edge) * smooth((box->half_height - y) / box->edge);
}

enum { SKY_ROWS = 48, SKY_COLUMNS = 32 };

/* What an environment is made of: the same for all directions. `source`: what is listed apart, where its illuminance is above 0. */
struct made {
    struct panorama_source source;
    struct soft_box boxes[6];
    uint32_t box_count;
    vec3 sun, ground;   /* the direction to it; cd/m^2 */
    vec3 scale, around; /* of what the table holds: sunlight in lux, light from all around in cd/m^2 */
    vec3 table[SKY_ROWS][SKY_COLUMNS][3];
};

/*
 * A gray room. The key light stands to the left of a viewer at +Z, with a soft box round it; a fainter box to the right fills. Two tall strips behind
 * give edges, and light what a viewer behind sees; one box hangs overhead.
 */
static void studio_begin(const double *values, struct made *out) {
    UNUSED(values);
    const vec3 warm = {1, 0.96f, 0.9f}, cool = {0.9f, 0.96f, 1}, white = {1, 1, 1};
    *out = (struct made){.boxes = {soft_box(warm, 5, 222, 38, 24, 20, 0.16f), soft_box(cool, 2.2f, -28, 18, 20, 30, 0.2f),
                                   soft_box(white, 3, 90, 88, 34, 34, 0.25f), soft_box(cool, 6, 142, 22, 12, 36, 0.12f),
                                   soft_box(warm, 5, 38, 22, 12, 36, 0.12f)},
                         .box_count = 5,
                         .source = {vec3_scale(warm, 5), soft_box(warm, 1, 222, 38, 1, 1, 1).out, 4 * DEGREES}};
}

static vec3 studio(const struct made *made, vec3 d) {
    const float wall = d.y > 0 ? 0.42f + 0.2f * d.y : 0.42f - 0.16f * smooth(-2 * d.y);
    vec3 light = vec3_scale(vec3_make(0.99f, 1, 1.03f), wall);
    for (uint32_t i = 0; i < made->box_count; i++) {
        const struct soft_box *box = &made->boxes[i];
        light = vec3_add(light, vec3_scale(box->color, box->strength * soft_box_part(box, d)));
    }
    return light;
}

/* ---- skies ---- */

/* The standard overcast sky of the CIE (S 011): 4000 cd/m^2 in the zenith, 9800 lux, above a ground that reflects a fifth. */
static void overcast_begin(const double *values, struct made *out) {
    UNUSED(values);
    *out = (struct made){0};
}

static vec3 overcast(const struct made *made, vec3 d) {
    UNUSED(made);
    const float zenith = 4000, sky = zenith * (1 + 2 * fmaxf(d.y, 0)) / 3;
    const float ground = 0.2f * zenith * 7 / 9, part = d.y < 0 ? expf(d.y * 20) : 1;
    return vec3_scale(vec3_make(0.96f, 1, 1.05f), ground + (sky - ground) * part);
}

enum { SKY_ELEVATION, SKY_AZIMUTH, SKY_TURBIDITY, SKY_SUN, SKY_KEYS };
static const struct query_key sky_keys[SKY_KEYS] = {{"elevation", -6, 90, true}, {"azimuth", -360, 360, true}, {"turbidity", 2, 10, true}, {"sun", 0, 1, false}};
static const double sky_usual[SKY_KEYS] = {40, 60, 2.5, 1};

static float luminance_of(vec3 color) { return 0.2126f * color.x + 0.7152f * color.y + 0.0722f * color.z; }

/*
 * Air, aerosols and ozone over a round earth. Kilometers; amounts are parts of the whole column above the sea, whose optical depths are per channel:
 * each channel is a wavelength (0.63, 0.545, 0.45 micrometers). Rayleigh's and Angstrom's dependence on it: Preetham 1999, appendix. The turbidity is
 * the depth of air and aerosols over that of air, at 0.55 micrometers.
 */
#define EARTH 6360.0
#define AIR 100.0
#define AIR_SCALE 8.0
#define AEROSOL_SCALE 1.2
struct air {
    double clean[3], aerosol[3], ozone[3];
};
struct amounts {
    double clean, aerosol, ozone;
};

static struct air air_of(double turbidity) {
    static const double wavelengths[3] = {0.63, 0.545, 0.45}, ozone[3] = {0.034, 0.030, 0.003};
    struct air out;
    for (int c = 0; c < 3; c++) {
        out.clean[c] = 0.008735 * pow(wavelengths[c], -4.08);
        out.aerosol[c] = (turbidity - 1) * 0.1 * pow(wavelengths[c] / 0.55, -1.3);
        out.ozone[c] = ozone[c];
    }
    return out;
}

/* Per kilometer. */
static struct amounts density_at(double radius) {
    const double height = fmax(radius - EARTH, 0);
    return (struct amounts){exp(-height / AIR_SCALE) / AIR_SCALE, exp(-height / AEROSOL_SCALE) / AEROSOL_SCALE, fmax(1 - fabs(height - 25) / 15, 0) / 15};
}

/* How far it is to the top from `radius`, in a direction with this cosine to the vertical, and how far from the center something is on the way. */
static double way_up(double radius, double cosine) {
    return -radius * cosine + sqrt(fmax(radius * radius * (cosine * cosine - 1) + (EARTH + AIR) * (EARTH + AIR), 0));
}
static double radius_along(double radius, double cosine, double way) { return sqrt(radius * radius + way * way + 2 * radius * cosine * way); }

/* What light crosses from outside; false where the earth is in the way. */
static bool cross_air(double radius, double cosine, struct amounts *out) {
    enum { STEPS = 16 };
    const double length = way_up(radius, cosine);
    *out = (struct amounts){0};
    if (cosine < 0 && radius * sqrt(1 - cosine * cosine) < EARTH) return false;
    for (int i = 0; i < STEPS; i++) { /* steps grow with the distance */
        const double low = length * i * i / (STEPS * STEPS), high = length * (i + 1) * (i + 1) / (STEPS * STEPS);
        const struct amounts d = density_at(radius_along(radius, cosine, 0.5 * (low + high)));
        out->clean += d.clean * (high - low);
        out->aerosol += d.aerosol * (high - low);
        out->ozone += d.ozone * (high - low);
    }
    return true;
}

static double depth_of(const struct air *air, const struct amounts *a, int channel) {
    return a->clean * air->clean[channel] + a->aerosol * air->aerosol[channel] + a->ozone * air->ozone[channel];
}

/*
 * Light that the air scatters to the eye, without the phases: sunlight of 1, by air and by aerosols (nine tenths of what they take), as Nishita 1993 and
 * Bruneton 2008 have it; and light of 1 from all around, which stands for what is scattered more often.
 */
static void scatter(const struct air *air, const struct made *s, double up, double to_sun, vec3 out[3]) {
    enum { STEPS = 32 };
    const double eye = EARTH + 0.05, length = way_up(eye, up), sun_up = (double)s->sun.y;
    struct amounts before = {0};
    double sums[3][3] = {{0}};
    for (int i = 0; i < STEPS; i++) {
        const double low = length * i * i / (STEPS * STEPS), high = length * (i + 1) * (i + 1) / (STEPS * STEPS), way = 0.5 * (low + high);
        const double radius = radius_along(eye, up, way), cosine = (eye * sun_up + way * to_sun) / radius;
        const struct amounts here = density_at(radius);
        struct amounts all;
        const bool lit = cross_air(radius, CLAMP(cosine, -1.0, 1.0), &all);
        all.clean += before.clean + here.clean * (way - low);
        all.aerosol += before.aerosol + here.aerosol * (way - low);
        all.ozone += before.ozone + here.ozone * (way - low);
        for (int c = 0; c < 3; c++) {
            const double clean = here.clean * air->clean[c] * (high - low), aerosol = 0.9 * here.aerosol * air->aerosol[c] * (high - low);
            const double through = lit ? exp(-depth_of(air, &all, c)) : 0;
            sums[0][c] += clean * through;
            sums[1][c] += aerosol * through;
            sums[2][c] += (clean + aerosol) * exp(-depth_of(air, &before, c));
        }
        before.clean += here.clean * (high - low);
        before.aerosol += here.aerosol * (high - low);
        before.ozone += here.ozone * (high - low);
    }
    for (int k = 0; k < 3; k++) out[k] = vec3_make((float)sums[k][0], (float)sums[k][1], (float)sums[k][2]);
}

/* The sums by the squared height of a direction and its turn from the sun. */
static void make_table(struct made *s, const struct air *air) {
    for (uint32_t r = 0; r < SKY_ROWS; r++)
        for (uint32_t c = 0; c < SKY_COLUMNS; c++) {
            const double part = (double)r / (SKY_ROWS - 1), height = 0.5 * (double)PI * part * part, turn = (double)PI * c / (SKY_COLUMNS - 1);
            const double sun_across = sqrt(fmax(1 - (double)s->sun.y * (double)s->sun.y, 0));
            scatter(air, s, sin(height), sin(height) * (double)s->sun.y + cos(height) * sun_across * cos(turn), s->table[r][c]);
        }
}

static vec3 sky_dome(const struct made *s, vec3 d) {
    const float row = sqrtf(asinf(CLAMP(d.y, 0.0f, 1.0f)) / (PI / 2)) * (SKY_ROWS - 1), cosine = vec3_dot(d, s->sun);
    const float across = sqrtf((d.x * d.x + d.z * d.z) * (s->sun.x * s->sun.x + s->sun.z * s->sun.z));
    const float turn = across > 0 ? acosf(CLAMP((d.x * s->sun.x + d.z * s->sun.z) / across, -1.0f, 1.0f)) : 0, column = turn / PI * (SKY_COLUMNS - 1);
    const uint32_t r = MIN((uint32_t)row, SKY_ROWS - 2u), c = MIN((uint32_t)column, SKY_COLUMNS - 2u);
    const float g = 0.8f, phase = 3 / (16 * PI) * (1 + cosine * cosine), aerosol_phase = (1 - g * g) / (4 * PI * powf(1 + g * g - 2 * g * cosine, 1.5f));
    const vec3 light[3] = {vec3_scale(s->scale, phase), vec3_scale(s->scale, aerosol_phase), s->around};
    vec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const vec3 low = vec3_lerp(s->table[r][c][k], s->table[r][c + 1][k], column - (float)c);
        const vec3 high = vec3_lerp(s->table[r + 1][c][k], s->table[r + 1][c + 1][k], column - (float)c);
        sum = vec3_add(sum, vec3_mul(light[k], vec3_lerp(low, high, row - (float)r)));
    }
    return sum;
}

/* What the dome above gives to the ground, lux by channel. */
static vec3 illuminance_of(const struct made *s) {
    enum { ROWS = 32, COLUMNS = 64 };
    vec3 sum = {0, 0, 0};
    for (uint32_t r = 0; r < ROWS; r++) /* of equal illuminance: even steps of the squared sine */
        for (uint32_t c = 0; c < COLUMNS; c++) {
            const float sine2 = ((float)r + 0.5f) / ROWS, across = sqrtf(1 - sine2), turn = 2 * PI * ((float)c + 0.5f) / COLUMNS;
            sum = vec3_add(sum, sky_dome(s, vec3_make(across * cosf(turn), sqrtf(sine2), across * sinf(turn))));
        }
    return vec3_scale(sum, PI / (ROWS * COLUMNS));
}

/*
 * A clear sky, the sun of 128 000 lux above the air. Its illuminance is half of what the air takes from the sun's, and 800 lux more, as tables of
 * daylight and twilight have it; from sunset on it falls by a factor of 2.5 for each degree.
 */
static void sky_begin(const double *values, struct made *s) {
    const float elevation = (float)values[SKY_ELEVATION], height = elevation * DEGREES, azimuth = (float)values[SKY_AZIMUTH] * DEGREES;
    const float above = sinf(fmaxf(height, 0)), radius = 0.2665f, shown = smooth(0.5f + elevation / (2 * radius)); /* of its disk above the horizon */
    const vec3 white = vec3_scale(vec3_make(1.05f, 0.99f, 0.95f), 128000), albedo = {0.22f, 0.2f, 0.17f};
    const struct air air = air_of(values[SKY_TURBIDITY]);
    *s = (struct made){.sun = {cosf(height) * cosf(azimuth), sinf(height), cosf(height) * sinf(azimuth)}, .scale = white};
    make_table(s, &air);
    struct amounts crossed;
    (void)cross_air(EARTH + 0.05, (double)above, &crossed);
    const vec3 sun = vec3_make(white.x * (float)exp(-depth_of(&air, &crossed, 0)), white.y * (float)exp(-depth_of(&air, &crossed, 1)),
                               white.z * (float)exp(-depth_of(&air, &crossed, 2)));
    const vec3 beam = vec3_scale(sun, shown * above);
    for (int i = 0; i < 4; i++) { /* half of what is around is the ground */
        s->ground = vec3_scale(vec3_mul(albedo, vec3_add(illuminance_of(s), beam)), 1 / PI);
        s->around = vec3_scale(vec3_add(vec3_scale(illuminance_of(s), 1 / PI), s->ground), 0.5f);
    }
    const float wanted = 0.5f * above * (128000 - luminance_of(sun)) + 800 * powf(10, 0.395f * fminf(elevation, 0));
    const float factor = wanted / luminance_of(illuminance_of(s));
    s->scale = vec3_scale(s->scale, factor);
    s->around = vec3_scale(s->around, factor);
    s->ground = vec3_scale(vec3_mul(albedo, vec3_add(illuminance_of(s), beam)), 1 / PI);
    if (values[SKY_SUN] > 0) s->source = (struct panorama_source){vec3_scale(sun, shown), s->sun, radius * DEGREES};
}

/* The ground fades into the haze at the horizon. */
static vec3 sky(const struct made *s, vec3 d) {
    const vec3 dome = sky_dome(s, vec3_normalize(vec3_make(d.x, fmaxf(d.y, 0), d.z)));
    return d.y < 0 ? vec3_lerp(s->ground, dome, expf(d.y * 25)) : dome;
}

/* ---- making one ---- */

/* Adds the source to the picture: a disk with the illuminance of the whole. */
static void paint(struct panorama *p, const struct panorama_source *source) {
    const float texel = PI / (float)p->height;
    vec3 *texels = (vec3 *)p->texels;
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
        for (uint32_t y = 0; y < p->height; y++) {
            const float area = 2 * PI / (float)p->width * (cosf(texel * (float)y) - cosf(texel * (float)(y + 1)));
            for (uint32_t x = 0; x < p->width; x++) {
                const vec3 d = panorama_direction(p, (float)x, (float)y);
                const float angle = acosf(CLAMP(vec3_dot(d, source->direction), -1.0f, 1.0f)), inside = CLAMP((source->half_angle - angle) / texel + 1, 0.0f, 1.0f);
                if (inside == 0) continue;
                if (pass == 0) sum += (double)(inside * area);
                else texels[(size_t)y * p->width + x] = vec3_add(texels[(size_t)y * p->width + x], vec3_scale(source->illuminance, inside / (float)sum));
            }
        }
}

static const struct kind {
    const char *name;
    void (*begin)(const double *values, struct made *out);
    vec3 (*radiance)(const struct made *made, vec3 direction);
    const struct query_key *keys;
    const double *usual;
    uint32_t key_count;
} kinds[] = {{"studio", studio_begin, studio, NULL, NULL, 0},
             {"sky", sky_begin, sky, sky_keys, sky_usual, SKY_KEYS},
             {"overcast", overcast_begin, overcast, NULL, NULL, 0}};

static fnl_result read_name(const fnl_host *host, const char *name, const struct kind **kind, struct made *out) {
    const size_t length = query_name_length(name);
    for (*kind = kinds; *kind < kinds + COUNT_OF(kinds); ++*kind)
        if (strlen((*kind)->name) == length && memcmp((*kind)->name, name, length) == 0) break;
    if (*kind == kinds + COUNT_OF(kinds)) {
        log_error(host, "builtin:%s: there is no environment '%.*s'; there are: studio, sky, overcast", name, (int)MIN(length, 64), name);
        return FNL_ERROR_UNSUPPORTED;
    }
    double values[SKY_KEYS];
    for (uint32_t i = 0; i < (*kind)->key_count; i++) values[i] = (*kind)->usual[i];
    TRY(query_read(host, name, (*kind)->name, (*kind)->keys, (*kind)->key_count, values));
    (*kind)->begin(values, out);
    return FNL_OK;
}

fnl_result panorama_make(const fnl_host *host, const char *name, bool apart, struct panorama *out, struct panorama_source *source, uint32_t *source_count) {
    enum { WIDTH = 512 };
    const struct kind *kind;
    struct made made;
    struct panorama p = {.width = WIDTH, .height = WIDTH / 2};
    *source_count = 0;
    TRY(read_name(host, name, &kind, &made));
    p.texels = host_allocate(host, (size_t)p.width * p.height * sizeof(vec3));
    if (!p.texels) return FNL_ERROR_MEMORY;
    for (uint32_t y = 0; y < p.height; y++)
        for (uint32_t x = 0; x < p.width; x++) {
            const vec3 light = kind->radiance(&made, panorama_direction(&p, (float)x, (float)y));
            memcpy(p.texels + 3 * ((size_t)y * p.width + x), &light, sizeof light);
        }
    const bool shines = made.source.illuminance.x > 0;
    if (shines && apart) source[(*source_count)++] = made.source;
    if (shines && !apart) paint(&p, &made.source);
    *out = p;
    return FNL_OK;
}
