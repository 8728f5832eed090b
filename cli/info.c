/* SPDX-License-Identifier: MIT */
/* fanal info: what a scene consists of. */
#include "info.h"

#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "json_text.h"
#include "loading.h"
#include "origin.h"
#include "print.h"

#include "fanal/scene.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_GOOD = 0, EXIT_ERROR = 2 };

static void print_help(void) {
    puts("Usage: fanal info [OPTIONS] SCENE\n"
         "       fanal info --gbuffers [--size WxH] [--samples N] [--fps N]\n"
         "\n"
         "Prints what a scene consists of: counts, extent, images, lights, cameras, animations, variants of materials, the names of\n"
         "nodes, meshes and materials, metadata, the extensions it uses and how each is treated, and what is wrong with it. SCENE is a .gltf or .glb file\n"
         "or builtin:NAME?key=value&...\n"
         "\n"
         "  --json                     prints JSON\n" LOADING_VARIANT_HELP LOADING_HELP
         "  --gbuffers                 prints the layouts of the G-buffer instead: fields, bits, bytes, bandwidth\n"
         "  --size WxH                 at this size (1920x1080)\n"
         "  --samples N                with so many samples a pixel: 1 to 64 (1)\n"
         "  --fps N                    at so many frames a second (30)\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "Exit status: 0 when the scene was loaded (with or without warnings), 2 on an error.\n"
         "\n"
         "Examples:\n"
         "  fanal info builtin:hall\n"
         "  fanal info builtin:city?lights=4096 --json");
}

/** Warnings are listed by the command itself; only errors go out while loading. */
static void log_errors(void *user, fnl_log_level level, const char *line) {
    (void)user;
    if (level == FNL_LOG_ERROR) fprintf(stderr, "fanal: error: %s\n", line);
}

/* ---- text ---- */

/** Digits in groups of three. */
static const char *grouped(uint64_t value, char out[32]) {
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%" PRIu64, value), used = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0) out[used++] = ' ';
        out[used++] = digits[i];
    }
    out[used] = 0;
    return out;
}

static void print_count(const char *name, uint64_t value, const char *note) {
    char text[32];
    printf("  %-12s %12s%s%s\n", name, grouped(value, text), *note ? "  " : "", note);
}

static void print_counts(const fnl_scene *scene, const fnl_scene_info *info) {
    char note[128], number[32];
    snprintf(note, sizeof note, "(%s in the meshes, each counted once)", grouped(info->unique_triangle_count, number));
    print_count("triangles", info->triangle_count, note);
    print_count("vertices", info->unique_vertex_count, "");
    print_count("instances", info->instance_count, "");
    print_count("nodes", info->node_count, "");
    snprintf(note, sizeof note, "(%u primitives)", info->primitive_count);
    print_count("meshes", info->mesh_count, note);
    print_count("materials", info->material_count, "");
    print_count("images", info->image_count, "");
    int used = 0;
    for (int i = 0; i < FNL_LIGHT_KIND_COUNT; i++)
        if (i <= FNL_LIGHT_SPOT || info->light_kind_counts[i])
            used += snprintf(note + used, sizeof note - (size_t)used, "%s%u %s", i ? ", " : "(", info->light_kind_counts[i],
                             fnl_value_name(FNL_ENUM_LIGHT_KIND, (fnl_light_kind)i));
    snprintf(note + used, sizeof note - (size_t)used, ")");
    print_count("lights", info->light_count, info->light_count ? note : "");
    if (info->light_threshold > 0)
        snprintf(note, sizeof note, "(cut where they give less than %.3g lx)", info->light_threshold);
    if (info->unlimited_light_count) print_count("  no range", info->unlimited_light_count, info->light_threshold > 0 ? note : "(they light everything)");
    used = 0;
    for (int i = 0; i < FNL_DECAL_KIND_COUNT; i++)
        if (info->decal_kind_counts[i])
            used += snprintf(note + used, sizeof note - (size_t)used, "%s%u %s", used ? ", " : "(",
                             info->decal_kind_counts[i], fnl_value_name(FNL_ENUM_DECAL_KIND, (fnl_decal_kind)i));
    snprintf(note + used, sizeof note - (size_t)used, ")");
    if (info->decal_count) print_count("decals", info->decal_count, note);
    if (info->probe_count) print_count("probes", info->probe_count, "");
    print_count("cameras", info->camera_count, "");
    print_count("animations", info->animation_count, "");
    print_count("skins", info->skin_count, "");
    fnl_vec3 low = info->bounds_low, high = info->bounds_high;
    if (low.x > high.x) {
        puts("  extent       nothing is shown");
        return;
    }
    double from[3], to[3], origin[3];
    const int digits = origin_digits(scene) > 9 ? 10 : 4;
    origin_place(scene, low, from);
    origin_place(scene, high, to);
    printf("  %-12s %.4g x %.4g x %.4g m, from (%.*g, %.*g, %.*g) to (%.*g, %.*g, %.*g)\n", "extent", (double)(high.x - low.x), (double)(high.y - low.y),
           (double)(high.z - low.z), digits, from[0], digits, from[1], digits, from[2], digits, to[0], digits, to[1], digits, to[2]);
    if (digits > 4 && fnl_scene_query_origin(scene, origin) == FNL_OK)
        printf("  %-12s (%.10g, %.10g, %.10g): floats are exact nearby\n", "origin", origin[0], origin[1], origin[2]);
}

