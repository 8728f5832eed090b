/* SPDX-License-Identifier: MIT */
#include "pixel.h"

#include "arguments.h"
#include "json_text.h"
#include "origin.h"
#include "print.h"

#include <stdio.h>
#include <string.h>

const char *pixel_shadow_name(fnl_pixel_shadow shadow) {
    static const char *const names[FNL_PIXEL_SHADOW_COUNT] = {"none", "behind", "map", "rays", "cubemap"};
    return (unsigned)shadow < FNL_PIXEL_SHADOW_COUNT ? names[shadow] : "";
}

const char *pixel_light_name(const fnl_scene *scene, const fnl_pixel_light *light) {
    fnl_entity_info info;
    if (light->index == FNL_PIXEL_NONE || light->index >= fnl_scene_count(scene, FNL_ENTITY_LIGHT)) return "";
    return fnl_scene_query_entity(scene, FNL_ENTITY_LIGHT, light->index, &info) == FNL_OK && info.name ? info.name : "";
}

const char *pixel_light_title(const fnl_scene *scene, const fnl_pixel_light *light) {
    fnl_light_params params;
    const char *name = pixel_light_name(scene, light);
    if (*name || light->index == FNL_PIXEL_NONE || light->index >= fnl_scene_count(scene, FNL_ENTITY_LIGHT)) return name;
    return fnl_scene_query_light(scene, light->index, &params) == FNL_OK ? fnl_value_name(FNL_ENUM_LIGHT_KIND, params.kind) : "";
}

void pixel_describe_shadow(const fnl_pixel_light *light, char *text, size_t capacity) {
    if (light->shadow == FNL_PIXEL_SHADOW_MAP)
        snprintf(text, capacity, "map: face %u, level %u, page %u %u, at %u %u of the atlas", light->shadow_face, light->shadow_level, light->shadow_page[0],
                 light->shadow_page[1], light->shadow_atlas[0], light->shadow_atlas[1]);
    else
        snprintf(text, capacity, "%s", pixel_shadow_name(light->shadow));
}

void pixel_describe_cell(const fnl_pixel_info *p, char *text, size_t capacity) {
    if (!p->has_list)
        snprintf(text, capacity, "no list: the volumes of lights are drawn");
    else if (p->cell == FNL_PIXEL_NONE)
        snprintf(text, capacity, "all lights%s", p->unserved ? " (no cell serves it)" : "");
    else
        snprintf(text, capacity, "cell %u at %u, %u, %u%s", p->cell, p->cell_place[0], p->cell_place[1], p->cell_place[2],
                 p->unserved ? " (which does not serve it)" : "");
}

void pixel_print(const fnl_scene *scene, const fnl_pixel_info *p) {
    char text[160];
    printf("pixel %u, %u", p->query.x, p->query.y);
    if (p->query.view) printf(" of view %u", p->query.view);
    if (!p->hit) {
        puts(": nothing is there");
        return;
    }
    double at[3];
    origin_place(scene, p->position, at);
    const int digits = origin_digits(scene) > 9 ? 12 : 6;
    printf(": at %.*g %.*g %.*g, %.6g m deep\n", digits, at[0], digits, at[1], digits, at[2], (double)p->view_depth);
    printf("  normal %.4f %.4f %.4f; base colour %.4f %.4f %.4f%s, metallic %.3f, roughness %.3f\n", (double)p->normal.x, (double)p->normal.y,
           (double)p->normal.z, (double)p->base_color[0], (double)p->base_color[1], (double)p->base_color[2], p->unlit ? " (unlit)" : "", (double)p->metallic,
           (double)p->roughness);
    pixel_describe_cell(p, text, sizeof text);
    printf("  %s; %u lights visited, %u reach the surface, %u add light", text, p->lights_visited, p->lights_reaching, p->lights_contributing);
    if (p->lights_left_out) printf("; %u that give nothing on all of the tile are not in the list", p->lights_left_out);
    printf("\n  cd/m^2, RGB: %.6g %.6g %.6g of lights, %.6g %.6g %.6g ambient and its own\n", (double)p->lit[0], (double)p->lit[1], (double)p->lit[2],
           (double)p->rest[0], (double)p->rest[1], (double)p->rest[2]);
    if (p->light_count == 0) return;
    const double all = 0.2126 * (double)p->lit[0] + 0.7152 * (double)p->lit[1] + 0.0722 * (double)p->lit[2];
    printf("\n  %7s %-20s %10s %6s %6s  %s\n", "light", "", "cd/m^2", "of all", "seen", "shadow");
    for (uint32_t i = 0; i < p->light_count; i++) {
        const fnl_pixel_light *l = &p->lights[i];
        char index[16] = "gone";
        if (l->index != FNL_PIXEL_NONE) snprintf(index, sizeof index, "%u", l->index);
        pixel_describe_shadow(l, text, sizeof text);
        printf("  %7s %-20.20s %10.4g %5.1f%% %6.2f  %s%s\n", index, pixel_light_title(scene, l), (double)l->luminance,
               all > 0 ? 100 * (double)l->luminance / all : 0, (double)l->visibility, text, l->listed ? "" : ", not in the list");
    }
    if (p->lights_untold) printf("  and %u more, each with no more than the last of these\n", p->lights_untold);
}

