/* SPDX-License-Identifier: MIT */
/* The panels of the window: the scene, the options of the frame, what it costs, and messages. */
#include "view/view.h"

#include "options.h"
#include "view/ui.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- options: a widget for each row of the table ---- */

static bool matches(const char *text, const char *filter) {
    const size_t length = strlen(filter);
    for (; *text; text++)
        if (strncasecmp(text, filter, length) == 0) return true;
    return length == 0;
}

static bool set(struct view *v, const char *key, const char *value) {
    view_want(v, 2);
    if (strcmp(key, "shadows") == 0) v->own_shadows = true;
    return fnl_frame_set(&v->host, &v->frame, key, value) == FNL_OK;
}

static void show_names(struct view *v, const fnl_option *o, const char *value) {
    const char *name;
    if (!ui_combo(o->key, value)) return;
    for (uint32_t i = 0; (name = fnl_value_name(o->names, i)); i++) {
        const char *help = fnl_value_help(o->names, i);
        if (ui_choice(name, strcmp(name, value) == 0)) set(v, o->key, name);
        if (help) ui_tooltip(help);
    }
    ui_combo_end();
}

static void show_choices(struct view *v, const fnl_option *o, const char *value) {
    char text[16];
    if (!ui_combo(o->key, value)) return;
    for (uint32_t i = 0; i < o->choice_count; i++) {
        snprintf(text, sizeof text, "%u", o->choices[i]);
        if (ui_choice(text, strcmp(text, value) == 0)) set(v, o->key, text);
    }
    ui_combo_end();
}

/* Powers of two and multiples go in steps of what is allowed. */
static uint32_t nearest_count(const fnl_option *o, uint32_t wanted, uint32_t before) {
    double value = wanted;
    if (o->power_of_two) {
        value = before;
        if (wanted > before) value *= 2;
        if (wanted < before) value /= 2;
    } else if (o->multiple > 1) {
        value = round(value / o->multiple) * o->multiple;
        if (value == before && wanted != before) value += wanted > before ? o->multiple : -(double)o->multiple;
    }
    return (uint32_t)fmax(o->low, fmin(o->high, value));
}

static void show_option(struct view *v, const fnl_option *o) {
    char value[64], usual[64], text[64], help[1024], range[256];
    fnl_frame_get(&v->frame, o->key, value, sizeof value);
    fnl_frame_get(&v->usual, o->key, usual, sizeof usual);
    ui_item_width(150);
    if (o->kind == FNL_OPTION_SWITCH) {
        bool on = strcmp(value, "on") == 0;
        if (ui_checkbox(o->key, &on)) set(v, o->key, on ? "on" : "off");
    } else if (o->kind == FNL_OPTION_NAME) {
        show_names(v, o, value);
    } else if (o->choice_count > 0) {
        show_choices(v, o, value);
    } else if (o->kind == FNL_OPTION_COUNT) {
        const uint32_t before = (uint32_t)strtoul(value, NULL, 10);
        uint32_t count = before;
        if (ui_count(o->key, &count, (uint32_t)o->low, (uint32_t)fmin(o->high, 4294967295.0))) {
            snprintf(text, sizeof text, "%u", nearest_count(o, count, before));
            set(v, o->key, text);
        }
    } else {
        float number = strtof(value, NULL);
        const bool is_auto = o->has_auto && strcmp(value, "auto") == 0;
        if (is_auto) number = (float)o->low;
        if (ui_number(o->key, &number, (float)o->low, (float)o->high, is_auto ? "auto" : "%.4g")) {
            snprintf(text, sizeof text, "%.9g", (double)number);
            set(v, o->key, text);
        }
    }
    options_print_range(o, range, sizeof range);
    snprintf(help, sizeof help, "%s\n%s\n%s", o->help, range, o->exact ? "The picture stays the same." : "");
    ui_tooltip(help);
    const bool unused = (v->frame.shading != FNL_SHADING_AUTO && !(o->shadings >> v->frame.shading & 1)) ||
                        (v->frame.lists != FNL_LISTS_AUTO && !(o->lists >> v->frame.lists & 1));
    if (unused) {
        ui_same_line();
        ui_text("(no effect)");
    }
    if (strcmp(value, usual) == 0) return;
    ui_same_line();
    snprintf(text, sizeof text, "reset##%s", o->key);
    if (ui_button(text)) set(v, o->key, usual);
}