/** Long lists are cut in the text, not in the JSON. */
#define LIST_MAX 40u

static void print_rest(uint32_t count) {
    if (count > LIST_MAX) printf("  and %u more (--json lists all)\n", count - LIST_MAX);
}

static int column_width(const fnl_scene *scene, uint32_t count) {
    int width = 0;
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_image_info image;
        fnl_scene_query_image(scene, i, &image);
        int length = (int)strlen(image.name);
        if (length > width) width = length;
    }
    return width;
}

static const char *name_of(const fnl_scene *scene, fnl_entity kind, uint32_t index) {
    fnl_entity_info info = {.name = ""};
    fnl_scene_query_entity(scene, kind, index, &info);
    return info.name;
}

/** What is listed by name alone; things without a name are counted only. */
static const struct {
    fnl_entity kind;
    const char *title, *key;
} named[] = {{FNL_ENTITY_INSTANCE, "Nodes", "nodes"}, {FNL_ENTITY_MESH, "Meshes", "meshes"}, {FNL_ENTITY_MATERIAL, "Materials", "materials"}};
enum { NAMED_COUNT = sizeof named / sizeof *named };

static void print_names(const fnl_scene *scene) {
    for (int k = 0; k < NAMED_COUNT; k++) {
        uint32_t total = fnl_scene_count(scene, named[k].kind), count = 0;
        for (uint32_t i = 0; i < total; i++) {
            const char *name = name_of(scene, named[k].kind, i);
            if (!*name || count++ >= LIST_MAX) continue;
            if (count == 1) printf("\n%s\n", named[k].title);
            printf("  %3u  %s\n", i, name);
        }
        print_rest(count);
    }
}

static void print_images(const fnl_scene *scene, uint32_t count) {
    if (count) puts("\nImages");
    int width = column_width(scene, count);
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_image_info image;
        fnl_scene_query_image(scene, i, &image);
        printf("  %-*s  %-9s  %5u x %u\n", width, image.name, image.file_kind, image.width, image.height);
    }
    print_rest(count);
}

static bool light_switch(const fnl_light_params *light, const fnl_light_member *member) { return *((const char *)light + member->offset) != 0; }

static const float *light_values(const fnl_light_params *light, const fnl_light_member *member) {
    const void *values = (const char *)light + member->offset;
    return values;
}

static void print_light_member(const fnl_light_params *light, const fnl_light_member *member) {
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) {
        if (light_switch(light, member)) printf("  %s", member->labels[0]);
        return;
    }
    for (uint32_t i = 0; i < member->count; i++) {
        const double value = (double)light_values(light, member)[i];
        if (member->unit == FNL_LIGHT_UNIT_RADIANS)
            printf("  %s %.1f degrees", member->labels[i], value * 180 / 3.14159265358979);
        else
            printf("  %s %.4g%s", member->labels[i], value, member->unit == FNL_LIGHT_UNIT_METERS ? " m" : "");
    }
}

static void print_place(const fnl_scene *scene, fnl_vec3 position) {
    double place[3];
    origin_place(scene, position, place);
    printf("  at %8.3f %8.3f %8.3f", place[0], place[1], place[2]);
}

