/* SPDX-License-Identifier: MIT */
#include "headset.h"
#include "input.h"

#include "print.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- those built in ---- */

static const struct {
    const char *name, *text;
} builtins[] = {
    {"simple", "{\"name\": \"simple\", \"ipd\": 0.0635, \"resolution\": [640, 640],"
               " \"eyes\": [{\"degrees\": [-45, 45, -45, 45]}, {\"degrees\": [-45, 45, -45, 45]}]}"},
    {"asymmetric",
     "{\"name\": \"asymmetric\", \"ipd\": 0.0635, \"resolution\": [576, 640],"
     " \"eyes\": [{\"degrees\": [-52, 42, -53, 47], \"lens\": {\"center\": [-0.04, -0.02], \"red\": [0.20, 0.10], \"green\": [0.22, 0.11], \"blue\": [0.25, 0.12]},"
     " \"hidden\": [[-1.28, -1.33], [-0.7, -1.33], [-1.28, -0.75], [-1.28, 1.08], [-1.28, 0.6], [-0.8, 1.08]]},"
     " {\"degrees\": [-42, 52, -53, 47], \"lens\": {\"center\": [0.04, -0.02], \"red\": [0.20, 0.10], \"green\": [0.22, 0.11], \"blue\": [0.25, 0.12]},"
     " \"hidden\": [[1.28, -1.33], [1.28, -0.75], [0.7, -1.33], [1.28, 1.08], [0.8, 1.08], [1.28, 0.6]]}]}"},
    {"canted", "{\"name\": \"canted\", \"ipd\": 0.065, \"resolution\": [720, 640],"
               " \"eyes\": [{\"degrees\": [-55, 45, -48, 48], \"cant\": 10}, {\"degrees\": [-45, 55, -48, 48], \"cant\": 10}]}"},
};

const char *headset_builtin(uint32_t index) { return index < sizeof builtins / sizeof *builtins ? builtins[index].name : NULL; }

/* ---- reading ---- */

struct reader {
    const char *path;
    bool failed;
};

/* `place` is a JSON pointer. */
__attribute__((format(printf, 3, 4))) static bool fail(struct reader *r, const char *place, const char *format, ...) {
    if (r->failed) return false;
    r->failed = true;
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "fanal: error: --hmd: %s: %s: ", r->path, *place ? place : "/");
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return false;
}

enum { PLACE = 128 };

static const char *below(char out[PLACE], const char *place, const char *key) {
    snprintf(out, PLACE, "%.90s/%.30s", place, key);
    return out;
}

static const char *element(char out[PLACE], const char *place, size_t index) {
    snprintf(out, PLACE, "%.90s/%zu", place, index);
    return out;
}

/* Every key must be among those that are known: a misspelt one would have no effect. */
static bool check_keys(struct reader *r, const char *place, json_t *object, const char *known) {
    const char *key;
    json_t *value;
    char pattern[64], at[PLACE];
    if (!json_is_object(object)) return fail(r, place, "must be an object");
    json_object_foreach(object, key, value) {
        snprintf(pattern, sizeof pattern, " %.60s ", key);
        if (strchr(key, ' ') || !strstr(known, pattern)) return fail(r, below(at, place, key), "is not known; there are%s", known);
    }
    return true;
}

static bool read_number(struct reader *r, const char *place, json_t *value, double low, double high, float *out) {
    const double number = json_number_value(value);
    if (!json_is_number(value)) return fail(r, place, "must be a number");
    if (!(number >= low && number <= high)) return fail(r, place, "is %g, must be %g to %g", number, low, high);
    *out = (float)number;
    return true;
}

static bool read_numbers(struct reader *r, const char *place, json_t *value, size_t least, size_t most, double low, double high, float *out) {
    char at[PLACE];
    const size_t count = json_array_size(value);
    if (!json_is_array(value) || count < least || count > most)
        return least == most ? fail(r, place, "must be an array of %zu numbers", most) : fail(r, place, "must be an array of %zu to %zu numbers", least, most);
    for (size_t i = 0; i < count; i++)
        if (!read_number(r, element(at, place, i), json_array_get(value, i), low, high, &out[i])) return false;
    return true;
}

static bool read_rotation(struct reader *r, const char *place, json_t *value, fnl_vec4 *out) {
    float q[4];
    if (!read_numbers(r, place, value, 4, 4, -1.001, 1.001, q)) return false;
    const float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabsf(length - 1) < 1e-3f)) return fail(r, place, "must be a unit quaternion, has the length %g", (double)length);
    *out = (fnl_vec4){q[0] / length, q[1] / length, q[2] / length, q[3] / length};
    return true;
}

