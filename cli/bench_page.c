/* SPDX-License-Identifier: MIT */
/* report.html: the parts of bench_page/ and the charting library, which the build embeds, around the numbers. All that a reader sees is
 * made of the numbers by the page's own script. */
#include "bench.h"

#include "bench_page_parts.h"
#include "json_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct page {
    char *text;
    size_t length, capacity;
    bool failed;
};

static void append(struct page *page, const char *text, size_t length) {
    if (page->length + length > page->capacity) {
        size_t capacity = page->length + length + page->capacity / 2 + 65536;
        char *bigger = page->failed ? NULL : realloc(page->text, capacity);
        if (!bigger) {
            page->failed = true;
            return;
        }
        page->text = bigger;
        page->capacity = capacity;
    }
    memcpy(page->text + page->length, text, length);
    page->length += length;
}

/* Inside a script element no '<' may stand, whatever a scene's file is called. */
static void append_json(struct page *page, const json_t *json) {
    char *text = json_text_write(json, JSON_COMPACT | JSON_REAL_PRECISION(9));
    if (!text) page->failed = true;
    for (const char *from = text; from && *from;) {
        size_t length = strcspn(from, "<");
        append(page, from, length);
        from += length;
        if (*from == '<') {
            append(page, "\\u003c", 6);
            from++;
        }
    }
    free(text);
}

/* ---- what the page is given ---- */

static void rename_scenes(const json_t *results, json_t *entries) {
    json_t *entry;
    size_t i;
    json_array_foreach(entries, i, entry) {
        const char *scene = json_string_value(json_object_get(entry, "scene"));
        char name[1024];
        if (!scene) continue;
        bench_scene_name(results, scene, name, sizeof name);
        json_object_set_new(entry, "scene", json_string(name));
        json_object_del(entry, "samples");
    }
}

/* Pages are handed around: scenes and files go by their names, folders stay at home. */
static json_t *public_root(const json_t *root) {
    static const char *const parts[] = {"skipped", "results"};
    json_t *copy = json_deep_copy(root), *settings = json_object_get(copy, "settings");
    const json_t *results = json_object_get(root, "results");
    json_object_del(copy, "command");
    for (int i = 0; i < 2; i++) rename_scenes(results, json_object_get(copy, parts[i]));
    const char *path = json_string_value(json_object_get(settings, "camera_path")), *slash = path ? strrchr(path, '/') : NULL;
    if (slash) json_object_set_new(settings, "camera_path", json_string(slash + 1));
    return copy;
}

json_t *bench_pictures_renamed(const json_t *results, const json_t *pictures, bool back) {
    json_t *renamed = json_object(), *uri;
    const char *key;
    json_object_foreach((json_t *)pictures, key, uri) {
        const json_t *result;
        size_t i, bar = 0;
        char name[1024], other[4096];
        snprintf(other, sizeof other, "%s", key);
        json_array_foreach(results, i, result) {
            const char *scene = json_string_value(json_object_get(result, "scene"));
            bench_scene_name(results, scene, name, sizeof name);
            const char *from = back ? name : scene, *to = back ? scene : name;
            size_t length = strlen(from);
            if (length < bar || strncmp(key, from, length) != 0 || key[length] != '|') continue;
            snprintf(other, sizeof other, "%s%s", to, key + length); /* the longest scene that fits */
            bar = length;
        }
        json_object_set(renamed, other, uri);
    }
    return renamed;
}

/* page.html has a line "@name@" where a part goes. */
char *bench_page_create(const struct bench_data *data, size_t *size) {
    struct page page = {0};
    json_t *root = public_root(data->root), *pictures = bench_pictures_renamed(json_object_get(data->root, "results"), data->pictures, false);
    const char *from = bench_page_html, *end = bench_page_html + bench_page_html_size;
    while (from < end) {
        const char *next = memchr(from, '\n', (size_t)(end - from));
        next = next ? next + 1 : end;
        if (strncmp(from, "@style@", 7) == 0)
            append(&page, bench_page_css, bench_page_css_size);
        else if (strncmp(from, "@chart@", 7) == 0)
            append(&page, bench_page_chart, bench_page_chart_size);
        else if (strncmp(from, "@script@", 8) == 0)
            append(&page, bench_page_js, bench_page_js_size);
        else if (strncmp(from, "@data@", 6) == 0)
            append_json(&page, root);
        else if (strncmp(from, "@pictures@", 10) == 0)
            append_json(&page, pictures);
        else
            append(&page, from, (size_t)(next - from));
        from = next;
    }
    json_decref(root);
    json_decref(pictures);
    *size = page.length;
    if (!page.failed) return page.text;
    free(page.text);
    return NULL;
}