/* What stands before the first dot of a key; of plain keys "frame". */
static void group_of(const fnl_option *o, char group[32]) {
    const char *dot = strchr(o->key, '.');
    snprintf(group, 32, "%.*s", dot ? (int)(dot - o->key) : 5, dot ? o->key : "frame");
}

static bool is_shown(const struct view *v, const fnl_option *o) {
    if (strcmp(o->key, "width") == 0 || strcmp(o->key, "height") == 0) return false; /* the window's */
    return matches(o->key, v->filter) || matches(o->help, v->filter);
}

/* The group, with all that belongs to it wherever it stands in the table. */
static void show_group(struct view *v, const char *group) {
    char label[48], own[32];
    bool open = true, begun = false;
    fnl_option o;
    for (uint32_t i = 0; open && fnl_option_query(i, &o); i++) {
        group_of(&o, own);
        if (strcmp(own, group) != 0 || !is_shown(v, &o)) continue;
        snprintf(label, sizeof label, "%.31s##options", group);
        if (!begun && !v->filter[0]) open = ui_header(label, strcmp(group, "frame") == 0);
        begun = true;
        if (open) show_option(v, &o);
    }
}

static void show_options(struct view *v) {
    char groups[32][32];
    uint32_t count = 0;
    fnl_option o;
    ui_item_width(-60);
    ui_input("filter", v->filter, sizeof v->filter);
    ui_tooltip("Shows the options whose name or description has this in it.");
    for (uint32_t i = 0; fnl_option_query(i, &o) && count < 32; i++) {
        uint32_t at = 0;
        group_of(&o, groups[count]);
        while (strcmp(groups[at], groups[count]) != 0) at++;
        if (at == count) count++;
    }
    for (uint32_t i = 0; i < count; i++) show_group(v, groups[i]);
}

/* ---- the scene ---- */

static void show_cameras(struct view *v) {
    fnl_entity_info info;
    char label[96];
    const uint32_t count = fnl_scene_count(v->shown.scene, FNL_ENTITY_CAMERA);
    if (ui_button("frame all")) view_frame_all(v);
    ui_tooltip("F");
    if (count == 0) return;
    ui_same_line();
    ui_item_width(150);
    if (!ui_combo("camera", "of the scene")) return;
    for (uint32_t i = 0; i < count; i++) {
        const bool named = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_CAMERA, i, &info) == FNL_OK && info.name && info.name[0];
        snprintf(label, sizeof label, "%s##%u", named ? info.name : "without a name", i);
        if (ui_choice(label, false)) {
            fnl_scene_query_camera(v->shown.scene, i, &v->camera.now);
            view_want(v, 2);
        }
    }
    ui_combo_end();
}

static void show_animation(struct view *v) {
    fnl_animation_info info;
    float time = (float)v->time, speed = (float)v->speed;
    if (v->shown.info.animation_count == 0 || fnl_scene_query_animation(v->shown.scene, v->animation, &info) != FNL_OK) return;
    if (ui_button(v->plays ? "pause" : "play")) v->plays = !v->plays;
    ui_tooltip("Space");
    ui_same_line();
    ui_item_width(150);
    if (ui_number("seconds", &time, 0, (float)fmax(info.duration, 1e-3), "%.2f")) view_set_time(v, (double)time);
    ui_item_width(150);
    if (ui_number("speed", &speed, 0, 4, "%.2f")) v->speed = (double)speed;
    if (v->shown.info.animation_count < 2) return;
    ui_item_width(150);
    if (!ui_combo("animation", info.name ? info.name : "without a name")) return;
    for (uint32_t i = 0; i < v->shown.info.animation_count; i++) {
        char label[96];
        fnl_scene_query_animation(v->shown.scene, i, &info);
        snprintf(label, sizeof label, "%s##%u", info.name ? info.name : "without a name", i);
        if (!ui_choice(label, i == v->animation)) continue;
        v->animation = i;
        view_set_time(v, 0);
    }
    ui_combo_end();
}

