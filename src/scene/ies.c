/* SPDX-License-Identifier: MIT */
/* Files of IESNA LM-63, and the grid that renderers look them up in. */
#include "scene/ies.h"

#include <ctype.h>
#include <math.h>
#include <strings.h>

enum { SIZE_MAX_BYTES = 16 << 20, STEPS_MOST = 360 };

/* ---- reading ---- */

struct reader {
    const fnl_host *host;
    const char *name, *at; /* the text ends with a 0 */
    uint32_t line;
    fnl_result result;
};

static void fail(struct reader *r, const char *words) {
    if (r->result != FNL_OK) return;
    log_error(r->host, "%s: line %u: %s", r->name, r->line, words);
    r->result = FNL_ERROR_FORMAT;
}

/** The next number; blanks, ends of lines and commas stand between them. */
static double number(struct reader *r, const char *what) {
    char words[160];
    while (*r->at && (isspace((unsigned char)*r->at) || *r->at == ',')) r->line += *r->at++ == '\n';
    char *end;
    const double value = *r->at ? number_read(r->at, &end) : 0;
    if (r->result != FNL_OK) return 0;
    if (!*r->at || end == r->at || !strchr("+-.0123456789", *r->at) || memchr(r->at, 'x', (size_t)(end - r->at)) || memchr(r->at, 'X', (size_t)(end - r->at)) || !isfinite(value) || (*end && !isspace((unsigned char)*end) && *end != ',')) {
        snprintf(words, sizeof words, *r->at ? "%s is no number" : "ends before %s", what);
        fail(r, words);
        return 0;
    }
    r->at = end;
    return value;
}

static uint32_t whole(struct reader *r, const char *what, uint32_t low, uint32_t high) {
    char words[160];
    const double value = number(r, what);
    if (r->result == FNL_OK && value >= low && value <= high && value == floor(value)) return (uint32_t)value;
    text_format(words, sizeof words, "%s is %g, must be a whole number from %u to %u", what, value, low, high);
    fail(r, words);
    return 0;
}

/** Goes behind the line "TILT=…"; false: there is none. `includes`: lamp data follow. */
static bool find_tilt(struct reader *r, bool *includes) {
    for (; *r->at; r->line++) {
        const char *at = r->at, *end = strchr(at, '\n');
        while (*at == ' ' || *at == '\t') at++;
        bool is_tilt = toupper((unsigned char)at[0]) == 'T' && strncasecmp(at, "TILT", 4) == 0;
        for (at += is_tilt ? 4 : 0; is_tilt && (*at == ' ' || *at == '\t');) at++;
        is_tilt = is_tilt && *at == '=';
        if (is_tilt) {
            for (at++; *at == ' ' || *at == '\t';) at++;
            *includes = strncasecmp(at, "INCLUDE", 7) == 0;
        }
        r->at = end ? end + 1 : strchr(r->at, 0);
        if (is_tilt) {
            r->line++;
            return true;
        }
    }
    return false;
}

/* ---- the photometric web as the file has it: degrees, candela ---- */

enum { TYPE_C = 1, TYPE_B, TYPE_A };

struct web {
    uint32_t type, vertical_count, horizontal_count;
    double *verticals, *horizontals, *candela; /* [horizontal][vertical] */
    double fold; /* type C: the horizontal angles repeat, mirrored, after so many degrees; 360: not at all */
    double start;
};

static void read_angles(struct reader *r, double *angles, uint32_t count, const char *what) {
    for (uint32_t i = 0; i < count && r->result == FNL_OK; i++) {
        angles[i] = number(r, what);
        if (r->result == FNL_OK && i > 0 && !(angles[i] > angles[i - 1])) {
            char words[100];
            snprintf(words, sizeof words, "%ss do not ascend", what);
            fail(r, words);
        }
    }
}

static bool near_to(double a, double b) { return fabs(a - b) < 1e-3; }

