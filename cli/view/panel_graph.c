/* SPDX-License-Identifier: MIT */
/* The frame graph: passes from left to right, below them what they use, from the first use to the last, and the barriers in between. */
#include "view/view.h"

#include "print.h"
#include "view/ui.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 18, ROW = 16, GUTTER = 150 /* with the names of resources */ };
#define READ_COLOR 0x3070e0ffu
#define WRITE_COLOR 0xf09020ffu
#define BARRIER_COLOR 0xff4030ffu
#define IMAGE_COLOR 0x74b48cffu
#define BUFFER_COLOR 0x8c8cc0ffu

struct view_graph {
    char *text, *last; /* of the plan, as it was asked for now, and as it was parsed */
    size_t capacity;
    json_t *plan;     /* NULL: none */
    char pass[256];   /* chosen; "": none */
    int resource;     /* chosen; -1: none, or it is not in this plan */
    char resource_name[256];
    char filter[64];
    float column; /* width of a pass */
};

void view_graph_free(struct view_graph **graph) {
    struct view_graph *g = *graph;
    if (!g) return;
    json_decref(g->plan);
    free(g->text);
    free(g->last);
    free(g);
    *graph = NULL;
}

/* ---- the plan ---- */

static const char *text_of(const json_t *json, const char *key) {
    const char *text = json_string_value(json_object_get(json, key));
    return text ? text : "";
}
static double number_of(const json_t *json, const char *key) { return json_number_value(json_object_get(json, key)); }
static bool is_true(const json_t *json, const char *key) { return json_is_true(json_object_get(json, key)); }
static json_t *passes_of(const struct view_graph *g) { return json_object_get(g->plan, "passes"); }
static json_t *resource_at(const struct view_graph *g, size_t index) { return json_array_get(json_object_get(g->plan, "resources"), index); }
static size_t resource_of(const json_t *use) { return (size_t)json_integer_value(json_object_get(use, "resource")); }

static bool read_plan(const struct view *v, struct view_graph *g) {
    const size_t length = v->shown.renderer ? fnl_renderer_print(v->shown.renderer, FNL_PRINT_PLAN_JSON, g->text, g->capacity) : 0;
    if (length < g->capacity || length == 0) return length > 0;
    char *bigger = realloc(g->text, 2 * length);
    if (!bigger) return false;
    g->text = bigger;
    g->capacity = 2 * length;
    return fnl_renderer_print(v->shown.renderer, FNL_PRINT_PLAN_JSON, g->text, g->capacity) < g->capacity;
}

static int find_resource(const struct view_graph *g, const char *name) {
    size_t i;
    json_t *resource;
    json_array_foreach(json_object_get(g->plan, "resources"), i, resource) if (name[0] && strcmp(text_of(resource, "name"), name) == 0) return (int)i;
    return -1;
}

/* Of a pass or a resource; neither: both names are "". */
static void choose(struct view_graph *g, const char *pass, const char *resource, int index) {
    snprintf(g->pass, sizeof g->pass, "%s", pass);
    snprintf(g->resource_name, sizeof g->resource_name, "%s", resource);
    g->resource = index;
}

/* Asks for the plan of the last frame; parses it when it is another. */
static struct view_graph *update(struct view *v) {
    if (!v->timeline.graph) {
        v->timeline.graph = calloc(1, sizeof *v->timeline.graph);
        if (!v->timeline.graph) return NULL;
        v->timeline.graph->resource = -1;
        v->timeline.graph->column = 76;
    }
    struct view_graph *g = v->timeline.graph;
    if (!read_plan(v, g) || (g->last && strcmp(g->text, g->last) == 0)) return g;
    free(g->last);
    g->last = strdup(g->text);
    json_decref(g->plan);
    g->plan = json_loads(g->text, 0, NULL);
    g->resource = find_resource(g, g->resource_name);
    return g;
}

static const json_t *chosen_pass(const struct view_graph *g) {
    size_t i;
    json_t *pass;
    json_array_foreach(passes_of(g), i, pass) if (g->pass[0] && strcmp(text_of(pass, "name"), g->pass) == 0) return pass;
    return NULL;
}

static const json_t *use_of(const json_t *pass, size_t resource) {
    size_t i;
    json_t *use;
    json_array_foreach(json_object_get(pass, "uses"), i, use) if (resource_of(use) == resource) return use;
    return NULL;
}

static bool contains(const char *text, const char *part) { return !part[0] || strcasestr(text, part); }