static void print_lights(const fnl_scene *scene, uint32_t count) {
    if (count) puts("\nLights");
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_light_params light;
        fnl_scene_query_light(scene, i, &light);
        const fnl_light_kind_info *kind = fnl_light_kind_find(light.kind);
        printf("  %-11s  %9.4g %-3s  color %.3f %.3f %.3f", fnl_value_name(FNL_ENUM_LIGHT_KIND, light.kind), (double)light.intensity, kind->parallel ? "lx" : "cd",
               (double)light.color[0], (double)light.color[1], (double)light.color[2]);
        if (kind->has_position) print_place(scene, light.position);
        if (kind->has_range && isinf(light.range))
            printf("  no range");
        else if (kind->has_range)
            printf("  range %.4g m", (double)light.range);
        for (uint32_t k = 0; k < kind->member_count; k++) print_light_member(&light, &kind->members[k]);
        if (light.mask != 255) printf("  mask 0x%02x", light.mask);
        const char *name = name_of(scene, FNL_ENTITY_LIGHT, i);
        if (*name) printf("  %s", name);
        putchar('\n');
    }
    print_rest(count);
}

static void print_cameras(const fnl_scene *scene, uint32_t count) {
    if (count) puts("\nCameras");
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_camera camera;
        fnl_scene_query_camera(scene, i, &camera);
        printf("  %3u  %-24s  ", i, name_of(scene, FNL_ENTITY_CAMERA, i));
        if (camera.orthographic)
            printf("orthographic, %.4g m high", (double)camera.vertical_extent);
        else
            printf("perspective, %.1f degrees", (double)camera.vertical_fov * 180 / 3.14159265358979);
        print_place(scene, camera.position);
        putchar('\n');
    }
    print_rest(count);
}

static void print_animations(const fnl_scene *scene, uint32_t count) {
    if (count) puts("\nAnimations");
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_animation_info animation;
        fnl_scene_query_animation(scene, i, &animation);
        printf("  %3u  %-24s  %8.3f s  %5u channels\n", i, animation.name, animation.duration, animation.channel_count);
    }
    print_rest(count);
}

static void print_variants(const fnl_scene *scene, uint32_t count, uint32_t shown) {
    if (count) puts("\nVariants");
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++)
        printf("  %3u  %s%s\n", i, name_of(scene, FNL_ENTITY_VARIANT, i), i == shown ? "  (shown)" : "");
    print_rest(count);
}

/* What each is about, and its members but for the names of vocabularies. */
static void print_metadata(const fnl_scene *scene) {
    const uint32_t count = fnl_scene_count(scene, FNL_ENTITY_METADATA);
    if (count) puts("\nMetadata");
    for (uint32_t i = 0; i < count && i < LIST_MAX; i++) {
        fnl_entity_info info = {.name = ""};
        fnl_scene_query_entity(scene, FNL_ENTITY_METADATA, i, &info);
        printf("  %3u  %.160s\n", i, *info.name ? info.name : "(of nothing)");
        json_t *packet = info.extras ? json_loads(info.extras, 0, NULL) : NULL, *value;
        const char *key;
        json_object_foreach(packet, key, value) {
            if (strcmp(key, "@context") == 0) continue;
            json_t *name = json_string(key);
            char *name_text = json_text_write(name, JSON_ENCODE_ANY), *text = json_text_write(value, JSON_ENCODE_ANY | JSON_COMPACT);
            if (name_text && text) printf("       %s: %.160s\n", name_text, text);
            free(name_text);
            free(text);
            json_decref(name);
        }
        json_decref(packet);
    }
    print_rest(count);
}

static void print_text(const fnl_scene *scene, const char *source, const fnl_scene_info *info, uint32_t variant) {
    printf("%s\n", source);
    print_counts(scene, info);
    print_images(scene, info->image_count);
    print_lights(scene, info->light_count);
    print_cameras(scene, info->camera_count);
    print_animations(scene, info->animation_count);
    print_variants(scene, info->variant_count, variant);
    print_names(scene);
    print_metadata(scene);
    if (info->extension_count) puts("\nExtensions");
    for (uint32_t i = 0; i < info->extension_count; i++) {
        fnl_extension_info extension;
        fnl_scene_query_extension(scene, i, &extension);
        printf("  %-36s  %-8s  %s\n", extension.name, extension.required ? "required" : "used", extension.treatment);
    }
    if (info->message_count) puts("\nWarnings");
    for (uint32_t i = 0; i < info->message_count; i++) printf("  %s\n", fnl_scene_message(scene, i));
}