static bool read_resolution(struct reader *r, const char *place, json_t *value, struct headset_eye *out) {
    float size[2];
    if (!read_numbers(r, place, value, 2, 2, 1, 16384, size)) return false;
    if (size[0] != floorf(size[0]) || size[1] != floorf(size[1])) return fail(r, place, "must be whole numbers");
    out->width = (uint32_t)size[0];
    out->height = (uint32_t)size[1];
    return true;
}

static bool read_field(struct reader *r, const char *place, json_t *eye, fnl_eye *out) {
    char at[PLACE];
    float edges[4];
    json_t *tangents = json_object_get(eye, "tangents"), *degrees = json_object_get(eye, "degrees");
    if (!tangents == !degrees) return fail(r, place, "must have 'tangents' or 'degrees', and not both: left, right, down, up");
    below(at, place, tangents ? "tangents" : "degrees");
    const double most = tangents ? 100 : 89;
    if (!read_numbers(r, at, tangents ? tangents : degrees, 4, 4, -most, most, edges)) return false;
    for (int i = 0; i < 4 && degrees; i++) edges[i] = tanf(edges[i] * 0.017453292519943295f);
    if (!(edges[0] < edges[1])) return fail(r, at, "left must be less than right");
    if (!(edges[2] < edges[3])) return fail(r, at, "down must be less than up");
    out->left = edges[0];
    out->right = edges[1];
    out->down = edges[2];
    out->up = edges[3];
    return true;
}

static bool read_lens(struct reader *r, const char *place, json_t *lens, struct headset_lens *out) {
    static const char *const colors[] = {"red", "green", "blue"};
    char at[PLACE];
    json_t *center = json_object_get(lens, "center"), *value;
    if (!check_keys(r, place, lens, " center red green blue ")) return false;
    out->given = true;
    if (center && !read_numbers(r, below(at, place, "center"), center, 2, 2, -100, 100, &out->center.x)) return false;
    for (int c = 0; c < 3; c++) {
        if (!(value = json_object_get(lens, colors[c]))) return fail(r, place, "has no '%s'", colors[c]);
        if (!read_numbers(r, below(at, place, colors[c]), value, 1, HEADSET_LENS_TERMS, -100, 100, out->k[c])) return false;
    }
    return true;
}

static bool read_hidden(struct reader *r, const char *place, json_t *mesh, struct headset_eye *out) {
    char at[PLACE];
    const size_t count = json_array_size(mesh);
    if (!json_is_array(mesh) || count % 3 != 0 || count > HEADSET_HIDDEN_MAX)
        return fail(r, place, "must be an array of up to %d points, three for each triangle", HEADSET_HIDDEN_MAX);
    if (count == 0) return true;
    if (!(out->hidden = calloc(count, sizeof *out->hidden))) return fail(r, place, "memory ran out");
    out->hidden_count = (uint32_t)count;
    for (size_t i = 0; i < count; i++)
        if (!read_numbers(r, element(at, place, i), json_array_get(mesh, i), 2, 2, -1e4, 1e4, &out->hidden[i].x)) return false;
    return true;
}

/* `side`: -1 for the left eye, 1 for the right. `cant` turns both outwards. */
static bool read_eye(struct reader *r, const char *place, json_t *eye, float side, float ipd, struct headset_eye *out) {
    char at[PLACE];
    json_t *position = json_object_get(eye, "position"), *rotation = json_object_get(eye, "rotation"), *cant = json_object_get(eye, "cant"), *value;
    if (!check_keys(r, place, eye, " tangents degrees position rotation cant resolution lens hidden ")) return false;
    if (rotation && cant) return fail(r, place, "has 'rotation' and 'cant', which cannot be combined");
    if (position && !isnan(ipd)) return fail(r, below(at, place, "position"), "does not go with /ipd");
    if (!position && isnan(ipd)) return fail(r, place, "has no 'position', and the file no 'ipd'");
    out->eye.pose = (fnl_rigid_pose){.position = {position ? 0 : side * ipd / 2, 0, 0}, .rotation = {0, 0, 0, 1}};
    if (!read_field(r, place, eye, &out->eye)) return false;
    if (position && !read_numbers(r, below(at, place, "position"), position, 3, 3, -1, 1, &out->eye.pose.position.x)) return false;
    if (rotation && !read_rotation(r, below(at, place, "rotation"), rotation, &out->eye.pose.rotation)) return false;
    if (cant) {
        float degrees;
        if (!read_number(r, below(at, place, "cant"), cant, -45, 45, &degrees)) return false;
        const float half = -side * degrees * 0.017453292519943295f / 2;
        out->eye.pose.rotation = (fnl_vec4){0, sinf(half), 0, cosf(half)};
    }
    if ((value = json_object_get(eye, "resolution")) && !read_resolution(r, below(at, place, "resolution"), value, out)) return false;
    if ((value = json_object_get(eye, "lens")) && !read_lens(r, below(at, place, "lens"), value, &out->lens)) return false;
    return !(value = json_object_get(eye, "hidden")) || read_hidden(r, below(at, place, "hidden"), value, out);
}

