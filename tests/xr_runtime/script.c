/* SPDX-License-Identifier: MIT */
#include "runtime.h"

#include <math.h>
#include <openxr/openxr_reflection.h>
#include <stdlib.h>
#include <string.h>

#define RESULT_ROW(name, value) {#name, value},
static const struct {
    const char *name;
    int value;
} results[] = {XR_LIST_ENUM_XrResult(RESULT_ROW)};

XrResult script_result(const char *name) {
    for (size_t i = 0; i < sizeof results / sizeof *results; i++)
        if (strcmp(results[i].name, name) == 0) return (XrResult)results[i].value;
    return XR_RESULT_MAX_ENUM;
}

const char *result_name(XrResult result) {
    for (size_t i = 0; i < sizeof results / sizeof *results; i++)
        if (results[i].value == (int)result) return results[i].name;
    return "XR_UNKNOWN";
}

static const double degree = 3.14159265358979323846 / 180;

static XrPosef pose_of(double x, double y, double z, double yaw, double pitch) {
    const double a = yaw * degree / 2, b = pitch * degree / 2;
    return (XrPosef){{(float)(cos(a) * sin(b)), (float)(sin(a) * cos(b)), (float)(-sin(a) * sin(b)), (float)(cos(a) * cos(b))}, {(float)x, (float)y, (float)z}};
}

static void corners(uint32_t view, double part, struct mask *mask) {
    const XrFovf *f = &rt.script.fov[view];
    const double x[2] = {tan((double)f->angleLeft), tan((double)f->angleRight)}, y[2] = {tan((double)f->angleDown), tan((double)f->angleUp)};
    *mask = (struct mask){0};
    for (uint32_t i = 0; part > 0 && i < 4; i++) {
        const double cx = x[i & 1], cy = y[i >> 1], dx = (x[!(i & 1)] - cx) * part, dy = (y[!(i >> 1)] - cy) * part;
        XrVector2f *v = &mask->vertices[mask->vertex_count];
        const bool turns = (i & 1) ^ (i >> 1); /* all counter-clockwise */
        v[0] = (XrVector2f){(float)cx, (float)cy};
        v[turns ? 2 : 1] = (XrVector2f){(float)(cx + dx), (float)cy};
        v[turns ? 1 : 2] = (XrVector2f){(float)cx, (float)(cy + dy)};
        for (uint32_t k = 0; k < 3; k++) mask->indices[mask->index_count++] = mask->vertex_count + k;
        mask->vertex_count += 3;
    }
}

static void usual(struct script *s) {
    *s = (struct script){.view_count = 2, .period = 1000.0 / 90, .save_count = 0};
    const int64_t formats[] = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT, VK_FORMAT_D16_UNORM};
    memcpy(s->formats, formats, sizeof formats);
    s->format_count = sizeof formats / sizeof *formats;
    s->head.y = 1.6;
    for (uint32_t i = 0; i < VIEWS; i++) {
        const double out = 50 * degree, in = 42 * degree; /* not symmetric */
        s->width[i] = s->height[i] = 48;
        s->fov[i] = (XrFovf){(float)(i & 1 ? -in : -out), (float)(i & 1 ? out : in), (float)(45 * degree), (float)(-48 * degree)};
        s->eye[i] = pose_of(i & 1 ? 0.032 : -0.032, 0, 0, 0, 0);
    }
    for (uint32_t i = 0; i < VIEWS; i++) corners(i, 0.125, &s->masks[i]);
}