/* ---- JSON ---- */

static json_t *rgb(const float v[3]) { return json_pack("[f,f,f]", (double)v[0], (double)v[1], (double)v[2]); }
static json_t *place(fnl_vec3 v) { return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z); }
static json_t *index_or_null(uint32_t index) { return index == FNL_PIXEL_NONE ? json_null() : json_integer(index); }

static json_t *light_json(const fnl_scene *scene, const fnl_pixel_light *l) {
    json_t *map = json_null();
    if (l->shadow == FNL_PIXEL_SHADOW_MAP)
        map = json_pack("{s:i,s:i,s:[i,i],s:[i,i]}", "face", (int)l->shadow_face, "level", (int)l->shadow_level, "page", (int)l->shadow_page[0],
                        (int)l->shadow_page[1], "atlas", (int)l->shadow_atlas[0], (int)l->shadow_atlas[1]);
    return json_pack("{s:o,s:o,s:b,s:b,s:o,s:f,s:f,s:s,s:o}", "light", index_or_null(l->index), "name", json_text(pixel_light_name(scene, l)), "directional",
                     l->directional, "listed", l->listed, "radiance", rgb(l->radiance), "luminance", (double)l->luminance, "visibility", (double)l->visibility,
                     "shadow", pixel_shadow_name(l->shadow), "map", map);
}

json_t *pixel_json(const fnl_scene *scene, const fnl_pixel_info *p) {
    if (!p->query.asked) return json_null();
    json_t *json = json_pack("{s:i,s:i,s:i,s:b}", "x", (int)p->query.x, "y", (int)p->query.y, "view", (int)p->query.view, "hit", p->hit);
    json_t *lights = json_array();
    for (uint32_t i = 0; i < p->light_count; i++) json_array_append_new(lights, light_json(scene, &p->lights[i]));
    json_object_set_new(json, "position", origin_json(scene, p->position));
    json_object_set_new(json, "normal", place(p->normal));
    json_object_set_new(json, "view_depth", json_real((double)p->view_depth));
    json_object_set_new(json, "base_color", rgb(p->base_color));
    json_object_set_new(json, "metallic", json_real((double)p->metallic));
    json_object_set_new(json, "roughness", json_real((double)p->roughness));
    json_object_set_new(json, "cell", p->hit && p->has_list ? index_or_null(p->cell) : json_null());
    json_object_set_new(json, "cell_place", json_pack("[i,i,i]", (int)p->cell_place[0], (int)p->cell_place[1], (int)p->cell_place[2]));
    json_object_set_new(json, "unserved", json_boolean(p->unserved));
    json_object_set_new(json, "lights_visited", json_integer(p->lights_visited));
    json_object_set_new(json, "lights_reaching", json_integer(p->lights_reaching));
    json_object_set_new(json, "lights_left_out", json_integer(p->lights_left_out));
    json_object_set_new(json, "lights_contributing", json_integer(p->lights_contributing));
    json_object_set_new(json, "lights_untold", json_integer(p->lights_untold));
    json_object_set_new(json, "lit", rgb(p->lit));
    json_object_set_new(json, "rest", rgb(p->rest));
    json_object_set_new(json, "lights", lights);
    return json;
}

/* ---- arguments ---- */

bool pixel_parse(const char *option, const char *text, fnl_pixel_query *out) {
    char copy[64];
    long long values[3] = {0};
    int count = 0;
    const char *wanted = "a pixel, such as 320,200";
    if (strlen(text) >= sizeof copy || text[strspn(text, "0123456789,")]) return argument_bad(option, text, wanted);
    strcpy(copy, text);
    for (char *part = copy, *comma; part; part = comma) {
        comma = strchr(part, ',');
        if (comma) *comma++ = 0;
        if (count == 3 || !*part) return argument_bad(option, text, wanted);
        if (!argument_integer(option, part, 0, 65535, &values[count++])) return false;
    }
    if (count < 2) return argument_bad(option, text, wanted);
    *out = (fnl_pixel_query){true, (uint32_t)values[0], (uint32_t)values[1], (uint32_t)values[2]};
    return true;
}