static void check_angles(struct reader *r, struct web *w) {
    const double first = w->horizontals[0], last = w->horizontals[w->horizontal_count - 1];
    const double lowest = w->verticals[0], highest = w->verticals[w->vertical_count - 1];
    if (w->type != TYPE_C) {
        if (lowest < -90.001 || highest > 90.001 || first < -90.001 || last > 90.001) fail(r, "angles of type A and B lie from -90 to 90 degrees");
        return;
    }
    if (lowest < -1e-3 || highest > 180.001) fail(r, "vertical angles of type C lie from 0 to 180 degrees");
    w->start = 0;
    w->fold = 360;
    if (w->horizontal_count == 1) return;
    if (near_to(first, 90) && near_to(last, 270)) { /* 1995: one side of the plane from 90 to 270 */
        w->start = 90;
        w->fold = 180;
    } else if (!near_to(first, 0) || last > 360.001) {
        fail(r, "horizontal angles of type C begin at 0, or lie from 90 to 270 degrees");
    } else if (near_to(last, 90) || near_to(last, 180)) {
        w->fold = round(last);
    } else if (last < 180) {
        fail(r, "horizontal angles of type C end at 90, 180 or 360 degrees");
    }
}

static void read_web(struct reader *r, size_t size, struct web *w, struct arena *scratch, double *scale, bool has_lamp_factor) {
    number(r, "the number of lamps");
    number(r, "the lumens of a lamp");
    *scale = number(r, "the multiplier");
    if (r->result == FNL_OK && !(*scale > 0)) fail(r, "the multiplier is not above 0");
    const uint32_t most = (uint32_t)(size / 2 + 1); /* a number and a blank each */
    w->vertical_count = whole(r, "the number of vertical angles", 2, most);
    w->horizontal_count = whole(r, "the number of horizontal angles", 1, most);
    w->type = whole(r, "the photometric type", TYPE_C, TYPE_A);
    number(r, "the type of units");
    for (int i = 0; i < 3; i++) number(r, "the size of the luminaire");
    const double ballast = number(r, "the ballast factor"), lamp = number(r, "the ballast-lamp factor");
    number(r, "the input watts");
    if (ballast > 0) *scale *= ballast;
    if (has_lamp_factor && lamp > 0) *scale *= lamp;
    const uint64_t count = (uint64_t)w->vertical_count * w->horizontal_count;
    if (r->result == FNL_OK && count > most) fail(r, "there are more candela values than the file has room for");
    if (r->result != FNL_OK) return;
    w->verticals = arena_allocate(scratch, w->vertical_count * sizeof(double));
    w->horizontals = arena_allocate(scratch, w->horizontal_count * sizeof(double));
    w->candela = arena_allocate(scratch, count * sizeof(double));
    if (!w->verticals || !w->horizontals || !w->candela) {
        r->result = FNL_ERROR_MEMORY;
        return;
    }
    read_angles(r, w->verticals, w->vertical_count, "vertical angle");
    read_angles(r, w->horizontals, w->horizontal_count, "horizontal angle");
    if (r->result == FNL_OK) check_angles(r, w);
    for (uint64_t i = 0; i < count && r->result == FNL_OK; i++) w->candela[i] = fmax(number(r, "a candela value"), 0);
}

/** Where an angle lies between given ones: after `*index`, by `*part` of the way. False: outside. */
static bool place(const double *angles, uint32_t count, double angle, uint32_t *index, double *part) {
    *index = 0;
    *part = 0;
    if (count == 1) return true;
    if (angle < angles[0] - 1e-6 || angle > angles[count - 1] + 1e-6) return false;
    uint32_t low = 0, high = count - 1;
    while (high - low > 1) {
        const uint32_t middle = (low + high) / 2;
        if (angles[middle] <= angle)
            low = middle;
        else
            high = middle;
    }
    *index = low;
    *part = fmin(fmax((angle - angles[low]) / (angles[low + 1] - angles[low]), 0), 1);
    return true;
}

static double between(const struct web *w, uint32_t h0, uint32_t h1, double h, uint32_t v, double part) {
    const double *a = w->candela + (size_t)h0 * w->vertical_count + v, *b = w->candela + (size_t)h1 * w->vertical_count + v;
    const uint32_t next = part > 0 ? 1 : 0;
    return (1 - h) * (a[0] + (a[next] - a[0]) * part) + h * (b[0] + (b[next] - b[0]) * part);
}

