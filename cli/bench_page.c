/* SPDX-License-Identifier: MIT */
/* report.html: the parts of bench_page/ and the charting library, which the build embeds, around the numbers. All that a reader sees is
 * made of the numbers by the page's own script. */
#include "bench.h"

#include "bench_page_parts.h"

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
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(9));
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

/* page.html has a line "@name@" where a part goes. */
char *bench_page_create(const struct bench_data *data, size_t *size) {
    struct page page = {0};
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
            append_json(&page, data->root);
        else if (strncmp(from, "@pictures@", 10) == 0)
            append_json(&page, data->pictures);
        else
            append(&page, from, (size_t)(next - from));
        from = next;
    }
    *size = page.length;
    if (!page.failed) return page.text;
    free(page.text);
    return NULL;
}
