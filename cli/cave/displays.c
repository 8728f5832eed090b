/* SPDX-License-Identifier: MIT */
#include "cave/displays.h"

#include "arguments.h"
#include "cave/hash.h"
#include "input.h"
#include "loading.h"
#include "print.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- examples ---- */

#define EYES "  \"head\": {\"position\": [0, 1.7, 0]},\n  \"ipd\": 0.064,\n"
#define CORNERS(a, b, c) "\"lower_left\": " a ", \"lower_right\": " b ", \"upper_left\": " c

static const struct {
    const char *name, *text;
} examples[] = {
    {"mono", "{\n" EYES "  \"walls\": [\n"
             "    {\"name\": \"front\", \"resolution\": [1280, 720],\n"
             "     " CORNERS("[-0.8, 1.25, -1]", "[0.8, 1.25, -1]", "[-0.8, 2.15, -1]") "}\n"
             "  ]\n}\n"},
    {"stereo", "{\n" EYES "  \"walls\": [\n"
               "    {\"name\": \"front\", \"resolution\": [1280, 720], \"stereo\": true,\n"
               "     " CORNERS("[-0.8, 1.25, -1]", "[0.8, 1.25, -1]", "[-0.8, 2.15, -1]") "}\n"
               "  ]\n}\n"},
    /* Two more of the same size, which are turned towards the viewer by 45 degrees. */
    {"three", "{\n" EYES "  \"walls\": [\n"
              "    {\"name\": \"front\", \"resolution\": [1280, 720], \"stereo\": true,\n"
              "     " CORNERS("[-0.8, 1.25, -1]", "[0.8, 1.25, -1]", "[-0.8, 2.15, -1]") "},\n"
              "    {\"name\": \"left\", \"resolution\": [1280, 720],\n"
              "     " CORNERS("[-1.9313708, 1.25, 0.1313708]", "[-0.8, 1.25, -1]", "[-1.9313708, 2.15, 0.1313708]") "},\n"
              "    {\"name\": \"right\", \"resolution\": [1280, 720],\n"
              "     " CORNERS("[0.8, 1.25, -1]", "[1.9313708, 1.25, 0.1313708]", "[0.8, 2.15, -1]") "}\n"
              "  ]\n}\n"},
    /* A room of three metres, open at the back. */
    {"cave", "{\n" EYES "  \"walls\": [\n"
             "    {\"name\": \"front\", \"resolution\": [1024, 1024], \"stereo\": true,\n"
             "     " CORNERS("[-1.5, 0, -1.5]", "[1.5, 0, -1.5]", "[-1.5, 3, -1.5]") "},\n"
             "    {\"name\": \"left\", \"resolution\": [1024, 1024], \"stereo\": true,\n"
             "     " CORNERS("[-1.5, 0, 1.5]", "[-1.5, 0, -1.5]", "[-1.5, 3, 1.5]") "},\n"
             "    {\"name\": \"right\", \"resolution\": [1024, 1024], \"stereo\": true,\n"
             "     " CORNERS("[1.5, 0, -1.5]", "[1.5, 0, 1.5]", "[1.5, 3, -1.5]") "},\n"
             "    {\"name\": \"floor\", \"resolution\": [1024, 1024], \"stereo\": true,\n"
             "     " CORNERS("[-1.5, 0, 1.5]", "[1.5, 0, 1.5]", "[-1.5, 0, -1.5]") "},\n"
             "    {\"name\": \"ceiling\", \"resolution\": [1024, 1024], \"stereo\": true,\n"
             "     " CORNERS("[-1.5, 3, -1.5]", "[1.5, 3, -1.5]", "[-1.5, 3, 1.5]") "}\n"
             "  ]\n}\n"},
};
enum { EXAMPLES = sizeof examples / sizeof *examples };

const char *cave_displays_example(const char *source) {
    for (int i = 0; i < EXAMPLES && loading_is_builtin(source); i++)
        if (strcmp(source + strlen("builtin:"), examples[i].name) == 0) return examples[i].text;
    return NULL;
}

const char *cave_eye_name(enum cave_eye eye) {
    static const char *const names[] = {"mono", "left", "right"};
    return names[eye];
}

/* ---- reading ---- */

/* Where in the file something is: "/walls/3/resolution". */
struct reader {
    const char *file;
    char place[256];
};

__attribute__((format(printf, 2, 3))) static bool bad(const struct reader *r, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "fanal: error: %s: %s: ", r->file, r->place[0] ? r->place : "/");
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return false;
}