static double web_c(const struct web *w, double vertical, double horizontal) {
    uint32_t v, h;
    double v_part, h_part;
    if (!place(w->verticals, w->vertical_count, vertical, &v, &v_part)) return 0;
    horizontal = fmod(horizontal - w->start + 720, 360);
    if (w->fold < 360) {
        horizontal = fmod(horizontal, 2 * w->fold);
        if (horizontal > w->fold) horizontal = 2 * w->fold - horizontal;
    }
    horizontal += w->start;
    const uint32_t last = w->horizontal_count - 1;
    if (w->horizontal_count > 1 && horizontal > w->horizontals[last]) { /* 360 is left out, as 0 stands there */
        const double gap = w->horizontals[0] + 360 - w->horizontals[last];
        return between(w, last, 0, gap > 0 ? (horizontal - w->horizontals[last]) / gap : 0, v, v_part);
    }
    place(w->horizontals, w->horizontal_count, horizontal, &h, &h_part);
    return between(w, h, MIN(h + 1, last), h_part, v, v_part);
}

/**
 * Types A and B look along the light's direction, up is up, and horizontal angles grow clockwise seen from above, to the side. A: longitude and
 * latitude with the poles above and below. B: with the poles at both sides. A web that begins at 0 across is the same on the other side.
 */
static double web_ab(const struct web *w, double side, double up, double along) {
    const double degrees = 57.295779513082321;
    double horizontal, vertical;
    if (w->type == TYPE_A) {
        horizontal = atan2(side, along) * degrees;
        vertical = asin(fmin(fmax(up, -1), 1)) * degrees;
    } else {
        horizontal = asin(fmin(fmax(side, -1), 1)) * degrees;
        vertical = atan2(up, along) * degrees;
    }
    uint32_t v, h;
    double v_part, h_part;
    if (w->horizontals[0] > -1e-3) horizontal = fabs(horizontal);
    if (!place(w->verticals, w->vertical_count, vertical, &v, &v_part) || !place(w->horizontals, w->horizontal_count, horizontal, &h, &h_part)) return 0;
    return between(w, h, MIN(h + 1, w->horizontal_count - 1), h_part, v, v_part);
}

/* ---- the grid ---- */

/** The least number of steps of `range` that all angles lie on; the most there are if none. */
static uint32_t fitting_steps(const double *angles, uint32_t count, double range, double besides) {
    for (uint32_t n = 1; n < STEPS_MOST; n++) {
        bool fits = near_to(besides * n / range, round(besides * n / range));
        for (uint32_t i = 0; i < count && fits; i++) fits = near_to(angles[i] * n / range, round(angles[i] * n / range));
        if (fits) return n;
    }
    return STEPS_MOST;
}

/** Whether the light ends at once where the vertical angles do. */
static bool ends_hard(const struct web *w) {
    const uint32_t last = w->vertical_count - 1;
    bool hard = false;
    for (uint32_t h = 0; h < w->horizontal_count; h++) {
        const double *column = w->candela + (size_t)h * w->vertical_count;
        hard |= (w->verticals[0] > 1e-3 && column[0] > 0) || (w->verticals[last] < 179.999 && column[last] > 0);
    }
    return hard;
}

static fnl_result make_grid(const struct web *w, double brightest, struct arena *arena, struct light_profile *out) {
    out->rows = out->columns = STEPS_MOST;
    if (w->type == TYPE_C) {
        if (!ends_hard(w)) out->rows = fitting_steps(w->verticals, w->vertical_count, 180, 0);
        out->columns = w->horizontal_count == 1 ? 1 : fitting_steps(w->horizontals, w->horizontal_count, 360, w->fold);
    }
    float *values = arena_allocate(arena, (size_t)(out->rows + 1) * out->columns * sizeof *values);
    if (!values) return FNL_ERROR_MEMORY;
    out->values = values;
    for (uint32_t i = 0; i <= out->rows; i++)
        for (uint32_t k = 0; k < out->columns; k++) {
            const double vertical = 180.0 * i / out->rows, horizontal = 360.0 * k / out->columns;
            double candela;
            if (w->type == TYPE_C) {
                candela = web_c(w, vertical, horizontal);
            } else {
                const double v = vertical / 57.295779513082321, h = horizontal / 57.295779513082321;
                candela = web_ab(w, sin(v) * cos(h), sin(v) * sin(h), cos(v));
            }
            *values++ = (float)(candela / brightest);
        }
    return FNL_OK;
}