/* What the filter asks for: a resource by its own name, or one that such a pass uses. */
static bool is_wanted(const struct view_graph *g, size_t resource) {
    size_t i;
    json_t *pass;
    if (contains(text_of(resource_at(g, resource), "name"), g->filter)) return true;
    json_array_foreach(passes_of(g), i, pass) if (contains(text_of(pass, "name"), g->filter) && use_of(pass, resource)) return true;
    return false;
}

/* ---- what the mouse is over ---- */

static const char *way_of(const json_t *use) { return is_true(use, "writes") ? is_true(use, "reads") ? "reads, writes" : "writes" : "reads"; }

static void hint_resource(const json_t *r) {
    char size[96] = "", memory[160] = "", shared[48] = "";
    const json_t *place = json_object_get(r, "memory"), *group = json_object_get(r, "alias_group");
    if (strcmp(text_of(r, "kind"), "image") == 0)
        snprintf(size, sizeof size, "%s, %.0f x %.0f, %.0f layers, %.0f mips, %.0f samples\n", text_of(r, "format"), number_of(r, "width"), number_of(r, "height"),
                 number_of(r, "layers"), number_of(r, "mips"), number_of(r, "samples"));
    if (json_is_integer(group)) snprintf(shared, sizeof shared, ", shared in group %d", (int)json_integer_value(group));
    if (json_is_object(place))
        snprintf(memory, sizeof memory, "\n%.0f bytes of memory at %.0f%s", number_of(place, "bytes"), number_of(place, "offset"), shared);
    ui_hint("%s (%s, %s)\n%s%.0f bytes, passes %.0f to %.0f%s", text_of(r, "name"), text_of(r, "kind"), text_of(r, "lifetime"), size, number_of(r, "bytes"),
            number_of(r, "first_pass"), number_of(r, "last_pass"), memory);
}

static void hint_pass(const json_t *pass, size_t index) {
    ui_hint("pass %zu: %s\n%s queue, %zu barriers before it, uses %zu resources", index, text_of(pass, "name"), text_of(pass, "queue"),
            json_array_size(json_object_get(pass, "barriers")), json_array_size(json_object_get(pass, "uses")));
}

static void hint_use(const struct view_graph *g, const json_t *pass, const json_t *use) {
    ui_hint("%s %s %s%s%s\n%s%s%s%s%s\n%s / %s", text_of(pass, "name"), way_of(use), text_of(resource_at(g, resource_of(use)), "name"),
            text_of(use, "layout")[0] ? " in " : "", text_of(use, "layout"), text_of(use, "load")[0] ? "load: " : "", text_of(use, "load"),
            text_of(use, "store")[0] ? ", store: " : "", text_of(use, "store"), "", text_of(use, "stages"), text_of(use, "access"));
}

static void hint_barrier(const json_t *barrier, const char *where, const char *pass) {
    const bool is_image = json_is_string(json_object_get(barrier, "from_layout"));
    ui_hint("barrier %s %s%s%s%s%s\n%s / %s\n-> %s / %s", where, pass, is_image ? "\n" : "\nof memory", text_of(barrier, "from_layout"),
            is_image ? " -> " : "", text_of(barrier, "to_layout"), text_of(barrier, "from_stages"), text_of(barrier, "from_access"), text_of(barrier, "to_stages"),
            text_of(barrier, "to_access"));
}

/* ---- drawing ---- */

static uint32_t dimmed(uint32_t color) { return (color & 0xffffff00) | 0x40; }

/* Images and buffers; what outlives the frame is darker. */
static uint32_t resource_color(const json_t *r) {
    const bool is_image = strcmp(text_of(r, "kind"), "image") == 0, lives = strcmp(text_of(r, "lifetime"), "transient") != 0;
    return is_image ? (lives ? 0x48785cff : IMAGE_COLOR) : (lives ? 0x5a5a84ff : BUFFER_COLOR);
}

/* Of a plan without roles: rest. */
static uint32_t role_of(const json_t *pass) {
    uint32_t role;
    return fnl_value_find(FNL_ENUM_PASS_ROLE, text_of(pass, "role"), &role) ? role : FNL_PASS_REST;
}

