/* SPDX-License-Identifier: MIT */
/* What the frame did at a pixel. */
#include "view/view.h"

#include "pixel.h"
#include "print.h"
#include "view/ui.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- with the frame ---- */

void view_pixel_ask(const struct view *v, fnl_frame *frame) {
    const struct view_pick *p = &v->pick;
    /* Pinned: each frame tells it anew, but for those by which auto measures. */
    if (!p->asked && (!p->known || v->stats.choosing)) return;
    uint32_t x = p->x;
    view_compare_place(v, &x);
    if (x != p->x || p->x >= v->width || p->y >= v->height) return; /* B's side is not asked */
    frame->pixel = (fnl_pixel_query){true, (uint32_t)((uint64_t)p->x * frame->width / v->width), (uint32_t)((uint64_t)p->y * frame->height / v->height), 0};
}

void view_pixel_take(struct view *v, const fnl_frame *frame) {
    struct view_pick *p = &v->pick;
    if (p->x >= v->width || p->y >= v->height) p->known = p->asked = false;
    if (!frame->pixel.asked || fnl_renderer_query_pixel(v->shown.renderer, &p->info) != FNL_OK) return;
    if (p->info.light_count) memcpy(p->lights, p->info.lights, p->info.light_count * sizeof *p->lights);
    p->info.lights = p->lights;
    if (p->asked) view_want(v, 2); /* the panel shows it with the next one */
    p->known = true;
    p->asked = false;
}

/* ---- the panel ---- */

static void show_lights(const struct view *v, const fnl_pixel_info *p) {
    char text[160];
    const float most = p->light_count ? fmaxf(p->lights[0].luminance, 1e-30f) : 1;
    if (p->light_count == 0 || !ui_table("pixel lights", 3, 0.3f)) return;
    for (uint32_t i = 0; i < p->light_count; i++) {
        const fnl_pixel_light *l = &p->lights[i];
        ui_cell();
        if (l->index == FNL_PIXEL_NONE)
            ui_text("removed");
        else
            ui_text("%u %s", l->index, pixel_light_title(v->shown.scene, l));
        ui_cell();
        snprintf(text, sizeof text, "%.4g cd/m2", (double)l->luminance);
        ui_bar(l->luminance / most, text);
        ui_cell();
        ui_text("%.2f %s%s", (double)l->visibility, pixel_shadow_name(l->shadow), l->listed ? "" : " -");
        pixel_describe_shadow(l, text, sizeof text);
        ui_tooltip(text);
    }
    ui_table_end();
    if (p->lights_untold) ui_note("and %u more, each with no more than the last", p->lights_untold);
}

static void show_surface(const fnl_pixel_info *p) {
    ui_text("place %.4g, %.4g, %.4g m", (double)p->position.x, (double)p->position.y, (double)p->position.z);
    ui_text("depth %.4g m", (double)p->view_depth);
    ui_text("normal %.3f, %.3f, %.3f", (double)p->normal.x, (double)p->normal.y, (double)p->normal.z);
    ui_text("base color %.3f, %.3f, %.3f%s", (double)p->base_color[0], (double)p->base_color[1], (double)p->base_color[2], p->unlit ? ", unlit" : "");
    ui_text("metallic %.3f, roughness %.3f", (double)p->metallic, (double)p->roughness);
    ui_text("ambient, own %.4g %.4g %.4g cd/m2", (double)p->rest[0], (double)p->rest[1], (double)p->rest[2]);
}

void view_panel_pixel(const struct view *v) {
    const fnl_pixel_info *p = &v->pick.info;
    char text[160];
    if (!v->pick.known) {
        ui_note("Click on the picture with Ctrl held down.");
        return;
    }
    ui_text("pixel %u, %u", v->pick.x, v->pick.y);
    if (!p->hit) {
        ui_text("nothing is there");
        return;
    }
    pixel_describe_cell(p, text, sizeof text);
    ui_text("%s", text);
    ui_text("%u %s visited, %u reach it", p->lights_visited, view_plural(p->lights_visited, "light", "lights"), p->lights_reaching);
    if (p->lights_left_out) ui_note("%u that give nothing on all of the tile are not in the list", p->lights_left_out);
    ui_text("%u add %.4g %.4g %.4g cd/m2", p->lights_contributing, (double)p->lit[0], (double)p->lit[1], (double)p->lit[2]);
    if (ui_header("surface", false)) show_surface(p);
    show_lights(v, p);
}

/* ---- as text ---- */

void view_report_pixel(const struct view *v, FILE *file) {
    const fnl_pixel_info *p = &v->pick.info;
    if (!v->pick.known) return;
    fprintf(file, "pixel\t%u\t%u\t%s\t%.9g\t%.9g\t%.9g\n", v->pick.x, v->pick.y, p->hit ? "hit" : "empty", (double)p->position.x, (double)p->position.y,
            (double)p->position.z);
    if (!p->hit) return;
    fprintf(file, "pixel-normal\t%.9g\t%.9g\t%.9g\npixel-depth\t%.9g\n", (double)p->normal.x, (double)p->normal.y, (double)p->normal.z, (double)p->view_depth);
    fprintf(file, "pixel-color\t%.9g\t%.9g\t%.9g\npixel-metallic\t%.9g\npixel-roughness\t%.9g\n", (double)p->base_color[0], (double)p->base_color[1],
            (double)p->base_color[2], (double)p->metallic, (double)p->roughness);
    if (p->has_list && p->cell != FNL_PIXEL_NONE)
        fprintf(file, "pixel-cell\t%u\t%u\t%u\t%u\n", p->cell, p->cell_place[0], p->cell_place[1], p->cell_place[2]);
    fprintf(file, "pixel-visited\t%u\npixel-reaching\t%u\npixel-contributing\t%u\npixel-left-out\t%u\n", p->lights_visited, p->lights_reaching,
            p->lights_contributing, p->lights_left_out);
    fprintf(file, "pixel-lit\t%.9g\t%.9g\t%.9g\npixel-rest\t%.9g\t%.9g\t%.9g\n", (double)p->lit[0], (double)p->lit[1], (double)p->lit[2], (double)p->rest[0],
            (double)p->rest[1], (double)p->rest[2]);
    for (uint32_t i = 0; i < p->light_count; i++) {
        const fnl_pixel_light *l = &p->lights[i];
        char text[160];
        pixel_describe_shadow(l, text, sizeof text);
        fprintf(file, "pixel-light\t%d\t%s\t%.9g\t%.9g\t%s\n", l->index == FNL_PIXEL_NONE ? -1 : (int)l->index, pixel_light_name(v->shown.scene, l),
                (double)l->luminance, (double)l->visibility, text);
    }
}