static void show_variants(struct view *v) {
    fnl_entity_info info;
    char label[96];
    if (v->shown.info.variant_count == 0) return;
    ui_item_width(150);
    if (!ui_combo("variant", "choose")) return;
    if (ui_choice("none", false)) fnl_scene_select_variant(v->shown.scene, FNL_NO_VARIANT);
    for (uint32_t i = 0; i < v->shown.info.variant_count; i++) {
        const bool known = fnl_scene_query_entity(v->shown.scene, FNL_ENTITY_VARIANT, i, &info) == FNL_OK;
        snprintf(label, sizeof label, "%s##%u", known && info.name ? info.name : "without a name", i);
        if (ui_choice(label, false)) fnl_scene_select_variant(v->shown.scene, i);
    }
    view_want(v, 2);
    ui_combo_end();
}

static void show_exposure(struct view *v) {
    bool metered = v->frame.exposure == FNL_EXPOSURE_AUTO;
    if (ui_checkbox("exposure from the picture", &metered)) {
        v->frame.exposure = metered ? FNL_EXPOSURE_AUTO : FNL_EXPOSURE_EV;
        v->frame.ev = v->stats.ev;
        view_want(v, 2);
    }
    if (metered) return;
    ui_item_width(150);
    if (ui_number("EV100", &v->frame.ev, -10, 20, "%.2f")) view_want(v, 2);
}

static void show_scene(struct view *v) {
    const fnl_scene_info *info = &v->shown.info;
    ui_note("%s", v->shown.source ? v->shown.source : "Drop a glTF file here.");
    if (v->loader.running) ui_bar((float)atomic_load(&v->loader.progress) / 1000, "loading");
    if (!v->shown.scene) return;
    ui_text("%llu triangles, %llu instances, %u materials", (unsigned long long)info->triangle_count, (unsigned long long)info->instance_count,
            info->material_count);
    show_cameras(v);
    show_animation(v);
    show_variants(v);
    show_exposure(v);
    ui_item_width(-60);
    ui_input("##path", v->save_path, sizeof v->save_path);
    ui_same_line();
    if (ui_button("save")) view_save_picture(v, v->save_path);
    ui_tooltip("Saves the picture at the window's size, as 'fanal render' would make it: .png or .exr (P)");
    if (ui_button("print the command")) view_print_command(v, stdout);
    ui_tooltip("Writes to the terminal which 'fanal render' makes this picture");
    if (ui_header("lights", true)) view_panel_lights(v);
}

/* ---- what the frame costs ---- */

static void show_passes(const struct view *v, double most) {
    char text[96];
    if (!ui_table("passes", 2, 0.62f)) return;
    for (uint32_t i = 0; i < v->pass_count; i++) {
        if (v->passes[i].milliseconds < 0.005 * most) continue;
        ui_cell();
        ui_text("%s", v->passes[i].name);
        ui_tooltip(v->passes[i].name);
        ui_cell();
        snprintf(text, sizeof text, "%.2f ms", v->passes[i].milliseconds);
        ui_bar((float)(v->passes[i].milliseconds / most), text);
    }
    ui_table_end();
}