static void draw_passes(struct view_graph *g, const struct ui_canvas *canvas) {
    size_t i;
    json_t *pass;
    json_array_foreach(passes_of(g), i, pass) {
        const char *name = text_of(pass, "name");
        const float x = GUTTER + (float)i * g->column;
        char label[280];
        if (x > canvas->left + canvas->width || x + g->column < canvas->left) continue;
        const bool chosen = strcmp(name, g->pass) == 0, part = g->resource < 0 || use_of(pass, (size_t)g->resource);
        uint32_t color = chosen ? 0xffffffff : view_role_color(role_of(pass));
        if (!contains(name, g->filter) || !part) color = dimmed(color);
        snprintf(label, sizeof label, "pass %s", name);
        /* The heads stay in sight when the rows below are scrolled. */
        if (ui_canvas_rect(label, x, canvas->top, g->column - 1, HEAD - 2, color)) {
            hint_pass(pass, i);
            if (ui_clicked()) choose(g, chosen ? "" : name, "", -1);
        }
        if (g->column > 30) ui_canvas_text(x + 2, canvas->top + 1, g->column - 4, 0x000000ff, name);
    }
}

/* At the ends of batches. */
static void draw_last_barriers(const struct view_graph *g, size_t resource, float y, bool bright) {
    size_t i, k, m;
    json_t *batch, *barrier, *index;
    json_array_foreach(json_object_get(g->plan, "batches"), i, batch) {
        size_t last = json_array_size(passes_of(g));
        while (last > 0 && (size_t)number_of(json_array_get(passes_of(g), last - 1), "batch") != i) last--;
        json_array_foreach(json_object_get(batch, "barriers_after"), k, barrier) json_array_foreach(json_object_get(barrier, "resources"), m, index) {
            if ((size_t)json_integer_value(index) != resource) continue;
            if (ui_canvas_rect(NULL, GUTTER + (float)last * g->column - 2, y - 1, 2, ROW, bright ? BARRIER_COLOR : dimmed(BARRIER_COLOR)))
                hint_barrier(barrier, "at the end of", "the batch");
        }
    }
}

static void draw_uses(const struct view_graph *g, const struct ui_canvas *canvas, size_t resource, float y, bool bright) {
    size_t i, k;
    json_t *pass, *barrier, *index;
    json_array_foreach(passes_of(g), i, pass) {
        const float x = GUTTER + (float)i * g->column, mark = fminf(g->column - 2, 8);
        if (x > canvas->left + canvas->width || x + g->column < canvas->left) continue;
        const json_t *use = use_of(pass, resource);
        if (use) {
            const bool reads = is_true(use, "reads"), writes = is_true(use, "writes");
            bool over = false;
            if (writes) over |= ui_canvas_rect(NULL, x + 3, y + 1, mark, reads ? 5 : 10, bright ? WRITE_COLOR : dimmed(WRITE_COLOR));
            if (reads) over |= ui_canvas_rect(NULL, x + 3, y + (writes ? 6 : 1), mark, writes ? 5 : 10, bright ? READ_COLOR : dimmed(READ_COLOR));
            if (over) hint_use(g, pass, use);
        }
        json_array_foreach(json_object_get(pass, "barriers"), k, barrier) {
            size_t m;
            json_array_foreach(json_object_get(barrier, "resources"), m, index) {
                if ((size_t)json_integer_value(index) != resource) continue;
                if (ui_canvas_rect(NULL, x, y - 1, 2, ROW, bright ? BARRIER_COLOR : dimmed(BARRIER_COLOR))) hint_barrier(barrier, "before", text_of(pass, "name"));
            }
        }
    }
    draw_last_barriers(g, resource, y, bright);
}

static void draw_resources(struct view_graph *g, const struct ui_canvas *canvas, const size_t *rows, size_t count, bool dark) {
    const json_t *pass = chosen_pass(g);
    for (size_t row = 0; row < count; row++) {
        const json_t *r = resource_at(g, rows[row]);
        const float y = HEAD + (float)row * ROW, x = GUTTER + (float)number_of(r, "first_pass") * g->column;
        const float width = GUTTER + ((float)number_of(r, "last_pass") + 1) * g->column - x - 1;
        char label[280];
        if (y > canvas->top + canvas->height || y + ROW < canvas->top + HEAD) continue;
        const bool bright = pass ? use_of(pass, rows[row]) != NULL : g->resource < 0 || g->resource == (int)rows[row];
        const uint32_t color = resource_color(r);
        snprintf(label, sizeof label, "resource %s", text_of(r, "name"));
        if (ui_canvas_rect(label, x, y, width, ROW - 2, bright ? color : dimmed(color))) {
            hint_resource(r);
            if (ui_clicked() && canvas->mouse_y > canvas->top + HEAD) {
                const bool again = g->resource == (int)rows[row];
                choose(g, "", again ? "" : text_of(r, "name"), again ? -1 : (int)rows[row]);
            }
        }
        draw_uses(g, canvas, rows[row], y, bright);
        ui_canvas_rect(NULL, canvas->left, y - 1, GUTTER - 2, ROW, dark ? 0x0f0f0fff : 0xf0f0f0ff); /* over what has been scrolled below it */
        ui_canvas_text(canvas->left + 4, y - 1, GUTTER - 8, (dark ? 0xffffff00 : 0) | (bright ? 0xff : 0x70), text_of(r, "name"));
    }
}