/* Steps into a member; leave() undoes it. */
static size_t enter(struct reader *r, const char *key) {
    const size_t length = strlen(r->place);
    snprintf(r->place + length, sizeof r->place - length, "/%s", key);
    return length;
}
static size_t enter_index(struct reader *r, size_t index) {
    char key[24];
    snprintf(key, sizeof key, "%zu", index);
    return enter(r, key);
}
static void leave(struct reader *r, size_t length) { r->place[length] = 0; }

/* An object with no other keys than these. */
static bool check_keys(struct reader *r, const json_t *object, const char *const *known) {
    const char *key;
    json_t *value;
    if (!json_is_object(object)) return bad(r, "must be an object");
    json_object_foreach((json_t *)object, key, value) {
        size_t i = 0;
        while (known[i] && strcmp(known[i], key) != 0) i++;
        if (known[i]) continue;
        char list[256] = "";
        for (i = 0; known[i]; i++) snprintf(list + strlen(list), sizeof list - strlen(list), i ? ", %s" : "%s", known[i]);
        return bad(r, "has no '%s'; it may have %s", key, list);
    }
    return true;
}

static bool read_numbers(struct reader *r, const json_t *array, size_t count, double *out) {
    bool good = json_is_array(array) && json_array_size(array) == count;
    for (size_t i = 0; i < count && good; i++) {
        const json_t *value = json_array_get(array, i);
        good = json_is_number(value) && fabs(json_number_value(value)) <= 1e6;
        if (good) out[i] = json_number_value(value);
    }
    return good || bad(r, "must be %zu numbers from -1e6 to 1e6", count);
}

/* A member with numbers; without it `out` stays, unless it is needed. */
static bool read_vector(struct reader *r, const json_t *object, const char *key, bool needed, struct cave_vector *out) {
    const json_t *value = json_object_get(object, key);
    const size_t outside = enter(r, key);
    double numbers[3];
    if (!value && needed) return bad(r, "is missing");
    if (value && !read_numbers(r, value, 3, numbers)) return false;
    if (value) *out = (struct cave_vector){numbers[0], numbers[1], numbers[2]};
    leave(r, outside);
    return true;
}

/* Of length 1, but for what its digits leave out. */
static bool normalise(const struct reader *r, struct cave_quaternion *q) {
    const double length = sqrt(q->x * q->x + q->y * q->y + q->z * q->z + q->w * q->w);
    if (!(fabs(length - 1) < 1e-3)) return bad(r, "must be a unit quaternion x, y, z, w; its length is %g", length);
    *q = (struct cave_quaternion){q->x / length, q->y / length, q->z / length, q->w / length};
    return true;
}

static bool read_rotation(struct reader *r, const json_t *object, struct cave_quaternion *out) {
    const json_t *value = json_object_get(object, "rotation");
    const size_t outside = enter(r, "rotation");
    double q[4];
    if (value && !read_numbers(r, value, 4, q)) return false;
    if (value) {
        *out = (struct cave_quaternion){q[0], q[1], q[2], q[3]};
        if (!normalise(r, out)) return false;
    }
    leave(r, outside);
    return true;
}

static bool read_positive(struct reader *r, const json_t *object, const char *key, double low, double high, double *out) {
    const json_t *value = json_object_get(object, key);
    const size_t outside = enter(r, key);
    if (value) {
        const double number = json_is_number(value) ? json_number_value(value) : -1;
        if (!(number >= low && number <= high)) return bad(r, "must be a number from %g to %g", low, high);
        *out = number;
    }
    leave(r, outside);
    return true;
}

static bool read_pose(struct reader *r, const json_t *object, struct cave_pose *out) {
    *out = (struct cave_pose){.rotation = {0, 0, 0, 1}};
    return read_vector(r, object, "position", true, &out->position) && read_rotation(r, object, &out->rotation);
}

/* ---- the head ---- */

static bool add_sample(struct reader *r, struct cave_displays *d, const struct cave_sample *sample) {
    if (d->track_count > 0 && !(sample->time > d->track[d->track_count - 1].time)) return bad(r, "times must rise, %g s comes after %g s", sample->time, d->track[d->track_count - 1].time);
    if ((d->track_count & (d->track_count - 1)) == 0) { /* full: grows to the next power of two */
        struct cave_sample *grown = realloc(d->track, (d->track_count ? d->track_count * 2 : 1) * sizeof *grown);
        if (!grown) return bad(r, "memory ran out");
        d->track = grown;
    }
    d->track[d->track_count++] = *sample;
    return true;
}