static bool read_pose(struct reader *r, const char *place, json_t *pose, struct headset_pose *out) {
    char at[PLACE];
    json_t *time = json_object_get(pose, "time"), *position = json_object_get(pose, "position"), *rotation = json_object_get(pose, "rotation"),
           *gaze = json_object_get(pose, "gaze");
    if (!check_keys(r, place, pose, " time position rotation gaze ")) return false;
    *out = (struct headset_pose){.pose.rotation = {0, 0, 0, 1}, .gaze = {0, 0, -1000}};
    if (gaze && !read_numbers(r, below(at, place, "gaze"), gaze, 3, 3, -1e6, 1e6, &out->gaze.x)) return false;
    if (!json_is_number(time)) return fail(r, below(at, place, "time"), "must be a number of seconds");
    out->time = json_number_value(time);
    if (position && !read_numbers(r, below(at, place, "position"), position, 3, 3, -1e6, 1e6, &out->pose.position.x)) return false;
    return !rotation || read_rotation(r, below(at, place, "rotation"), rotation, &out->pose.rotation);
}

static bool read_poses(struct reader *r, json_t *poses, struct headset *out) {
    char at[PLACE];
    const size_t count = json_array_size(poses);
    if (!json_is_array(poses) || count > HEADSET_POSES_MAX) return fail(r, "/poses", "must be an array of up to %d poses", HEADSET_POSES_MAX);
    if (count == 0) return true;
    if (!(out->poses = calloc(count, sizeof *out->poses))) return fail(r, "/poses", "memory ran out");
    for (size_t i = 0; i < count; i++) {
        element(at, "/poses", i);
        if (!read_pose(r, at, json_array_get(poses, i), &out->poses[i])) return false;
        out->has_gaze |= json_object_get(json_array_get(poses, i), "gaze") != NULL;
        if (i > 0 && !(out->poses[i].time > out->poses[i - 1].time)) return fail(r, at, "its time must be after that of the pose before");
        out->pose_count++;
    }
    return true;
}

static bool read_all(struct reader *r, json_t *root, struct headset *out) {
    char at[PLACE];
    json_t *name = json_object_get(root, "name"), *eyes = json_object_get(root, "eyes"), *ipd = json_object_get(root, "ipd"),
           *resolution = json_object_get(root, "resolution"), *poses = json_object_get(root, "poses");
    float apart = NAN;
    if (!check_keys(r, "", root, " name ipd resolution eyes poses ")) return false;
    if (name && !json_is_string(name)) return fail(r, "/name", "must be a string");
    if (name) snprintf(out->name, sizeof out->name, "%s", json_string_value(name));
    if (ipd && !read_number(r, "/ipd", ipd, 0, 1, &apart)) return false;
    if (!json_is_array(eyes) || json_array_size(eyes) != HEADSET_EYES) return fail(r, "/eyes", "must be an array of two: left, right");
    for (int i = 0; i < HEADSET_EYES; i++) {
        if (resolution && !read_resolution(r, "/resolution", resolution, &out->eyes[i])) return false;
        if (!read_eye(r, element(at, "/eyes", (size_t)i), json_array_get(eyes, (size_t)i), i ? 1.0f : -1.0f, apart, &out->eyes[i])) return false;
    }
    if (!out->eyes[0].width != !out->eyes[1].width) return fail(r, "/eyes", "one eye has a 'resolution', the other has none");
    return !poses || read_poses(r, poses, out);
}