static bool line(struct script *s, char *text) {
    char word[64], more[64], last[64];
    double n[8] = {0};
    unsigned index = 0, call = 0;
    if (sscanf(text, "%63s", word) != 1 || *word == '#') return true;
    const char *rest = strstr(text, word) + strlen(word);
    if (strcmp(word, "views") == 0) return sscanf(rest, "%u", &s->view_count) == 1 && s->view_count >= 1 && s->view_count <= VIEWS;
    if (strcmp(word, "size") == 0) {
        const int count = sscanf(rest, "%lf %lf %u", &n[0], &n[1], &index);
        for (uint32_t i = count == 3 ? index : 0; i < (count == 3 ? index + 1 : VIEWS) && i < VIEWS; i++) s->width[i] = (uint32_t)n[0], s->height[i] = (uint32_t)n[1];
        return count >= 2;
    }
    if (strcmp(word, "fov") == 0) { /* degrees: left right down up [view] */
        const int count = sscanf(rest, "%lf %lf %lf %lf %u", &n[0], &n[1], &n[2], &n[3], &index);
        for (uint32_t i = count == 5 ? index : 0; i < (count == 5 ? index + 1 : VIEWS) && i < VIEWS; i++)
            s->fov[i] = (XrFovf){(float)(n[0] * degree), (float)(n[1] * degree), (float)(n[3] * degree), (float)(n[2] * degree)};
        return count >= 4;
    }
    if (strcmp(word, "eye") == 0) {
        if (sscanf(rest, "%u %lf %lf %lf %lf %lf", &index, &n[0], &n[1], &n[2], &n[3], &n[4]) != 6 || index >= VIEWS) return false;
        s->eye[index] = pose_of(n[0], n[1], n[2], n[3], n[4]);
        return true;
    }
    if (strcmp(word, "formats") == 0) {
        s->format_count = 0;
        for (char *end; s->format_count < FORMATS; rest = end) {
            const long value = strtol(rest, &end, 10);
            if (end == rest) break;
            s->formats[s->format_count++] = value;
        }
        return true;
    }
    if (strcmp(word, "without") == 0) return s->without_count < 16 && sscanf(rest, "%63s", s->without[s->without_count++]) == 1;
    if (strcmp(word, "no_stage") == 0) return s->no_stage = true;
    if (strcmp(word, "no_local") == 0) return s->no_local = true;
    if (strcmp(word, "no_system") == 0) return s->no_system = true;
    if (strcmp(word, "refresh") == 0) {
        if (sscanf(rest, "%lf", &n[0]) != 1 || n[0] <= 0) return false;
        s->period = 1000 / n[0];
        return true;
    }
    if (strcmp(word, "head") == 0) return sscanf(rest, "%lf %lf %lf %lf", &s->head.x, &s->head.y, &s->head.z, &s->head.yaw) >= 3;
    if (strcmp(word, "sway") == 0) return sscanf(rest, "%lf %lf", &s->head.sway, &s->head.sway_seconds) == 2;
    if (strcmp(word, "turn") == 0) {
        if (sscanf(rest, "%lf %lf", &s->head.turn, &s->head.turn_seconds) != 2) return false;
        s->head.turn *= degree;
        return true;
    }
    if (strcmp(word, "mask") == 0) { /* part of the edge that a corner takes [view] */
        const int count = sscanf(rest, "%lf %u", &n[0], &index);
        for (uint32_t i = count == 2 ? index : 0; i < (count == 2 ? index + 1 : VIEWS) && i < VIEWS; i++) corners(i, n[0], &s->masks[i]);
        return count >= 1;
    }
    if (strcmp(word, "fail") == 0) {
        struct fault *f = &s->faults[s->fault_count];
        if (s->fault_count == ROWS || sscanf(rest, "%63s %u %63s", more, &call, last) != 3) return false;
        *f = (struct fault){.call = call, .result = script_result(last)};
        snprintf(f->function, sizeof f->function, "%s", more);
        s->fault_count++;
        return f->result != XR_RESULT_MAX_ENUM;
    }
    if (strcmp(word, "cost") == 0) {
        struct cost *c = &s->costs[s->cost_count];
        if (s->cost_count == ROWS || sscanf(rest, "%63s %lf", c->function, &c->milliseconds) != 2) return false;
        s->cost_count++;
        return true;
    }
    if (strcmp(word, "at") == 0) {
        struct moment *m = &s->moments[s->moment_count];
        if (s->moment_count == ROWS || sscanf(rest, "%u %31s %lf %lf %lf %lf", &m->frame, m->what, &m->numbers[0], &m->numbers[1], &m->numbers[2], &m->numbers[3]) < 2) return false;
        s->moment_count++;
        return true;
    }
    if (strcmp(word, "hand") == 0) { /* left|right FRAME x y z yaw pitch select squeeze */
        struct hand_row *h = &s->hands[s->hand_count];
        unsigned select, squeeze;
        if (s->hand_count == ROWS || sscanf(rest, "%63s %u %lf %lf %lf %lf %lf %u %u", more, &h->frame, &n[0], &n[1], &n[2], &n[3], &n[4], &select, &squeeze) != 9) return false;
        h->hand = strcmp(more, "right") == 0;
        h->pose = pose_of(n[0], n[1], n[2], n[3], n[4]);
        h->tracked = true;
        h->select = select != 0;
        h->squeeze = squeeze != 0;
        s->hand_count++;
        return true;
    }
    if (strcmp(word, "gaze") == 0) { /* FRAME yaw pitch [guessed], FRAME lost, FRAME off */
        struct gaze_row *g = &s->gazes[s->gaze_count];
        if (s->gaze_count == ROWS || sscanf(rest, "%u %63s", &g->frame, more) != 2) return false;
        const bool guessed = sscanf(rest, "%*u %lf %lf %63s", &n[0], &n[1], last) == 3, aimed = sscanf(rest, "%*u %lf %lf", &n[0], &n[1]) == 2;
        if (!aimed && strcmp(more, "lost") != 0 && strcmp(more, "off") != 0) return false;
        if (guessed && strcmp(last, "guessed") != 0) return false;
        g->pose = pose_of(0, 0, 0, n[0], n[1]);
        g->active = strcmp(more, "off") != 0;
        g->valid = aimed;
        g->tracked = aimed && !guessed;
        s->gaze_count++;
        return true;
    }
    if (strcmp(word, "save") == 0) return sscanf(rest, "%u %u %511s", &s->save_first, &s->save_count, s->save) == 3;
    return false;
}

bool script_read(const char *path) {
    struct script *s = &rt.script;
    char text[1024];
    usual(s);
    FILE *file = path && *path ? fopen(path, "r") : NULL;
    if (path && *path && !file) {
        fprintf(stderr, "xr_runtime: %s cannot be read\n", path);
        return false;
    }
    for (uint32_t number = 1; file && fgets(text, sizeof text, file); number++)
        if (!line(s, text)) {
            fprintf(stderr, "xr_runtime: %s:%u is not understood: %s", path, number, text);
            fclose(file);
            return false;
        }
    if (file) fclose(file);
    return true;
}