static bool read_whole(const char *path, char **out, size_t *size) {
    FILE *file = input_open(path, 1 << 28);
    size_t capacity = 0;
    *out = NULL;
    *size = 0;
    bool good = file != NULL;
    while (good && !feof(file)) {
        capacity += 65536;
        char *grown = realloc(*out, capacity + 1);
        good = grown != NULL;
        if (!good) break;
        *out = grown;
        *size += fread(*out + *size, 1, capacity - *size, file);
        good = !ferror(file);
    }
    if (good)
        (*out)[*size] = 0;
    else if (file)
        fprintf(stderr, "fanal: error: %s: cannot be read: %s\n", path, strerror(errno));
    if (file) fclose(file);
    return good;
}

/* Lines "seconds x y z [qx qy qz qw]"; # begins a comment. */
static bool read_track_file(struct cave_displays *d, const char *path) {
    char *text, *rest;
    size_t size;
    bool good = read_whole(path, &text, &size);
    struct reader r = {.file = path};
    if (good) d->hash = cave_hash(text, size, d->hash);
    rest = text;
    for (unsigned line = 1; good && rest; line++) {
        char *row = strsep(&rest, "\n");
        row[strcspn(row, "#\r")] = 0;
        if (row[strspn(row, " \t")] == 0) continue;
        snprintf(r.place, sizeof r.place, "line %u", line);
        double v[8] = {0, 0, 0, 0, 0, 0, 0, 1};
        const char *at = row;
        const uint32_t count = argument_take_row(&at, v, 8);
        struct cave_sample s = {.time = v[0], .pose = {.position = {v[1], v[2], v[3]}, .rotation = {v[4], v[5], v[6], v[7]}}};
        struct cave_quaternion *q = &s.pose.rotation;
        const bool whole = (count == 4 || count == 8) && !*at, in_range = fabs(s.time) <= 1e6 && cave_length(s.pose.position) <= 1e6;
        if (!whole || !in_range)
            good = bad(&r, "must be 'seconds x y z', or with a rotation 'seconds x y z qx qy qz qw'");
        else
            good = normalise(&r, q) && add_sample(&r, d, &s);
    }
    if (good && d->track_count == 0) {
        snprintf(r.place, sizeof r.place, "the track");
        good = bad(&r, "has no line");
    }
    free(text);
    return good;
}

static bool read_head(struct reader *r, const json_t *root, struct cave_displays *d) {
    static const char *const keys[] = {"position", "rotation", NULL}, *const sample_keys[] = {"time", "position", "rotation", NULL};
    const json_t *head = json_object_get(root, "head");
    const size_t outside = enter(r, "head");
    struct cave_sample sample = {0};
    if (!head) return bad(r, "is missing: a pose, a track (an array of poses with a time each) or the name of a file");
    if (json_is_object(head)) {
        if (!check_keys(r, head, keys) || !read_pose(r, head, &sample.pose) || !add_sample(r, d, &sample)) return false;
    } else if (json_is_array(head) && json_array_size(head) > 0) {
        for (size_t i = 0; i < json_array_size(head); i++) {
            const json_t *one = json_array_get(head, i);
            const size_t here = enter_index(r, i);
            if (!check_keys(r, one, sample_keys) || !read_pose(r, one, &sample.pose)) return false;
            const json_t *time = json_object_get(one, "time");
            if (!json_is_number(time) || fabs(json_number_value(time)) > 1e6) return bad(r, "time must be a number of seconds");
            sample.time = json_number_value(time);
            if (!add_sample(r, d, &sample)) return false;
            leave(r, here);
        }
    } else if (json_is_string(head)) {
        const char *name = json_string_value(head), *slash = strrchr(r->file, '/');
        char path[4096];
        const int folder = name[0] != '/' && slash && !loading_is_builtin(r->file) ? (int)(slash + 1 - r->file) : 0;
        if (snprintf(path, sizeof path, "%.*s%s", folder, r->file, name) >= (int)sizeof path) return bad(r, "the name is too long");
        if (!read_track_file(d, path)) return false;
    } else {
        return bad(r, "must be a pose, a track (an array of poses with a time each) or the name of a file");
    }
    leave(r, outside);
    return true;
}

/* ---- walls ---- */

