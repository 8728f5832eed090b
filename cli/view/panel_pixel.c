/* SPDX-License-Identifier: MIT */
/* What is at a pixel. */
#include "view/view.h"

#include "view/ui.h"

#include <math.h>
#include <stdlib.h>

struct near_light {
    uint32_t index;
    float part; /* of the light at the point, without what is in between: candela over metres squared */
};
static int by_part(const void *a, const void *b) {
    const float x = ((const struct near_light *)a)->part, y = ((const struct near_light *)b)->part;
    return (x < y) - (x > y);
}

static void show_pixel_lights(const struct view *v) {
    struct near_light near[16];
    uint32_t count = 0, total = 0;
    for (uint32_t i = 0; i < fnl_scene_count(v->shown.scene, FNL_ENTITY_LIGHT); i++) {
        fnl_light_params light;
        if (fnl_scene_query_light(v->shown.scene, i, &light) != FNL_OK || light.kind == FNL_LIGHT_DIRECTIONAL || light.kind == FNL_LIGHT_BOX) continue;
        const fnl_vec3 p = v->pick.position, l = light.position;
        const float squared = (p.x - l.x) * (p.x - l.x) + (p.y - l.y) * (p.y - l.y) + (p.z - l.z) * (p.z - l.z);
        const float range = isinf(light.range) ? fnl_light_range(&light, 1, 0.05f) : light.range;
        if (squared > range * range) continue;
        total++;
        struct near_light own = {i, light.intensity / fmaxf(squared, 1e-4f)};
        if (count == 16 && near[15].part >= own.part) continue;
        near[count < 16 ? count++ : 15] = own;
        qsort(near, count, sizeof *near, by_part);
    }
    ui_text("%u lights reach it; the strongest:", total);
    for (uint32_t i = 0; i < count; i++) {
        fnl_entity_info info;
        const bool named = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_LIGHT, near[i].index, &info) == FNL_OK && info.name && info.name[0];
        ui_text("  %u %s: %.4g lux", near[i].index, named ? info.name : "", (double)near[i].part);
    }
}

void view_panel_pixel(const struct view *v) {
    const struct view_pick *p = &v->pick;
    if (!p->known) {
        ui_note("Click on the picture with Ctrl held down.");
        return;
    }
    ui_text("pixel %u, %u", p->x, p->y);
    if (!p->hit) {
        ui_text("nothing is there");
        return;
    }
    ui_text("place %.4g, %.4g, %.4g m", (double)p->position.x, (double)p->position.y, (double)p->position.z);
    ui_text("depth %.4g m", (double)p->depth);
    ui_text("normal %.3f, %.3f, %.3f", (double)p->normal.x, (double)p->normal.y, (double)p->normal.z);
    ui_text("base colour %.3f, %.3f, %.3f", (double)p->color.x, (double)p->color.y, (double)p->color.z);
    ui_text("roughness %.3f", (double)p->roughness);
    show_pixel_lights(v);
}