/* ---- JSON ---- */

static json_t *json_vec3(fnl_vec3 v) { return json_pack("[f,f,f]", (double)v.x, (double)v.y, (double)v.z); }

static json_t *json_count(uint64_t value) { return json_integer((json_int_t)value); }

static json_t *json_counts(const fnl_scene_info *info) {
    json_t *object = json_object();
    json_object_set_new(object, "triangles", json_count(info->triangle_count));
    json_object_set_new(object, "unique_triangles", json_count(info->unique_triangle_count));
    json_object_set_new(object, "unique_vertices", json_count(info->unique_vertex_count));
    json_object_set_new(object, "instances", json_count(info->instance_count));
    json_object_set_new(object, "nodes", json_count(info->node_count));
    json_object_set_new(object, "meshes", json_count(info->mesh_count));
    json_object_set_new(object, "primitives", json_count(info->primitive_count));
    json_object_set_new(object, "materials", json_count(info->material_count));
    json_object_set_new(object, "images", json_count(info->image_count));
    json_object_set_new(object, "lights", json_count(info->light_count));
    json_object_set_new(object, "unlimited_lights", json_count(info->unlimited_light_count));
    json_object_set_new(object, "decals", json_count(info->decal_count));
    json_object_set_new(object, "probes", json_count(info->probe_count));
    json_object_set_new(object, "cameras", json_count(info->camera_count));
    json_object_set_new(object, "animations", json_count(info->animation_count));
    json_object_set_new(object, "skins", json_count(info->skin_count));
    return object;
}

static json_t *json_light_member(const fnl_light_params *light, const fnl_light_member *member) {
    if (member->unit == FNL_LIGHT_UNIT_SWITCH) return json_boolean(light_switch(light, member));
    const float *values = light_values(light, member);
    if (member->count == 1) return json_real((double)*values);
    json_t *array = json_array();
    for (uint32_t i = 0; i < member->count; i++) json_array_append_new(array, json_real((double)values[i]));
    return array;
}

/* Keys keep their order from one version to the next: `up` comes first for rectangles, second for other kinds. */
static void add_light_members(json_t *object, const fnl_light_params *light, const fnl_light_kind_info *kind) {
    const uint32_t up_at = kind->area || kind->member_count == 0 ? 0 : 1;
    for (uint32_t i = 0; i <= kind->member_count; i++) {
        if (kind->has_up && i == up_at) json_object_set_new(object, "up", json_vec3(light->up));
        if (i < kind->member_count) json_object_set_new(object, kind->members[i].name, json_light_member(light, &kind->members[i]));
    }
}

static json_t *json_light(const fnl_scene *scene, const char *name, const fnl_light_params *light) {
    const fnl_light_kind_info *kind = fnl_light_kind_find(light->kind);
    json_t *object =
        json_pack("{s:o,s:s,s:f,s:[f,f,f]}", "name", json_text(name), "kind", fnl_value_name(FNL_ENUM_LIGHT_KIND, light->kind), "intensity", (double)light->intensity,
                  "color", (double)light->color[0], (double)light->color[1], (double)light->color[2]);
    if (kind->has_position) json_object_set_new(object, "position", origin_json(scene, light->position));
    if (kind->has_range) json_object_set_new(object, "range", isinf(light->range) ? json_null() : json_real((double)light->range));
    if (kind->has_direction) json_object_set_new(object, "direction", json_vec3(light->direction));
    add_light_members(object, light, kind);
    if (kind->has_source_angle) json_object_set_new(object, "source_angle", json_real((double)light->source_angle));
    if (kind->has_source_radius) json_object_set_new(object, "source_radius", json_real((double)light->source_radius));
    json_object_set_new(object, "mask", json_integer((json_int_t)light->mask));
    json_object_set_new(object, "casts_shadows", json_boolean(light->casts_shadows));
    json_object_set_new(object, "contact_scale", json_real((double)light->contact_scale));
    json_object_set_new(object, "shadow_update", json_string(fnl_value_name(FNL_ENUM_SHADOW_UPDATE, light->shadow_update)));
    return object;
}