/* A number, or two: of the left eye and the right one. */
static bool read_owner(struct reader *r, const json_t *object, const char *key, const struct cave_wall *wall, uint32_t count, int32_t out[2]) {
    const json_t *value = json_object_get(object, key);
    const size_t outside = enter(r, key);
    out[0] = out[1] = -1;
    if (value) {
        const bool both = json_is_array(value);
        if (both && (json_array_size(value) != 2 || !wall->stereo)) return bad(r, "must be a number, or on a stereo wall two: of the left and of the right eye");
        for (size_t i = 0; i < 2; i++) {
            const json_t *one = both ? json_array_get(value, i) : value;
            if (!json_is_integer(one) || json_integer_value(one) < 0 || json_integer_value(one) >= (json_int_t)count)
                return count ? bad(r, "must be a whole number from 0 to %u", count - 1) : bad(r, "there are no /devices that it could count from 0");
            out[i] = (int32_t)json_integer_value(one);
        }
    }
    leave(r, outside);
    return true;
}

static bool check_rectangle(struct reader *r, const struct cave_wall *w) {
    const struct cave_vector right = cave_subtract(w->lower_right, w->lower_left), up = cave_subtract(w->upper_left, w->lower_left);
    const double width = cave_length(right), height = cave_length(up);
    if (!(width >= 1e-3 && height >= 1e-3)) return bad(r, "its sides are %g m and %g m, must be 1 mm or more", width, height);
    const double cosine = cave_dot(right, up) / width / height;
    if (fabs(cosine) < 1e-3) return true;
    return bad(r, "is no rectangle: the angle at lower_left is %.2f degrees, not 90", acos(fmax(-1, fmin(1, cosine))) * 57.295779513082321);
}