static json_t *load(struct reader *r, const char *path, json_error_t *error) {
    if (strncmp(path, "builtin:", 8) != 0) {
        FILE *file = input_open(path, 1 << 28);
        json_t *root = file ? json_loadf(file, JSON_REJECT_DUPLICATES, error) : NULL;
        r->failed = !file;
        if (file) fclose(file);
        return root;
    }
    for (uint32_t i = 0; headset_builtin(i); i++)
        if (strcmp(path + 8, builtins[i].name) == 0) return json_loads(builtins[i].text, 0, error);
    r->failed = true;
    fprintf(stderr, "fanal: error: --hmd: there is no '%s'; there are", path);
    for (uint32_t i = 0; headset_builtin(i); i++) fprintf(stderr, "%s builtin:%s", i ? "," : "", headset_builtin(i));
    fputc('\n', stderr);
    return NULL;
}

bool headset_load(const char *path, struct headset *out) {
    struct reader r = {.path = path};
    json_error_t error;
    *out = (struct headset){0};
    json_t *root = load(&r, path, &error);
    if (!root && !r.failed && error.line > 0) fprintf(stderr, "fanal: error: --hmd: %s:%d:%d: %s\n", path, error.line, error.column, error.text);
    if (!root && !r.failed && error.line <= 0) fprintf(stderr, "fanal: error: --hmd: %s\n", error.text);
    const bool good = root && read_all(&r, root, out);
    json_decref(root);
    if (!good) headset_free(out);
    return good;
}

void headset_free(struct headset *headset) {
    for (int i = 0; i < HEADSET_EYES; i++) free(headset->eyes[i].hidden);
    free(headset->poses);
    *headset = (struct headset){0};
}

/* ---- use ---- */

void headset_set_ipd(struct headset *headset, float ipd) {
    headset->eyes[0].eye.pose.position.x = -ipd / 2;
    headset->eyes[1].eye.pose.position.x = ipd / 2;
}

float headset_ipd(const struct headset *headset) {
    const fnl_vec3 a = headset->eyes[0].eye.pose.position, b = headset->eyes[1].eye.pose.position;
    const float d[3] = {b.x - a.x, b.y - a.y, b.z - a.z};
    return sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static fnl_vec4 turn_between(fnl_vec4 a, fnl_vec4 b, float part) {
    float cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w, from = 1 - part, to = part;
    const float sign = cosine < 0 ? -1.0f : 1.0f;
    cosine *= sign;
    if (cosine < 0.9999f) {
        const float angle = acosf(cosine), sine = sinf(angle);
        from = sinf(from * angle) / sine;
        to = sinf(to * angle) / sine;
    }
    to *= sign;
    const fnl_vec4 q = {a.x * from + b.x * to, a.y * from + b.y * to, a.z * from + b.z * to, a.w * from + b.w * to};
    const float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (fnl_vec4){q.x / length, q.y / length, q.z / length, q.w / length};
}

/* The pose before a time, the one after it, and how far between them it is: the same one before the first and after the last. */
static float find_poses(const struct headset *headset, double time, const struct headset_pose **before, const struct headset_pose **after) {
    const struct headset_pose *p = headset->poses;
    const uint32_t count = headset->pose_count;
    uint32_t next = 0;
    while (next < count && p[next].time <= time) next++;
    *before = &p[next > 0 ? next - 1 : 0];
    *after = &p[next < count ? next : count - 1];
    return *before == *after ? 0 : (float)((time - (*before)->time) / ((*after)->time - (*before)->time));
}

static fnl_vec3 between(fnl_vec3 a, fnl_vec3 b, float part) {
    return (fnl_vec3){a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part, a.z + (b.z - a.z) * part};
}

fnl_rigid_pose headset_pose_at(const struct headset *headset, double time) {
    const struct headset_pose *a, *b;
    if (headset->pose_count == 0) return (fnl_rigid_pose){.rotation = {0, 0, 0, 1}};
    const float part = find_poses(headset, time, &a, &b);
    if (a == b) return a->pose;
    return (fnl_rigid_pose){between(a->pose.position, b->pose.position, part), turn_between(a->pose.rotation, b->pose.rotation, part)};
}

fnl_vec3 headset_gaze_at(const struct headset *headset, double time) {
    const struct headset_pose *a, *b;
    if (headset->pose_count == 0) return (fnl_vec3){0, 0, -1000};
    const float part = find_poses(headset, time, &a, &b);
    return between(a->gaze, b->gaze, part);
}