static json_t *json_camera(const fnl_scene *scene, uint32_t index) {
    fnl_camera camera;
    fnl_scene_query_camera(scene, index, &camera);
    json_t *object = json_object();
    json_object_set_new(object, "name", json_text(name_of(scene, FNL_ENTITY_CAMERA, index)));
    json_object_set_new(object, "orthographic", json_boolean(camera.orthographic));
    json_object_set_new(object, camera.orthographic ? "vertical_extent" : "vertical_fov",
                        json_real((double)(camera.orthographic ? camera.vertical_extent : camera.vertical_fov)));
    json_object_set_new(object, "position", origin_json(scene, camera.position));
    json_object_set_new(object, "target", origin_json(scene, camera.target));
    return object;
}

/* {"about": [pointers], "packet": what the file says} */
static json_t *json_metadata(const fnl_scene *scene, uint32_t index) {
    fnl_entity_info info = {.name = ""};
    fnl_scene_query_entity(scene, FNL_ENTITY_METADATA, index, &info);
    json_t *about = json_array(), *packet = info.extras ? json_loads(info.extras, 0, NULL) : NULL;
    for (const char *from = info.name; *from;) {
        const size_t length = strcspn(from, " ");
        json_array_append_new(about, json_stringn(from, length));
        from += length + (from[length] == ' ');
    }
    return json_pack("{s:o,s:o}", "about", about, "packet", packet ? packet : json_null());
}

static json_t *make_json(const fnl_scene *scene, const char *source, const fnl_scene_info *info, uint32_t variant) {
    json_t *root = json_object(), *images = json_array(), *lights = json_array(), *cameras = json_array(),
           *animations = json_array(), *variants = json_array(), *extensions = json_array(), *warnings = json_array();
    for (uint32_t i = 0; i < info->image_count; i++) {
        fnl_image_info image;
        fnl_scene_query_image(scene, i, &image);
        json_array_append_new(images, json_pack("{s:o,s:s,s:I,s:I}", "name", json_text(image.name), "kind", image.file_kind, "width",
                                                (json_int_t)image.width, "height", (json_int_t)image.height));
    }
    for (uint32_t i = 0; i < info->light_count; i++) {
        fnl_light_params light;
        fnl_scene_query_light(scene, i, &light);
        json_array_append_new(lights, json_light(scene, name_of(scene, FNL_ENTITY_LIGHT, i), &light));
    }
    for (uint32_t i = 0; i < info->camera_count; i++) json_array_append_new(cameras, json_camera(scene, i));
    for (uint32_t i = 0; i < info->animation_count; i++) {
        fnl_animation_info animation;
        fnl_scene_query_animation(scene, i, &animation);
        json_array_append_new(animations, json_pack("{s:o,s:f,s:I}", "name", json_text(animation.name), "duration", animation.duration,
                                                    "channels", (json_int_t)animation.channel_count));
    }
    for (uint32_t i = 0; i < info->variant_count; i++) json_array_append_new(variants, json_text(name_of(scene, FNL_ENTITY_VARIANT, i)));
    for (uint32_t i = 0; i < info->extension_count; i++) {
        fnl_extension_info extension;
        fnl_scene_query_extension(scene, i, &extension);
        json_array_append_new(extensions, json_pack("{s:o,s:b,s:s}", "name", json_text(extension.name), "required", extension.required,
                                                    "treatment", extension.treatment));
    }
    for (uint32_t i = 0; i < info->message_count; i++)
        json_array_append_new(warnings, json_text(fnl_scene_message(scene, i)));
    bool empty = info->bounds_low.x > info->bounds_high.x;
    double origin[3] = {0, 0, 0};
    (void)fnl_scene_query_origin(scene, origin);
    json_object_set_new(root, "source", json_text(source));
    json_object_set_new(root, "counts", json_counts(info));
    json_object_set_new(root, "light_threshold", info->light_threshold > 0 ? json_real(info->light_threshold) : json_null());
    json_object_set_new(
        root, "extent",
        empty ? json_null()
              : json_pack("{s:o,s:o}", "low", origin_json(scene, info->bounds_low), "high", origin_json(scene, info->bounds_high)));
    json_object_set_new(root, "origin", json_pack("[f,f,f]", origin[0], origin[1], origin[2]));
    json_object_set_new(root, "images", images);
    json_object_set_new(root, "lights", lights);
    json_object_set_new(root, "cameras", cameras);
    json_object_set_new(root, "animations", animations);
    json_object_set_new(root, "variants", variants);
    json_object_set_new(root, "variant", variant == FNL_NO_VARIANT ? json_null() : json_count(variant));
    for (int k = 0; k < NAMED_COUNT; k++) {
        json_t *names = json_array();
        uint32_t count = fnl_scene_count(scene, named[k].kind);
        for (uint32_t i = 0; i < count; i++) json_array_append_new(names, json_text(name_of(scene, named[k].kind, i)));
        json_object_set_new(root, named[k].key, names);
    }
    json_t *metadata = json_array();
    for (uint32_t i = 0; i < fnl_scene_count(scene, FNL_ENTITY_METADATA); i++) json_array_append_new(metadata, json_metadata(scene, i));
    json_object_set_new(root, "metadata", metadata);
    json_object_set_new(root, "extensions", extensions);
    json_object_set_new(root, "warnings", warnings);
    return root;
}