static void show_costs(const struct view *v) {
    const fnl_frame_stats *s = &v->stats;
    double most = 1e-3;
    float highest = 1;
    for (uint32_t i = 0; i < v->pass_count; i++) most = fmax(most, v->passes[i].milliseconds);
    for (uint32_t i = 0; i < VIEW_HISTORY; i++) highest = fmaxf(highest, v->history[i]);
    ui_text("%.1f ms in passes, %.1f ms from end to end, %.2f ms to record", s->gpu_milliseconds, v->frame_seconds * 1e3, s->cpu_milliseconds);
    ui_plot("##history", v->history, VIEW_HISTORY, v->history_at, highest, 50);
    ui_tooltip("Milliseconds of the last frames");
    ui_text("%s, lists %s%s", fnl_value_name(FNL_ENUM_SHADING, s->shading), fnl_value_name(FNL_ENUM_LISTS, s->lists), s->choosing ? " (choosing)" : "");
    if (s->choice && s->choice[0]) ui_note("%s", s->choice);
    ui_text("%.1f MB on the device, %u draws, %llu of %llu objects", (double)s->device_bytes / 1e6, s->draws, (unsigned long long)s->items_visible,
            (unsigned long long)s->items);
    ui_text("%u of %u lights in view, %llu list entries", s->lights_in_view, s->lights_total, (unsigned long long)s->list_entries);
    if (ui_header("passes", true)) show_passes(v, most);
    if (!ui_header("counters", false) || !ui_table("counters", 2, 0.62f)) return;
    for (uint32_t i = 0; i < s->counter_count; i++) {
        ui_cell();
        ui_text("%s", s->counters[i].key);
        ui_tooltip(s->counters[i].help);
        ui_cell();
        ui_text("%llu %s", (unsigned long long)s->counters[i].value, s->counters[i].unit);
    }
    ui_table_end();
}

/* ---- a pixel ---- */

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

static void show_pixel(const struct view *v) {
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

/* ---- all of them ---- */

static void show_messages(struct view *v) {
    pthread_mutex_lock(&v->messages.mutex);
    const uint32_t count = v->messages.count, first = count > VIEW_MESSAGES ? count - VIEW_MESSAGES : 0;
    for (uint32_t i = count; i-- > first;) {
        const char *text = v->messages.lines[i % VIEW_MESSAGES].text;
        if (v->messages.lines[i % VIEW_MESSAGES].level >= FNL_LOG_WARNING)
            ui_warning("%s", text);
        else
            ui_note("%s", text);
    }
    pthread_mutex_unlock(&v->messages.mutex);
}

static void show_help(struct view *v) {
    if (ui_window("Keys", &v->shows_help, 420, 120, 420, 330)) {
        static const char *const rows[][2] = {{"left mouse", "orbit"},
                                              {"right mouse", "look around"},
                                              {"middle mouse, or Shift and left", "move sideways"},
                                              {"wheel", "closer, farther"},
                                              {"W A S D Q E", "fly; Shift: faster"},
                                              {"Ctrl and left mouse", "what is at this pixel"},
                                              {"F", "see the whole scene"},
                                              {"Space", "play, pause"},
                                              {"P", "save the picture"},
                                              {"Tab", "hide the panels"},
                                              {"F1", "this list"},
                                              {"Ctrl and Q", "quit"}};
        if (ui_table("keys", 2, 0.55f)) {
            for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
                ui_cell();
                ui_text("%s", rows[i][0]);
                ui_cell();
                ui_text("%s", rows[i][1]);
            }
            ui_table_end();
        }
    }
    ui_window_end();
}

void view_panels(struct view *v) {
    if (v->hides_panels) return;
    const float high = (float)v->height / v->scale, wide = (float)v->width / v->scale;
    if (ui_window("Scene", NULL, 8, 8, 340, high * 0.42f)) show_scene(v);
    ui_window_end();
    if (ui_window("Options", NULL, 8, 16 + high * 0.42f, 340, high * 0.58f - 24)) show_options(v);
    ui_window_end();
    if (ui_window("Frame", NULL, wide - 348, 8, 340, high * 0.55f)) show_costs(v);
    ui_window_end();
    if (ui_window("Pixel", NULL, wide - 348, 16 + high * 0.55f, 340, high * 0.2f)) show_pixel(v);
    ui_window_end();
    if (ui_window("Messages", NULL, wide - 348, 24 + high * 0.75f, 340, high * 0.25f - 32)) show_messages(v);
    ui_window_end();
    if (v->shows_help) show_help(v);
}