static bool read_wall(struct reader *r, const json_t *json, struct cave_displays *d) {
    static const char *const keys[] = {"name", "lower_left", "lower_right", "upper_left", "resolution", "stereo", "device", "rank", NULL};
    struct cave_wall *w = &d->walls[d->wall_count];
    double size[2];
    if (!check_keys(r, json, keys)) return false;
    size_t here = enter(r, "name");
    const char *name = json_string_value(json_object_get(json, "name"));
    if (!name || !*name || strlen(name) >= CAVE_NAME || name[strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")])
        return bad(r, "must be 1 to %d letters, digits, - or _", CAVE_NAME - 1);
    for (uint32_t i = 0; i < d->wall_count; i++)
        if (strcmp(d->walls[i].name, name) == 0) return bad(r, "wall %u is called '%s' too", i, name);
    strcpy(w->name, name);
    leave(r, here);
    if (!read_vector(r, json, "lower_left", true, &w->lower_left) || !read_vector(r, json, "lower_right", true, &w->lower_right) ||
        !read_vector(r, json, "upper_left", true, &w->upper_left) || !check_rectangle(r, w))
        return false;
    here = enter(r, "resolution");
    const json_t *resolution = json_object_get(json, "resolution");
    if (!resolution) return bad(r, "is missing: width and height in pixels");
    if (!read_numbers(r, resolution, 2, size)) return false;
    if (!(size[0] >= 1 && size[0] <= 16384 && size[1] >= 1 && size[1] <= 16384 && floor(size[0]) == size[0] && floor(size[1]) == size[1]))
        return bad(r, "must be two whole numbers from 1 to 16384");
    w->width = (uint32_t)size[0];
    w->height = (uint32_t)size[1];
    leave(r, here);
    here = enter(r, "stereo");
    const json_t *stereo = json_object_get(json, "stereo");
    if (stereo && !json_is_boolean(stereo)) return bad(r, "must be true or false");
    w->stereo = json_is_true(stereo);
    leave(r, here);
    if (!read_owner(r, json, "device", w, d->device_count, w->device) || !read_owner(r, json, "rank", w, CAVE_RANKS, w->rank)) return false;
    d->wall_count++;
    return true;
}

static bool read_walls(struct reader *r, const json_t *root, struct cave_displays *d) {
    const json_t *walls = json_object_get(root, "walls");
    const size_t outside = enter(r, "walls"), count = json_array_size(walls);
    if (count < 1 || count > CAVE_WALLS) return bad(r, "must be an array of 1 to %d walls", CAVE_WALLS);
    for (size_t i = 0; i < count; i++) {
        const size_t here = enter_index(r, i);
        if (!read_wall(r, json_array_get(walls, i), d)) return false;
        leave(r, here);
    }
    leave(r, outside);
    return true;
}

static bool read_devices(struct reader *r, const json_t *root, struct cave_displays *d) {
    const json_t *devices = json_object_get(root, "devices");
    const size_t outside = enter(r, "devices"), count = json_array_size(devices);
    if (devices && (!json_is_array(devices) || count < 1 || count > CAVE_DEVICES)) return bad(r, "must be an array of 1 to %d devices", CAVE_DEVICES);
    for (size_t i = 0; i < count; i++) {
        const json_t *one = json_array_get(devices, i);
        const size_t here = enter_index(r, i);
        char text[32];
        snprintf(text, sizeof text, "%lld", (long long)json_integer_value(one));
        if (json_is_integer(one) ? json_integer_value(one) < 0 : !json_is_string(one) || !*json_string_value(one))
            return bad(r, "must be the index or the name of a device ('fanal devices' lists them)");
        d->devices[d->device_count] = strdup(json_is_string(one) ? json_string_value(one) : text);
        if (!d->devices[d->device_count]) return bad(r, "memory ran out");
        d->device_count++;
        leave(r, here);
    }
    leave(r, outside);
    return true;
}

static bool read_origin(struct reader *r, const json_t *root, struct cave_displays *d) {
    static const char *const keys[] = {"position", "rotation", "scale", NULL};
    const json_t *origin = json_object_get(root, "origin");
    const size_t outside = enter(r, "origin");
    d->origin = (struct cave_place){.pose.rotation = {0, 0, 0, 1}, .scale = 1};
    if (origin) {
        /* Without a position it says how large the CAVE is, and the camera where it stands. */
        d->has_origin = json_object_get(origin, "position") != NULL;
        if (!check_keys(r, origin, keys)) return false;
        if (!d->has_origin && json_object_get(origin, "rotation")) return bad(r, "rotation needs a position");
        if (!read_vector(r, origin, "position", false, &d->origin.pose.position) || !read_rotation(r, origin, &d->origin.pose.rotation) ||
            !read_positive(r, origin, "scale", 1e-3, 1e3, &d->origin.scale))
            return false;
    }
    leave(r, outside);
    return true;
}

static bool read_root(struct reader *r, const json_t *root, struct cave_displays *d) {
    static const char *const keys[] = {"devices", "head", "ipd", "near", "origin", "walls", NULL};
    d->ipd = 0.064;
    d->near_distance = 0.05;
    return check_keys(r, root, keys) && read_devices(r, root, d) && read_walls(r, root, d) && read_head(r, root, d) && read_origin(r, root, d) &&
           read_positive(r, root, "ipd", 0, 1, &d->ipd) && read_positive(r, root, "near", 1e-4, 1e3, &d->near_distance);
}

bool cave_displays_load(const char *source, struct cave_displays *out) {
    char *read = NULL;
    const char *text = cave_displays_example(source);
    size_t size = text ? strlen(text) : 0;
    json_error_t error;
    *out = (struct cave_displays){.hash = CAVE_HASH_SEED, .source = strdup(source)};
    if (!text && loading_is_builtin(source)) {
        fprintf(stderr, "fanal: error: --displays: there is no example '%s'; there are", source);
        for (int i = 0; i < EXAMPLES; i++) fprintf(stderr, "%s builtin:%s", i ? "," : "", examples[i].name);
        fputc('\n', stderr);
        return false;
    }
    if (!text) {
        if (!read_whole(source, &read, &size)) {
            free(read);
            return false;
        }
        text = read;
    }
    out->hash = cave_hash(text, size, out->hash);
    json_t *root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &error);
    struct reader r = {.file = source};
    if (!root) fprintf(stderr, "fanal: error: %s: line %d, column %d: %s\n", source, error.line, error.column, error.text);
    const bool good = root && out->source && read_root(&r, root, out);
    json_decref(root);
    free(read);
    return good;
}

void cave_displays_free(struct cave_displays *d) {
    for (uint32_t i = 0; i < d->device_count; i++) free(d->devices[i]);
    free(d->track);
    free(d->source);
    *d = (struct cave_displays){0};
}

struct cave_pose cave_displays_head(const struct cave_displays *d, double time) {
    uint32_t after = 0;
    while (after < d->track_count && d->track[after].time <= time) after++;
    if (after == 0) return d->track[0].pose;
    if (after == d->track_count) return d->track[after - 1].pose;
    const struct cave_sample *a = &d->track[after - 1], *b = &d->track[after];
    return cave_mix(&a->pose, &b->pose, (time - a->time) / (b->time - a->time));
}