static fnl_result read_text(struct reader *r, size_t size, struct arena *scratch, struct arena *arena, struct light_profile *out) {
    const char *line_end = strchr(r->at, '\n');
    const size_t first_line = line_end ? (size_t)(line_end - r->at) : strlen(r->at);
    bool newer = false, includes = false;
    for (size_t i = 0; i + 4 <= first_line; i++) newer |= strncmp(r->at + i, "2002", 4) == 0 || strncmp(r->at + i, "2019", 4) == 0;
    if (!find_tilt(r, &includes)) {
        r->line = MAX(r->line, 2) - 1;
        fail(r, "has no line TILT=, so is no photometric file of IESNA LM-63");
        return r->result;
    }
    if (includes) { /* how lamps dim when the luminaire is tilted, which no renderer knows */
        number(r, "the lamp's geometry");
        const uint32_t count = whole(r, "the number of tilt angles", 0, (uint32_t)(size / 2 + 1));
        for (uint32_t i = 0; i < 2 * count && r->result == FNL_OK; i++) number(r, "a tilt angle or factor");
    }
    struct web web = {0};
    double scale = 1, brightest = 0;
    read_web(r, size, &web, scratch, &scale, !newer);
    if (r->result != FNL_OK) return r->result;
    for (uint64_t i = 0; i < (uint64_t)web.vertical_count * web.horizontal_count; i++) brightest = fmax(brightest, web.candela[i]);
    if (!(brightest > 0) || !(brightest * scale < 1e30)) {
        fail(r, brightest > 0 ? "the candela values are too large" : "there is no light in any direction");
        return r->result;
    }
    out->candela = (float)(brightest * scale);
    return make_grid(&web, brightest, arena, out);
}

fnl_result ies_read(const fnl_host *host, struct arena *arena, const char *name, const void *data, size_t size, struct light_profile *out) {
    *out = (struct light_profile){.name = arena_string(arena, name)};
    if (size > SIZE_MAX_BYTES) {
        log_error(host, "%s: has %zu bytes, and no photometric file more than %d", name, size, SIZE_MAX_BYTES);
        return FNL_ERROR_FORMAT;
    }
    char *text = host_allocate(host, size + 1);
    if (!text || !out->name) {
        host_free(host, text, size + 1);
        return FNL_ERROR_MEMORY;
    }
    if (size) memcpy(text, data, size);
    text[size] = 0;
    struct reader reader = {.host = host, .name = name, .at = text, .line = 1};
    struct arena scratch;
    arena_init(&scratch, host, (size_t)64 << 10);
    fnl_result result = read_text(&reader, size, &scratch, arena, out);
    arena_finish(&scratch);
    host_free(host, text, size + 1);
    return result;
}

double light_profile_at(const struct light_profile *p, double side, double up, double along) {
    const double pi = 3.14159265358979323846, across = atan2(up, side);
    const double row = acos(fmin(fmax(along, -1), 1)) / pi * p->rows, column = (across < 0 ? across + 2 * pi : across) / (2 * pi) * p->columns;
    const uint32_t i = MIN((uint32_t)row, p->rows - 1), k = (uint32_t)column % p->columns, next = (k + 1) % p->columns;
    const double down = row - i, right = p->columns == 1 ? 0 : column - floor(column);
    const float *a = p->values + (size_t)i * p->columns, *b = a + p->columns;
    const double upper = (double)a[k] + ((double)a[next] - (double)a[k]) * right, lower = (double)b[k] + ((double)b[next] - (double)b[k]) * right;
    return upper + (lower - upper) * down;
}