static void show_chosen(const struct view_graph *g) {
    const json_t *pass = chosen_pass(g), *list = json_object_get(pass, "uses");
    size_t i;
    json_t *one;
    if (pass) {
        ui_text("%s, %s queue", g->pass, text_of(pass, "queue"));
        json_array_foreach(list, i, one) ui_note("%s %s %s", way_of(one), text_of(resource_at(g, resource_of(one)), "name"), text_of(one, "layout"));
        return;
    }
    if (g->resource < 0) return;
    ui_text("%s", text_of(resource_at(g, (size_t)g->resource), "name"));
    json_array_foreach(passes_of(g), i, one) {
        const json_t *use = use_of(one, (size_t)g->resource);
        if (use) ui_note("%s %s it %s", text_of(one, "name"), way_of(use), text_of(use, "layout"));
    }
}

void view_panel_graph(struct view *v) {
    struct view_graph *g = update(v);
    if (!g || !json_is_object(g->plan)) {
        ui_note("There is no frame yet.");
        return;
    }
    const size_t resource_count = json_array_size(json_object_get(g->plan, "resources")), pass_count = json_array_size(passes_of(g));
    ui_item_width(110);
    ui_input("find", g->filter, sizeof g->filter);
    ui_tooltip("Shows the resources whose name has this in it, and those that such passes use.");
    ui_same_line();
    ui_item_width(90);
    ui_number("zoom##graph", &g->column, 5, 160, "%.0f");
    ui_text("%zu %s, %zu %s, %.0f %s, %.2f MB (%.2f MB without aliasing)", pass_count, view_plural(pass_count, "pass", "passes"), resource_count,
            view_plural(resource_count, "resource", "resources"), number_of(g->plan, "barriers"), view_plural((uint64_t)number_of(g->plan, "barriers"), "barrier", "barriers"),
            number_of(g->plan, "transient_bytes") * 1e-6, number_of(g->plan, "unaliased_bytes") * 1e-6);
    size_t *rows = calloc(resource_count + 1, sizeof *rows), count = 0;
    for (size_t i = 0; rows && i < resource_count; i++)
        if (is_wanted(g, i)) rows[count++] = i;
    struct ui_canvas canvas;
    ui_canvas_begin("graph", GUTTER + (float)pass_count * g->column + 4, HEAD + (float)count * ROW + 4, fmaxf(ui_height_left() - 62, 120), &canvas);
    if (rows) draw_resources(g, &canvas, rows, count, v->settings.dark);
    draw_passes(g, &canvas);
    ui_canvas_end();
    view_show_roles();
    static const struct {
        uint32_t color;
        const char *name;
    } marks[] = {{READ_COLOR, "read"}, {WRITE_COLOR, "written"}, {BARRIER_COLOR, "barrier"}, {IMAGE_COLOR, "image"}, {BUFFER_COLOR, "buffer"}};
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++) {
        ui_same_line_if_fits(marks[i].name);
        ui_key_color(marks[i].color, marks[i].name);
    }
    show_chosen(g);
    free(rows);
}

/* ---- as text ---- */

void view_report_graph(const struct view *v, FILE *file) {
    const struct view_graph *g = v->timeline.graph;
    if (!g || !json_is_object(g->plan)) return;
    size_t i, wanted = 0;
    json_t *use;
    for (i = 0; i < json_array_size(json_object_get(g->plan, "resources")); i++) wanted += is_wanted(g, i);
    fprintf(file, "graph\t%zu\t%zu\t%.0f\nshown\t%zu\n", json_array_size(passes_of(g)), json_array_size(json_object_get(g->plan, "resources")),
            number_of(g->plan, "barriers"), wanted);
    const json_t *pass = chosen_pass(g);
    json_array_foreach(json_object_get(pass, "uses"), i, use)
        fprintf(file, "use\t%s\t%s\t%s\t%s\n", g->pass, way_of(use), text_of(resource_at(g, resource_of(use)), "name"), text_of(use, "layout"));
    if (g->resource >= 0) fprintf(file, "resource\t%s\n", text_of(resource_at(g, (size_t)g->resource), "name"));
}