/* ---- as text ---- */

bool view_write_report(const struct view *v, const char *path) {
    FILE *file = fopen(path, "w");
    if (!file) {
        fprintf(stderr, "fanal: error: %s: cannot be written\n", path);
        return false;
    }
    const fnl_frame_stats *s = &v->stats;
    fprintf(file, "scene\t%s\ntriangles\t%llu\nlights\t%u\nframes\t%llu\n", v->shown.source ? v->shown.source : "",
            (unsigned long long)v->shown.info.triangle_count, v->shown.info.light_count, (unsigned long long)v->frames_drawn);
    fprintf(file, "shading\t%s\nlists\t%s\npasses_ms\t%.4f\n", fnl_value_name(FNL_ENUM_SHADING, s->shading), fnl_value_name(FNL_ENUM_LISTS, s->lists),
            s->gpu_milliseconds);
    for (uint32_t i = 0; i < v->pass_count; i++) fprintf(file, "pass\t%s\t%.4f\n", v->passes[i].name, v->passes[i].milliseconds);
    for (uint32_t i = 0; i < s->counter_count; i++) fprintf(file, "counter\t%s\t%llu\n", s->counters[i].key, (unsigned long long)s->counters[i].value);
    if (v->pick.known)
        fprintf(file, "pixel\t%u\t%u\t%s\t%.9g\t%.9g\t%.9g\n", v->pick.x, v->pick.y, v->pick.hit ? "hit" : "empty", (double)v->pick.position.x,
                (double)v->pick.position.y, (double)v->pick.position.z);
    const uint32_t count = v->messages.count, first = count > VIEW_MESSAGES ? count - VIEW_MESSAGES : 0;
    for (uint32_t i = first; i < count; i++) fprintf(file, "message\t%s\n", v->messages.lines[i % VIEW_MESSAGES].text);
    return fclose(file) == 0;
}

void view_print_command(const struct view *v, FILE *file) {
    const fnl_camera *c = &v->camera.now;
    fnl_option o;
    char value[64], usual[64];
    const fnl_frame frame = fnl_frame_default();
    fprintf(file, "fanal render '%s' --size %ux%u --eye %.9g,%.9g,%.9g --look-at %.9g,%.9g,%.9g --fov %.17g --near %.9g", v->shown.source, v->width, v->height,
            (double)c->position.x, (double)c->position.y, (double)c->position.z, (double)c->target.x, (double)c->target.y, (double)c->target.z,
            (double)c->vertical_fov * (180 / 3.14159265358979323846), (double)c->near_distance);
    if (c->up.x != 0 || c->up.y != 1 || c->up.z != 0) fprintf(file, " --up %.9g,%.9g,%.9g", (double)c->up.x, (double)c->up.y, (double)c->up.z);
    if (v->time > 0) fprintf(file, " --time %.9g --animation %u", v->time, v->animation);
    for (uint32_t i = 0; fnl_option_query(i, &o); i++) {
        fnl_frame_get(&v->frame, o.key, value, sizeof value);
        fnl_frame_get(&frame, o.key, usual, sizeof usual);
        if (strcmp(o.key, "width") != 0 && strcmp(o.key, "height") != 0 && (strcmp(o.key, "shadows") == 0 || strcmp(value, usual) != 0)) fprintf(file, " --set %s=%s", o.key, value);
    }
    fputs(" -o picture.png\n", file);
    if (v->shown.changed) fputs("# without the lights that were changed in the window\n", file);
    fflush(file);
}