static int print_json(const fnl_scene *scene, const char *source, const fnl_scene_info *info, uint32_t variant) {
    json_t *root = make_json(scene, source, info, variant);
    const bool failed = !json_text_print(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    json_decref(root);
    if (failed) fputs("fanal: error: the JSON could not be written\n", stderr);
    return failed ? EXIT_ERROR : EXIT_GOOD;
}

int command_info(int argc, char **argv) {
    static const struct option options[] = {{"json", no_argument, NULL, 'j'},
                                            {"gbuffers", no_argument, NULL, 'g'},
                                            {"size", required_argument, NULL, 's'},
                                            {"samples", required_argument, NULL, 'n'},
                                            {"fps", required_argument, NULL, 'f'},
                                            {"variant", required_argument, NULL, 'v'},
                                            {"help", no_argument, NULL, 'h'},
                                            LOADING_OPTIONS,
                                            {NULL, 0, NULL, 0}};
    bool json = false, gbuffers = false;
    const char *wanted_variant = NULL;
    uint32_t variant;
    struct gbuffer_question question = {1920, 1080, 1, 30};
    fnl_load_params loading = fnl_load_params_default();
    long long integer;
    optind = 0; /* a full restart: several commands may run in one process */
    for (int option; (option = argument_next(argc, argv, "h", options)) != -1;) {
        switch (option) {
        case 'j':
            json = true;
            break;
        case 'g':
            gbuffers = true;
            break;
        case 's':
            if (!argument_size("size", optarg, &question.width, &question.height)) return EXIT_ERROR;
            break;
        case 'n':
            if (!argument_integer("samples", optarg, 1, 64, &integer)) return EXIT_ERROR;
            question.samples = (uint32_t)integer;
            break;
        case 'f':
            if (!argument_number("fps", optarg, &question.frames_per_second)) return EXIT_ERROR;
            if (!(question.frames_per_second > 0)) {
                argument_bad("fps", optarg, "a number above 0");
                return EXIT_ERROR;
            }
            break;
        case 'v':
            wanted_variant = optarg;
            break;
        case 'h':
            print_help();
            return EXIT_GOOD;
        case LOADING_LENIENT:
        case LOADING_CONFINE:
        case LOADING_MAX_MEMORY:
            if (!loading_parse(option, optarg, &loading)) return EXIT_ERROR;
            break;
        default:
            return EXIT_ERROR;
        }
    }
    if (gbuffers) {
        if (argc != optind) {
            fputs("fanal: error: --gbuffers takes no scene; see 'fanal info --help'\n", stderr);
            return EXIT_ERROR;
        }
        info_print_gbuffers(&question);
        return EXIT_GOOD;
    }
    if (argc - optind != 1) {
        fprintf(stderr, "fanal: error: one scene is needed, %d were given; see 'fanal info --help'\n", argc - optind);
        return EXIT_ERROR;
    }
    const char *source = argv[optind];
    fnl_host host = fnl_host_default();
    host.log = log_errors;
    fnl_scene *scene = NULL;
    fnl_scene_info info;
    int status = EXIT_ERROR;
    if (fnl_scene_load(&host, source, &loading, &scene) == FNL_OK && loading_select_variant(scene, wanted_variant, &variant) &&
        fnl_scene_query_info(scene, &info) == FNL_OK) {
        status = EXIT_GOOD;
        if (json)
            status = print_json(scene, source, &info, variant);
        else
            print_text(scene, source, &info, variant);
    }
    fnl_scene_destroy(&scene);
    return status;
}
