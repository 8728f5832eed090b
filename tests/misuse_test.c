/* SPDX-License-Identifier: MIT */
/**
 * What public functions say when they are misused: every export is called with NULL for each of its pointers, and every field of the
 * params structs is set out of its range. One line names the function, the field or argument, what was given and what may be.
 */
#include "base/base.h"
#include "base/maths.h"
#include "fanal/fanal.h"
#include "fanal/vulkan.h"
#include "frame_plain.h"

#include <glob.h>
#include <math.h>
#include <setjmp.h>
#include <unistd.h>

#include <cmocka.h>

static struct {
    fnl_device *device;
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_swapchain *swapchain;
    fnl_compositor *compositor;
    fnl_light_id light;
    fnl_mesh_id mesh;
    fnl_material_id material;
    fnl_instance_id instance;
    fnl_decal_id decal;
    fnl_probe_id probe;
    const char *function; /* that is tried */
    uint32_t tried;       /* pointers of it */
    FILE *kept;           /* what stands in for stderr, where lines without a host go */
    int terminal;
} w;

/* ---- what is logged ---- */

static void capture(void) {
    fflush(stderr);
    rewind(w.kept);
    assert_int_equal(ftruncate(fileno(w.kept), 0), 0);
    w.terminal = dup(STDERR_FILENO);
    dup2(fileno(w.kept), STDERR_FILENO);
}

static void expect(fnl_result result, fnl_result wanted, const char *function, const char *words) {
    char text[4096], line[1024];
    fflush(stderr);
    dup2(w.terminal, STDERR_FILENO);
    close(w.terminal);
    ssize_t length = pread(fileno(w.kept), text, sizeof text - 1, 0);
    text[MAX(length, 0)] = 0;
    snprintf(line, sizeof line, "fanal: error: %s: %s\n", function, words);
    if (result != wanted) fail_msg("%s: '%s' is no %s, but %s", function, words, fnl_result_name(wanted), fnl_result_name(result));
    if (strcmp(text, line) != 0) fail_msg("logged:\n%sinstead of:\n%s", text, line);
}

#define SAYS_OF(wanted, function, words, call)                                                                              \
    do {                                                                                                                    \
        capture();                                                                                                          \
        fnl_result result_ = (call);                                                                                        \
        expect(result_, wanted, function, words);                                                                           \
    } while (0)
#define SAYS(function, words, call) SAYS_OF(FNL_ERROR_INVALID, function, words, call)

/* An argument that is NULL; functions without an fnl_result give `nothing`. */
#define NULLED(argument, call) (w.tried++, null_begins(), null_ends(argument, call))
#define GIVES(argument, nothing, call) (w.tried++, null_begins(), null_ends(argument, (call) == (nothing) ? FNL_ERROR_INVALID : FNL_OK))
#define DOES(argument, call) (w.tried++, null_begins(), call, null_ends(argument, FNL_ERROR_INVALID))
/* NULL has a meaning: nothing is logged. */
#define SILENT(call) (w.tried++, null_begins(), (void)(call), null_was_silent())

static void null_begins(void) { capture(); }
static void null_ends(const char *argument, fnl_result result) {
    char words[100];
    snprintf(words, sizeof words, "%s is NULL", argument);
    expect(result, FNL_ERROR_INVALID, w.function, words);
}
static void null_was_silent(void) {
    fflush(stderr);
    dup2(w.terminal, STDERR_FILENO);
    close(w.terminal);
    if (lseek(fileno(w.kept), 0, SEEK_END) != 0) fail_msg("%s: NULL is not silent", w.function);
}

/* ---- every export ---- */

static fnl_host host;
static fnl_image picture, other, difference_image, joined;
static fnl_trace_params trace_params;
static fnl_trace traced;
#ifdef FANAL_RAY
#define TRACES_BY_DEFAULT SILENT(fnl_scene_trace(w.scene, NULL, &traced)); fnl_trace_free(NULL, &traced)
#else
#define TRACES_BY_DEFAULT w.tried++
#endif
static fnl_image_difference difference;
static fnl_compress_params compress; /* zero: fast */
static fnl_compress_stats compressed;
static fnl_exr_channel channel;
static fnl_device_info device_info;
static fnl_vulkan_import handles;
static fnl_material_params material;
static fnl_mesh_params mesh;
static fnl_mesh_info mesh_info;
static fnl_pose pose;
static const fnl_animation_time moment = {0, 0, 1};
static fnl_light_params light;
static fnl_decal_params decal;
static fnl_probe_params probe;
static fnl_environment_params surroundings;
static fnl_probe_id probe_id;
static fnl_camera camera;
static const fnl_rigid_pose head = {{0, 0, 0}, {0, 0, 0, 1}};
static const fnl_eye eye = {{{0, 0, 0}, {0, 0, 0, 1}}, -1, 1, -1, 1};
static fnl_vec2 corners[FNL_HIDDEN_ROUND_CORNERS(3)];
static fnl_hidden_area hidden_area;
static fnl_eye_cell cells[9];
static fnl_compositor *made_compositor;
static const fnl_composition composition = {.head = {{0, 0, 0}, {0, 0, 0, 1}}};
static fnl_compositor_stats compositor_stats;
static fnl_frame_stats stats;
static bool is_done;
static fnl_pixel_info pixel_info;
static fnl_scene_info info;
static double somewhere[3];
static fnl_entity_info entity_info;
static fnl_instance_info instance_info;
static fnl_image_info image_info;
static fnl_animation_info animation_info;
static fnl_extension_info extension_info;
static fnl_image_id image_id;
static fnl_material_id material_id;
static fnl_mesh_id mesh_id;
static fnl_instance_id instance_id;
static fnl_light_id light_id;
static fnl_light_profile_id profile_id;
static float candela;
static fnl_decal_id decal_id;
static fnl_scatter_params scatter;
static fnl_frame frame;
static char words[64];
static fnl_vulkan_target target;
static fnl_scene *made;
static fnl_device *made_device;
static fnl_swapchain *made_swapchain;
static fnl_vulkan_handles vulkan_handles;
static fnl_swapchain_info swapchain_info;
static fnl_swapchain_params swapchain_params;
static fnl_renderer *made_renderer;
static fnl_mat4 matrix;
static uint32_t number;
static const char document[] = "{\"asset\":{\"version\":\"2.0\"}}";
static const fnl_load_params in_memory = {.max_memory = UINT64_MAX, .data = document, .size = sizeof document - 1};
static fnl_loaded loaded;

/* X(function, what is tried with each pointer of its declaration). Where a host is NULL it stands for the built-in one. */
#define EXPORTS(X)                                                                                                          \
    X(fnl_counter_query, GIVES("out", false, fnl_counter_query(0, NULL)))                                                   \
    X(fnl_device_create, SILENT((fnl_device_create(NULL, &made_device), fnl_device_destroy(&made_device)));                 \
      NULLED("out", fnl_device_create(NULL, NULL)))                                                                         \
    X(fnl_device_destroy, SILENT(fnl_device_destroy(NULL)))                                                                 \
    X(fnl_device_import, NULLED("import", fnl_device_import(NULL, NULL, &made_device));                                     \
      NULLED("out", fnl_device_import(NULL, &handles, NULL));                                                               \
      NULLED("import", fnl_device_import(NULL, NULL, &made_device)))                                                        \
    X(fnl_device_query_info, NULLED("device", fnl_device_query_info(NULL, &device_info));                                   \
      NULLED("out", fnl_device_query_info(w.device, NULL)))                                                                 \
    X(fnl_device_query_vulkan, NULLED("device", fnl_device_query_vulkan(NULL, &vulkan_handles));                            \
      NULLED("out", fnl_device_query_vulkan(w.device, NULL)))                                                               \
    X(fnl_swapchain_create, NULLED("device", fnl_swapchain_create(NULL, VK_NULL_HANDLE, NULL, &made_swapchain));            \
      NULLED("surface", fnl_swapchain_create(w.device, VK_NULL_HANDLE, NULL, &made_swapchain));                             \
      NULLED("out", fnl_swapchain_create(w.device, VK_NULL_HANDLE, NULL, NULL)))                                            \
    X(fnl_swapchain_destroy, SILENT(fnl_swapchain_destroy(NULL)))                                                           \
    X(fnl_swapchain_set, NULLED("swapchain", fnl_swapchain_set(NULL, &swapchain_params));                                \
      NULLED("params", fnl_swapchain_set(w.swapchain, NULL)))                                                \
    X(fnl_swapchain_acquire, NULLED("swapchain", fnl_swapchain_acquire(NULL, &target));                                      \
      NULLED("out", fnl_swapchain_acquire(w.swapchain, NULL)))                                     \
    X(fnl_swapchain_present, NULLED("swapchain", fnl_swapchain_present(NULL)))                                              \
    X(fnl_swapchain_query_info, NULLED("swapchain", fnl_swapchain_query_info(NULL, &swapchain_info));                           \
      NULLED("out", fnl_swapchain_query_info(w.swapchain, NULL)))                       \
    X(fnl_device_validation_count, GIVES("device", 0, fnl_device_validation_count(NULL)))                                   \
    X(fnl_enumerate_devices, SILENT(fnl_enumerate_devices(NULL, NULL, 0, &number));                                         \
      SILENT(fnl_enumerate_devices(&host, NULL, 0, &number));                                                               \
      NULLED("out_count", fnl_enumerate_devices(NULL, NULL, 0, NULL)))                                                      \
    X(fnl_eye_query_camera, NULLED("eye", fnl_eye_query_camera(NULL, NULL, &head, 1, 1, 1, &camera));                       \
      NULLED("eye", fnl_eye_query_camera(&host, NULL, &head, 1, 1, 1, &camera));                                            \
      NULLED("head", fnl_eye_query_camera(NULL, &eye, NULL, 1, 1, 1, &camera));                                             \
      NULLED("out", fnl_eye_query_camera(NULL, &eye, &head, 1, 1, 1, NULL)))                                                \
    X(fnl_eye_query_cells, NULLED("eye", fnl_eye_query_cells(NULL, NULL, 9, 9, 1, 1, cells));                               \
      NULLED("cells", fnl_eye_query_cells(NULL, &eye, 9, 9, 1, 1, NULL)))                                                  \
    X(fnl_eye_query_quadrants, NULLED("eye", fnl_eye_query_quadrants(NULL, NULL, 9, 9, corners[0], cells));                \
      NULLED("cells", fnl_eye_query_quadrants(NULL, &eye, 9, 9, corners[0], NULL)))                                        \
    X(fnl_eye_join_cells, NULLED("eye", fnl_eye_join_cells(NULL, NULL, cells, 1, &picture, &joined));                      \
      NULLED("cells", fnl_eye_join_cells(NULL, &eye, NULL, 1, &picture, &joined));                                         \
      NULLED("pictures", fnl_eye_join_cells(NULL, &eye, cells, 1, NULL, &joined));                                         \
      NULLED("out", fnl_eye_join_cells(NULL, &eye, cells, 1, &picture, NULL));                                             \
      NULLED("out", fnl_eye_join_cells(&host, &eye, cells, 1, &picture, NULL)))                                            \
    X(fnl_hidden_area_round, NULLED("eye", fnl_hidden_area_round(NULL, NULL, corners[0], 1, 3, corners, &hidden_area));    \
      NULLED("eye", fnl_hidden_area_round(&host, NULL, corners[0], 1, 3, corners, &hidden_area));                          \
      NULLED("corners", fnl_hidden_area_round(NULL, &eye, corners[0], 1, 3, NULL, &hidden_area));                          \
      NULLED("out", fnl_hidden_area_round(NULL, &eye, corners[0], 1, 3, corners, NULL)))                                   \
    X(fnl_lens_display_edge, SILENT(fnl_lens_display_edge(NULL, 1, false)))                                                \
    X(fnl_compositor_create, NULLED("device", fnl_compositor_create(NULL, NULL, &made_compositor));                        \
      SILENT((fnl_compositor_create(w.device, NULL, &made_compositor), fnl_compositor_destroy(&made_compositor)));         \
      NULLED("out", fnl_compositor_create(w.device, NULL, NULL)))                                                          \
    X(fnl_compositor_destroy, SILENT(fnl_compositor_destroy(NULL)))                                                        \
    X(fnl_compositor_submit, NULLED("compositor", fnl_compositor_submit(NULL, &(fnl_eye_pictures){.color = &picture}));     \
      NULLED("pictures", fnl_compositor_submit(w.compositor, NULL)))                                                       \
    X(fnl_compositor_compose, NULLED("compositor", fnl_compositor_compose(NULL, &composition, &difference_image));          \
      NULLED("composition", fnl_compositor_compose(w.compositor, NULL, &difference_image));                                \
      NULLED("out", fnl_compositor_compose(w.compositor, &composition, NULL)))                                             \
    X(fnl_compositor_query_stats, NULLED("compositor", fnl_compositor_query_stats(NULL, &compositor_stats));                \
      NULLED("out", fnl_compositor_query_stats(w.compositor, NULL)))                                                       \
    X(fnl_exr_save, NULLED("path", fnl_exr_save(NULL, NULL, 1, 1, &channel, 1));                                            \
      NULLED("path", fnl_exr_save(&host, NULL, 1, 1, &channel, 1));                                                         \
      NULLED("channels", fnl_exr_save(&host, "x.exr", 1, 1, NULL, 1)))                                                      \
    X(fnl_frame_get, GIVES("frame", 0, fnl_frame_get(NULL, "msaa", words, sizeof words));                                   \
      GIVES("key", 0, fnl_frame_get(&frame, NULL, words, sizeof words));                                                    \
      GIVES("text", 0, fnl_frame_get(&frame, "msaa", NULL, 1)))                                                             \
    X(fnl_frame_set, SILENT(fnl_frame_set(NULL, &frame, "msaa", "1"));                                                      \
      NULLED("frame", fnl_frame_set(NULL, NULL, "msaa", "1")); NULLED("key", fnl_frame_set(NULL, &frame, NULL, "1"));       \
      NULLED("value", fnl_frame_set(NULL, &frame, "msaa", NULL)))                                                           \
    X(fnl_debug_legend_query, GIVES("out", false, fnl_debug_legend_query(FNL_DEBUG_LIGHTS, NULL)))                          \
    X(fnl_layer_number_query, GIVES("out", false, fnl_layer_number_query(0, NULL)))                                         \
    X(fnl_layer_texture_query, GIVES("out", false, fnl_layer_texture_query(0, NULL)))                                       \
    X(fnl_option_query, GIVES("out", false, fnl_option_query(0, NULL)))                                                     \
    X(fnl_value_find, GIVES("name", false, fnl_value_find(FNL_ENUM_LISTS, NULL, &number));                                  \
      SILENT(fnl_value_find(FNL_ENUM_LISTS, "tiled", NULL)))                                                                \
    X(fnl_gbuffer_query_info, NULLED("out", fnl_gbuffer_query_info(FNL_GBUFFER_DEFAULT, NULL)))                             \
    X(fnl_image_compress, NULLED("image", fnl_image_compress(NULL, "a.dds", NULL, NULL, NULL));                             \
      NULLED("image", fnl_image_compress(&host, "a.dds", NULL, NULL, NULL));                                                \
      SILENT(fnl_image_compress(&host, NULL, &picture, &compress, &compressed));                                            \
      SILENT(fnl_image_compress(&host, NULL, &picture, NULL, &compressed));                                                 \
      SILENT(fnl_image_compress(&host, NULL, &picture, &compress, NULL)))                                                   \
    X(fnl_image_compare, NULLED("a", fnl_image_compare(NULL, NULL, &other, &difference));                                   \
      NULLED("a", fnl_image_compare(&host, NULL, &other, &difference));                                                     \
      NULLED("b", fnl_image_compare(&host, &picture, NULL, &difference));                                                   \
      NULLED("out", fnl_image_compare(&host, &picture, &other, NULL)))                                                      \
    X(fnl_image_difference_picture, NULLED("a", fnl_image_difference_picture(NULL, NULL, &other, 1, &difference_image));    \
      NULLED("a", fnl_image_difference_picture(&host, NULL, &other, 1, &difference_image));                                 \
      NULLED("b", fnl_image_difference_picture(&host, &picture, NULL, 1, &difference_image));                               \
      NULLED("out", fnl_image_difference_picture(&host, &picture, &other, 1, NULL)))                                        \
    X(fnl_image_free, SILENT(fnl_image_free(NULL, NULL)); SILENT(fnl_image_free(&host, NULL)))                              \
    X(fnl_text_clean, SILENT(assert_false(fnl_text_clean(NULL))))                                                           \
    X(fnl_image_load, NULLED("path", fnl_image_load(NULL, NULL, &difference_image));                                        \
      NULLED("path", fnl_image_load(&host, NULL, &difference_image)); NULLED("out", fnl_image_load(&host, "x.png", NULL)))  \
    X(fnl_image_load_within, NULLED("path", fnl_image_load_within(NULL, NULL, 1, &difference_image));                          \
      NULLED("path", fnl_image_load_within(&host, NULL, 1, &difference_image)); NULLED("out", fnl_image_load_within(&host, "x.png", 1, NULL)))  \
    X(fnl_image_save, NULLED("path", fnl_image_save(NULL, NULL, &picture));                                                 \
      NULLED("path", fnl_image_save(&host, NULL, &picture)); NULLED("image", fnl_image_save(&host, "x.png", NULL)))         \
    X(fnl_light_outline, GIVES("params", 0, fnl_light_outline(NULL, 1, 0, NULL));                                           \
      GIVES("points", 0, fnl_light_outline(&light, 1, 1, NULL)))                                                             \
    X(fnl_light_range, GIVES("params", 0, fnl_light_range(NULL, 1, 1)))                                                     \
    X(fnl_mobile_layout_targets, GIVES("out", 0, fnl_mobile_layout_targets(FNL_MOBILE_METALLIC_128, NULL, 1)))              \
    X(fnl_renderer_create, NULLED("device", fnl_renderer_create(NULL, w.scene, &made_renderer));                            \
      NULLED("scene", fnl_renderer_create(w.device, NULL, &made_renderer));                                                 \
      NULLED("out", fnl_renderer_create(w.device, w.scene, NULL)))                                                          \
    X(fnl_renderer_destroy, SILENT(fnl_renderer_destroy(NULL)))                                                             \
    X(fnl_renderer_print, GIVES("renderer", 0, fnl_renderer_print(NULL, FNL_PRINT_PLAN, NULL, 0));                          \
      SILENT(fnl_renderer_print(w.renderer, FNL_PRINT_TRAFFIC, NULL, 0)))                                                   \
    X(fnl_renderer_query_done, NULLED("renderer", fnl_renderer_query_done(NULL, &is_done));                                 \
      NULLED("out", fnl_renderer_query_done(w.renderer, NULL)))                                                             \
    X(fnl_renderer_query_pixel, NULLED("renderer", fnl_renderer_query_pixel(NULL, &pixel_info));                            \
      NULLED("out", fnl_renderer_query_pixel(w.renderer, NULL)))                                                            \
    X(fnl_renderer_query_stats, NULLED("renderer", fnl_renderer_query_stats(NULL, &stats));                                 \
      NULLED("out", fnl_renderer_query_stats(w.renderer, NULL)))                                                            \
    X(fnl_renderer_read, NULLED("renderer", fnl_renderer_read(NULL, FNL_OUTPUT_COLOR, &difference_image));                  \
      NULLED("out", fnl_renderer_read(w.renderer, FNL_OUTPUT_COLOR, NULL)))                                                 \
    X(fnl_renderer_render, NULLED("renderer", fnl_renderer_render(NULL, &frame));                                           \
      SILENT(fnl_renderer_render(w.renderer, NULL)))                                                                        \
    X(fnl_renderer_warm, NULLED("renderer", fnl_renderer_warm(NULL, &frame, NULL, true, NULL));                             \
      SILENT(fnl_renderer_warm(w.renderer, NULL, NULL, false, &number));                                                    \
      SILENT(fnl_renderer_warm(w.renderer, &frame, NULL, false, &number));                                                  \
      SILENT(fnl_renderer_warm(w.renderer, &frame, NULL, false, NULL)))                                                     \
    X(fnl_renderer_render_to, NULLED("renderer", fnl_renderer_render_to(NULL, &frame, &target));                            \
      NULLED("target", fnl_renderer_render_to(w.renderer, NULL, NULL));                                                     \
      NULLED("target", fnl_renderer_render_to(w.renderer, &frame, NULL)))                                                   \
    X(fnl_scene_add_camera, NULLED("scene", fnl_scene_add_camera(NULL, "c", &camera));                                      \
      SILENT(fnl_scene_add_camera(w.scene, NULL, &camera)); NULLED("camera", fnl_scene_add_camera(w.scene, "c", NULL)))     \
    X(fnl_scene_add_decal, NULLED("scene", fnl_scene_add_decal(NULL, &decal, &decal_id));                                   \
      NULLED("params", fnl_scene_add_decal(w.scene, NULL, &decal_id));                                                      \
      NULLED("out", fnl_scene_add_decal(w.scene, &decal, NULL)))                                                            \
    X(fnl_scene_add_image, NULLED("scene", fnl_scene_add_image(NULL, &picture, true, &image_id));                           \
      NULLED("image", fnl_scene_add_image(w.scene, NULL, true, &image_id));                                                 \
      NULLED("out", fnl_scene_add_image(w.scene, &picture, true, NULL)))                                                    \
    X(fnl_scene_add_instance, NULLED("scene", fnl_scene_add_instance(NULL, w.mesh, &matrix, &instance_id));                 \
      NULLED("transform", fnl_scene_add_instance(w.scene, w.mesh, NULL, &instance_id));                                     \
      NULLED("out", fnl_scene_add_instance(w.scene, w.mesh, &matrix, NULL)))                                                \
    X(fnl_scene_add_light, NULLED("scene", fnl_scene_add_light(NULL, &light, &light_id));                                   \
      NULLED("params", fnl_scene_add_light(w.scene, NULL, &light_id));                                                      \
      NULLED("out", fnl_scene_add_light(w.scene, &light, NULL)))                                                            \
    X(fnl_scene_add_material, NULLED("scene", fnl_scene_add_material(NULL, &material, &material_id));                       \
      SILENT(fnl_scene_add_material(w.scene, NULL, &material_id));                                                          \
      NULLED("out", fnl_scene_add_material(w.scene, &material, NULL)))                                                      \
    X(fnl_scene_add_mesh, NULLED("scene", fnl_scene_add_mesh(NULL, &mesh, &mesh_id));                                       \
      NULLED("params", fnl_scene_add_mesh(w.scene, NULL, &mesh_id));                                                        \
      NULLED("out", fnl_scene_add_mesh(w.scene, &mesh, NULL)))                                                              \
    X(fnl_scene_count, GIVES("scene", 0, fnl_scene_count(NULL, FNL_ENTITY_LIGHT)))                                          \
    X(fnl_scene_create, SILENT((fnl_scene_create(NULL, &made), fnl_scene_destroy(&made)));                                  \
      NULLED("out", fnl_scene_create(&host, NULL)))                                                                         \
    X(fnl_scene_destroy, SILENT(fnl_scene_destroy(NULL)))                                                                   \
    X(fnl_scene_find, NULLED("scene", fnl_scene_find(NULL, FNL_ENTITY_CAMERA, "c", &number));                               \
      NULLED("name", fnl_scene_find(w.scene, FNL_ENTITY_CAMERA, NULL, &number));                                            \
      NULLED("out_index", fnl_scene_find(w.scene, FNL_ENTITY_CAMERA, "c", NULL)))                                           \
    X(fnl_scene_grow_metal, NULLED("scene", fnl_scene_grow_metal(NULL, 1)))                                                 \
    X(fnl_scene_load, NULLED("source", fnl_scene_load(NULL, NULL, NULL, &made));                                            \
      NULLED("source", fnl_scene_load(&host, NULL, NULL, &made));                                                           \
      SILENT((fnl_scene_load(&host, "builtin:spheres", NULL, &made), fnl_scene_destroy(&made)));                            \
      NULLED("out", fnl_scene_load(&host, "builtin:spheres", NULL, NULL)))                                                  \
    X(fnl_scene_load_into, NULLED("scene", fnl_scene_load_into(NULL, (fnl_instance_id){0, 0}, "x.gltf", NULL, &loaded));    \
      NULLED("source", fnl_scene_load_into(w.scene, (fnl_instance_id){0, 0}, NULL, NULL, &loaded));                         \
      SILENT(fnl_scene_load_into(w.scene, (fnl_instance_id){0, 0}, "x.gltf", &in_memory, &loaded));                         \
      SILENT(fnl_scene_load_into(w.scene, (fnl_instance_id){0, 0}, "x.gltf", &in_memory, NULL)))                            \
    X(fnl_scene_message, GIVES("scene", NULL, fnl_scene_message(NULL, 0)))                                                  \
    X(fnl_scene_save, NULLED("scene", fnl_scene_save(NULL, "x.glb", NULL)); NULLED("path", fnl_scene_save(w.scene, NULL, NULL)); \
      w.tried++; /* params: NULL are defaults, as above */) \
    X(fnl_scene_set_times, NULLED("scene", fnl_scene_set_times(NULL, &moment, 1)); NULLED("times", fnl_scene_set_times(w.scene, NULL, 1))) \
    X(fnl_scene_source, GIVES("scene", NULL, fnl_scene_source(NULL, 0)))                                                    \
    X(fnl_scene_query_animation, NULLED("scene", fnl_scene_query_animation(NULL, 0, &animation_info));                      \
      NULLED("out", fnl_scene_query_animation(w.scene, 0, NULL)))                                                           \
    X(fnl_scene_query_camera, NULLED("scene", fnl_scene_query_camera(NULL, 0, &camera));                                    \
      NULLED("out", fnl_scene_query_camera(w.scene, 0, NULL)))                                                              \
    X(fnl_scene_place_probes, NULLED("scene", fnl_scene_place_probes(NULL, &probe, 1, NULL));                               \
      SILENT(fnl_scene_place_probes(w.scene, NULL, 1, &number)); SILENT(fnl_scene_place_probes(w.scene, &probe, 1, NULL))) \
    X(fnl_scene_add_probe, NULLED("scene", fnl_scene_add_probe(NULL, &probe, &probe_id));                                   \
      NULLED("params", fnl_scene_add_probe(w.scene, NULL, &probe_id));                                                      \
      NULLED("out", fnl_scene_add_probe(w.scene, &probe, NULL)))                                                            \
    X(fnl_scene_query_environment, NULLED("scene", fnl_scene_query_environment(NULL, &surroundings));                       \
      NULLED("out", fnl_scene_query_environment(w.scene, NULL)))                                                            \
    X(fnl_scene_query_probe, NULLED("scene", fnl_scene_query_probe(NULL, 0, &probe));                                       \
      NULLED("out", fnl_scene_query_probe(w.scene, 0, NULL)))                                                               \
    X(fnl_scene_remove_probe, NULLED("scene", fnl_scene_remove_probe(NULL, w.probe)))                                       \
    X(fnl_scene_set_probe, NULLED("scene", fnl_scene_set_probe(NULL, w.probe, &probe));                                     \
      NULLED("params", fnl_scene_set_probe(w.scene, w.probe, NULL)))                                                        \
    X(fnl_scene_query_decal, NULLED("scene", fnl_scene_query_decal(NULL, 0, &decal));                                       \
      NULLED("out", fnl_scene_query_decal(w.scene, 0, NULL)))                                                               \
    X(fnl_scene_query_entity, NULLED("scene", fnl_scene_query_entity(NULL, FNL_ENTITY_LIGHT, 0, &entity_info));             \
      NULLED("out", fnl_scene_query_entity(w.scene, FNL_ENTITY_LIGHT, 0, NULL)))                                            \
    X(fnl_scene_query_instance, NULLED("scene", fnl_scene_query_instance(NULL, 0, &instance_info));                         \
      NULLED("out", fnl_scene_query_instance(w.scene, 0, NULL)))                                                            \
    X(fnl_scene_query_material, NULLED("scene", fnl_scene_query_material(NULL, 0, &material));                              \
      NULLED("out", fnl_scene_query_material(w.scene, 0, NULL)))                                                            \
    X(fnl_scene_select_variant, NULLED("scene", fnl_scene_select_variant(NULL, FNL_NO_VARIANT)))                           \
    X(fnl_scene_set_instance_visible, NULLED("scene", fnl_scene_set_instance_visible(NULL, w.instance, true)))              \
    X(fnl_scene_set_material, NULLED("scene", fnl_scene_set_material(NULL, w.material, &material));                         \
      NULLED("params", fnl_scene_set_material(w.scene, w.material, NULL)))                                                  \
    X(fnl_scene_query_extension, NULLED("scene", fnl_scene_query_extension(NULL, 0, &extension_info));                      \
      NULLED("out", fnl_scene_query_extension(w.scene, 0, NULL)))                                                           \
    X(fnl_scene_query_framing_camera, NULLED("scene", fnl_scene_query_framing_camera(NULL, 1, &camera));                    \
      NULLED("out", fnl_scene_query_framing_camera(w.scene, 1, NULL)))                                                      \
    X(fnl_scene_query_image, NULLED("scene", fnl_scene_query_image(NULL, 0, &image_info));                                  \
      NULLED("out", fnl_scene_query_image(w.scene, 0, NULL)))                                                               \
    X(fnl_scene_query_info, NULLED("scene", fnl_scene_query_info(NULL, &info));                                             \
      NULLED("out", fnl_scene_query_info(w.scene, NULL)))                                                                   \
    X(fnl_scene_add_light_profile, NULLED("scene", fnl_scene_add_light_profile(NULL, "a.ies", "", 0, &profile_id, NULL));   \
      NULLED("name", fnl_scene_add_light_profile(w.scene, NULL, "", 0, &profile_id, NULL));                                 \
      NULLED("out", fnl_scene_add_light_profile(w.scene, "a.ies", "", 0, NULL, &candela));                                  \
      SILENT(fnl_scene_add_light_profile(w.scene, "tests/fuzz/seeds/ies/round.ies", NULL, 0, &profile_id, &candela));       \
      SILENT(fnl_scene_add_light_profile(w.scene, "tests/fuzz/seeds/ies/round.ies", NULL, 0, &profile_id, NULL)))           \
    X(fnl_scene_query_light, NULLED("scene", fnl_scene_query_light(NULL, 0, &light));                                       \
      NULLED("out", fnl_scene_query_light(w.scene, 0, NULL)))                                                               \
    X(fnl_scene_refresh_shadows, NULLED("scene", fnl_scene_refresh_shadows(NULL, &w.light, 1));                              \
      NULLED("lights", fnl_scene_refresh_shadows(w.scene, NULL, 1)))                                                        \
    X(fnl_scene_remove_decal, NULLED("scene", fnl_scene_remove_decal(NULL, w.decal)))                                       \
    X(fnl_scene_remove_instance, NULLED("scene", fnl_scene_remove_instance(NULL, w.instance)))                              \
    X(fnl_scene_remove_light, NULLED("scene", fnl_scene_remove_light(NULL, w.light)))                                       \
    X(fnl_scene_remove_light_profile, NULLED("scene", fnl_scene_remove_light_profile(NULL, (fnl_light_profile_id){0, 1})))  \
    X(fnl_scene_remove_image, NULLED("scene", fnl_scene_remove_image(NULL, (fnl_image_id){0, 1})))                                       \
    X(fnl_scene_remove_material, NULLED("scene", fnl_scene_remove_material(NULL, w.material)))                              \
    X(fnl_scene_remove_mesh, NULLED("scene", fnl_scene_remove_mesh(NULL, w.mesh)))                                          \
    X(fnl_scene_remove_camera, NULLED("scene", fnl_scene_remove_camera(NULL, 0)))                                           \
    X(fnl_scene_remove_animation, NULLED("scene", fnl_scene_remove_animation(NULL, 0)))                                     \
    X(fnl_scene_scatter_decals, NULLED("scene", fnl_scene_scatter_decals(NULL, 1, 1)))                                      \
    X(fnl_scene_scatter_light_shapes, NULLED("scene", fnl_scene_scatter_light_shapes(NULL, &scatter));                      \
      NULLED("params", fnl_scene_scatter_light_shapes(w.scene, NULL)))                                                      \
    X(fnl_scene_set_ambient, NULLED("scene", fnl_scene_set_ambient(NULL, camera.up, camera.up)))                            \
    X(fnl_scene_set_anisotropy, NULLED("scene", fnl_scene_set_anisotropy(NULL, 1)))                                         \
    X(fnl_scene_set_texture_bias, NULLED("scene", fnl_scene_set_texture_bias(NULL, 1)))                                     \
    X(fnl_scene_set_origin, NULLED("scene", fnl_scene_set_origin(NULL, somewhere)))                                         \
    X(fnl_scene_query_origin, NULLED("scene", fnl_scene_query_origin(NULL, somewhere)))                                     \
    X(fnl_scene_set_background, NULLED("scene", fnl_scene_set_background(NULL, camera.up)))                                 \
    X(fnl_scene_set_decal, NULLED("scene", fnl_scene_set_decal(NULL, w.decal, &decal));                                     \
      NULLED("params", fnl_scene_set_decal(w.scene, w.decal, NULL)))                                                        \
    X(fnl_scene_set_environment, NULLED("scene", fnl_scene_set_environment(NULL, NULL));                                     \
      SILENT(fnl_scene_set_environment(w.scene, NULL)))                                                                     \
    X(fnl_scene_set_instance_receivers, NULLED("scene", fnl_scene_set_instance_receivers(NULL, w.instance, 1)))             \
    X(fnl_scene_set_instance_view_mask, NULLED("scene", fnl_scene_set_instance_view_mask(NULL, w.instance, 1)))             \
    X(fnl_scene_set_instance_light_mask, NULLED("scene", fnl_scene_set_instance_light_mask(NULL, w.instance, 1)))             \
    X(fnl_scene_set_instance_transforms,                                                                                    \
      NULLED("scene", fnl_scene_set_instance_transforms(NULL, &w.instance, &matrix, 1));                                    \
      NULLED("instances", fnl_scene_set_instance_transforms(w.scene, NULL, &matrix, 1));                                    \
      NULLED("transforms", fnl_scene_set_instance_transforms(w.scene, &w.instance, NULL, 1)))                               \
    X(fnl_scene_set_lights, NULLED("scene", fnl_scene_set_lights(NULL, &w.light, &light, 1));                               \
      NULLED("lights", fnl_scene_set_lights(w.scene, NULL, &light, 1));                                                     \
      NULLED("params", fnl_scene_set_lights(w.scene, &w.light, NULL, 1)))                                                   \
    X(fnl_scene_set_mesh, NULLED("scene", fnl_scene_set_mesh(NULL, w.mesh, 0, &mesh));                                      \
      NULLED("params", fnl_scene_set_mesh(w.scene, w.mesh, 0, NULL)))                                                       \
    X(fnl_scene_set_pose, NULLED("scene", fnl_scene_set_pose(NULL, w.instance, &pose));                                     \
      NULLED("pose", fnl_scene_set_pose(w.scene, w.instance, NULL)))                                                        \
    X(fnl_scene_query_mesh, NULLED("scene", fnl_scene_query_mesh(NULL, 0, 0, &mesh_info));                                  \
      NULLED("out", fnl_scene_query_mesh(w.scene, 0, 0, NULL)))                                                             \
    X(fnl_scene_set_light_cutoff, NULLED("scene", fnl_scene_set_light_cutoff(NULL, 1, 1)))                                  \
    X(fnl_scene_set_light_hull, NULLED("scene", fnl_scene_set_light_hull(NULL, w.light, NULL, 0));                          \
      SILENT(fnl_scene_set_light_hull(w.scene, w.light, NULL, 0)))                                                          \
    X(fnl_scene_set_time, NULLED("scene", fnl_scene_set_time(NULL, 0, 0)))                                                  \
    X(fnl_scene_trace, NULLED("scene", fnl_scene_trace(NULL, &trace_params, &traced));                                      \
      NULLED("out", fnl_scene_trace(w.scene, &trace_params, NULL)); TRACES_BY_DEFAULT)                                      \
    X(fnl_vulkan_requirements_init, DOES("requirements", fnl_vulkan_requirements_init(NULL)))

#define ROW(name, ...)                                                                                                      \
    static void try_##name(void) { __VA_ARGS__; }
EXPORTS(ROW)
#undef ROW

static const struct {
    const char *name;
    void (*run)(void);
} exports[] = {
#define ROW(name, ...) {#name, try_##name},
    EXPORTS(ROW)
#undef ROW
};

static char headers[256 << 10];

static void read_headers(void) {
    glob_t found;
    size_t length = 0;
    assert_int_equal(glob("include/fanal/*.h", 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        FILE *file = fopen(found.gl_pathv[i], "r");
        assert_non_null(file);
        length += fread(headers + length, 1, sizeof headers - 1 - length, file);
        fclose(file);
    }
    globfree(&found);
    assert_true(length < sizeof headers - 1);
}

/* Pointers among the arguments of a function's declaration. */
static uint32_t count_pointers(const char *name) {
    char start[128];
    snprintf(start, sizeof start, "%.99s(", name);
    for (const char *line = headers; (line = strstr(line, "\nFNL_API")); line++) {
        const char *at = strstr(line, start), *end = strchr(line, ';');
        if (!at || at > end) continue;
        uint32_t count = 0;
        for (at += strlen(start); at < end; at++) count += *at == '*' && at[1] != '*';
        return count;
    }
    fail_msg("%s is not declared", name);
    return 0;
}

/* Functions that are no row of the table have no pointers. */
static void test_null_is_named_by_every_export(void **state) {
    UNUSED(state);
    read_headers();
    FILE *list = fopen("docs/api.txt", "r");
    assert_non_null(list);
    char name[100];
    uint32_t found = 0;
    while (fscanf(list, "%99s", name) == 1) {
        uint32_t row = 0, pointers = count_pointers(name);
        while (row < COUNT_OF(exports) && strcmp(exports[row].name, name) != 0) row++;
        if (row == COUNT_OF(exports)) {
            if (pointers) fail_msg("%s takes %u pointers, but is not in the table of this test", name, pointers);
            continue;
        }
        found++;
        w.function = exports[row].name;
        w.tried = 0;
        exports[row].run();
        if (w.tried != pointers) fail_msg("%s takes %u pointers, %u are tried", name, pointers, w.tried);
    }
    fclose(list);
    assert_int_equal(found, COUNT_OF(exports));
}

/* ---- fields out of their range ---- */

#define LIGHT(of, field, value, words)                                                                                      \
    do {                                                                                                                    \
        light = fnl_light_params_default();                                                                                 \
        light.kind = FNL_LIGHT_##of;                                                                                        \
        light.field = value;                                                                                                \
        SAYS("fnl_scene_add_light", words, fnl_scene_add_light(w.scene, &light, &light_id));                                \
        SAYS("fnl_scene_set_lights", words, fnl_scene_set_light(w.scene, w.light, &light));                                  \
        light = fnl_light_params_default();                                                                                 \
    } while (0)

static void test_fields_of_lights(void **state) {
    UNUSED(state);
    LIGHT(POINT, kind, (fnl_light_kind)-1, "kind is -1, must be a value of fnl_light_kind, 0 .. 6");
    LIGHT(POINT, kind, (fnl_light_kind)77, "kind is 77, must be a value of fnl_light_kind, 0 .. 6");
    LIGHT(POINT, shadow_update, (fnl_shadow_update)2, "shadow_update is 2, must be a value of fnl_shadow_update, 0 .. 1");
    LIGHT(POINT, position.y, NAN, "position.y is NaN, must be finite");
    LIGHT(POINT, position.x, -INFINITY, "position.x is -infinity, must be finite");
    LIGHT(SPOT, direction.z, INFINITY, "direction.z is infinity, must be finite");
    LIGHT(SPOT, direction.z, 0, "direction is 0, 0, 0, must have a length");
    LIGHT(POINT, color[1], -0.5f, "color[1] is -0.5, must be at least 0 and finite");
    LIGHT(POINT, color[2], NAN, "color[2] is NaN, must be at least 0 and finite");
    LIGHT(POINT, intensity, -2, "intensity is -2, must be at least 0 candela and finite");
    LIGHT(POINT, intensity, INFINITY, "intensity is infinity, must be at least 0 candela and finite");
    LIGHT(DIRECTIONAL, intensity, NAN, "intensity is NaN, must be at least 0 lux and finite");
    LIGHT(POINT, range, -3, "range is -3, must be above 0 metres");
    LIGHT(POINT, range, 0, "range is 0, must be above 0 metres");
    LIGHT(SPOT, range, NAN, "range is NaN, must be above 0 metres");
    LIGHT(SPOT, outer_cone_angle, 2, "outer_cone_angle is 2, must be above 0 and at most 1.5708 radians");
    LIGHT(SPOT, outer_cone_angle, NAN, "outer_cone_angle is NaN, must be above 0 and at most 1.5708 radians");
    LIGHT(SPOT, inner_cone_angle, 1, "inner_cone_angle is 1, must be 0 .. 0.785398 radians (outer_cone_angle)");
    LIGHT(CAPSULE, length, -1, "length is -1, must be at least 0 metres and finite");
    LIGHT(WEDGE, wedge_angles[0], 1.6f, "wedge_angles[0] is 1.6, must be above 0 and at most 1.5 radians");
    LIGHT(WEDGE, wedge_angles[1], NAN, "wedge_angles[1] is NaN, must be above 0 and at most 1.5 radians");
    LIGHT(WEDGE, up.x, INFINITY, "up.x is infinity, must be finite");
    LIGHT(BOX, box_size.y, INFINITY, "box_size.y is infinity, must be 1.17549e-38 .. 1e+18 metres");
    LIGHT(RECTANGLE, rectangle_size[0], 0, "rectangle_size[0] is 0, must be 1e-09 .. 1e+09 metres");
    LIGHT(RECTANGLE, rectangle_size[1], NAN, "rectangle_size[1] is NaN, must be 1e-09 .. 1e+09 metres");
    LIGHT(RECTANGLE, up.y, INFINITY, "up.y is infinity, must be finite");
    LIGHT(BOX, inner_fraction, 1.5f, "inner_fraction is 1.5, must be 0 .. 1");
    LIGHT(BOX, inner_fraction, 1.0000001f, "inner_fraction is 1.0000001, must be 0 .. 1");
    LIGHT(BOX, source_angle, 2, "source_angle is 2, must be 0 .. 1 radians");
    LIGHT(DIRECTIONAL, source_angle, -1, "source_angle is -1, must be 0 .. 1 radians");
    LIGHT(SPOT, source_radius, NAN, "source_radius is NaN, must be at least 0 metres and finite");
    LIGHT(CAPSULE, source_radius, INFINITY, "source_radius is infinity, must be at least 0 metres and finite");
}

#define MATERIAL(field, value, words)                                                                                       \
    do {                                                                                                                    \
        material = fnl_material_params_default();                                                                           \
        material.field = value;                                                                                             \
        SAYS("fnl_scene_add_material", words, fnl_scene_add_material(w.scene, &material, &material_id));                    \
        SAYS("fnl_scene_set_material", words, fnl_scene_set_material(w.scene, w.material, &material));                      \
        material = fnl_material_params_default();                                                                           \
    } while (0)

static void test_fields_of_materials(void **state) {
    UNUSED(state);
    const fnl_image_id unknown = {400, 1};
    MATERIAL(base_color[3], 1.5f, "base_color[3] is 1.5, must be 0 .. 1");
    MATERIAL(metallic, NAN, "metallic is NaN, must be 0 .. 1");
    MATERIAL(roughness, -1, "roughness is -1, must be 0 .. 1");
    MATERIAL(emissive[0], INFINITY, "emissive[0] is infinity, must be at least 0 cd/m^2 and finite");
    MATERIAL(normal_scale, NAN, "normal_scale is NaN, must be finite");
    MATERIAL(occlusion_strength, 2, "occlusion_strength is 2, must be 0 .. 1");
    MATERIAL(ior, 0.5f, "ior is 0.5, must be 0, or at least 1 and finite");
    MATERIAL(specular, INFINITY, "specular is infinity, must be 0 .. 1");
    MATERIAL(specular_color[2], -1, "specular_color[2] is -1, must be at least 0 and finite");
    MATERIAL(alpha_mode, (fnl_alpha_mode)3, "alpha_mode is 3, must be a value of fnl_alpha_mode, 0 .. 2");
    MATERIAL(alpha_cutoff, NAN, "alpha_cutoff is NaN, must be at least 0 and finite");
    MATERIAL(base_color_image, unknown, "base_color_image (index 400, generation 1) must be the id of an image that is in the scene");
    MATERIAL(emissive_image, unknown, "emissive_image (index 400, generation 1) must be the id of an image that is in the scene");
}

#define DECAL(field, value, words)                                                                                          \
    do {                                                                                                                    \
        decal = fnl_decal_params_default();                                                                                 \
        decal.field = value;                                                                                                \
        SAYS("fnl_scene_add_decal", words, fnl_scene_add_decal(w.scene, &decal, &decal_id));                                \
        SAYS("fnl_scene_set_decal", words, fnl_scene_set_decal(w.scene, w.decal, &decal));                                  \
        decal = fnl_decal_params_default();                                                                                 \
    } while (0)

static void test_fields_of_decals(void **state) {
    UNUSED(state);
    DECAL(kind, (fnl_decal_kind)9, "kind is 9, must be a value of fnl_decal_kind, 0 .. 4");
    DECAL(blend, (fnl_decal_blend)-4, "blend is -4, must be a value of fnl_decal_blend, 0 .. 4");
    DECAL(transform.m[3], 1, "transform is not affine and invertible, must be both");
    DECAL(transform.m[5], 0, "transform is not affine and invertible, must be both");
    DECAL(transform.m[5], NAN, "transform.m[5] is NaN, must be finite");
    DECAL(kind, FNL_DECAL_MESH, "instance is the empty id, must be that of an instance of the scene");
    DECAL(color[0], 2, "color[0] is 2, must be 0 .. 1");
    DECAL(metallic, -1, "metallic is -1, must be 0 .. 1");
    DECAL(roughness, NAN, "roughness is NaN, must be 0 .. 1");
    DECAL(normal_scale, INFINITY, "normal_scale is infinity, must be finite");
    DECAL(emissive[1], -1, "emissive[1] is -1, must be at least 0 cd/m^2 and finite");
    DECAL(channels, 32, "channels is 32, must be 0 .. 31");
    DECAL(fade_start, -1, "fade_start is -1, must be 0 .. 3.14159 radians");
    DECAL(fade_end, 0.5f, "fade_end is 0.5, must be 1.13446 .. 3.14159 radians (fade_start .. pi)");
    DECAL(receivers, 256, "receivers is 256, must be 0 .. 255");
    DECAL(cut, 2, "cut is 2, must be 0 .. 1");
    DECAL(slices, 0, "slices is 0, must be 1 .. 4096");
}

#define MESH(field, value, words)                                                                                           \
    do {                                                                                                                    \
        fnl_mesh_params good = mesh;                                                                                        \
        mesh.field = value;                                                                                                 \
        SAYS("fnl_scene_add_mesh", words, fnl_scene_add_mesh(w.scene, &mesh, &mesh_id));                                    \
        mesh = good;                                                                                                        \
    } while (0)
#define CAMERA(field, value, words)                                                                                         \
    do {                                                                                                                    \
        camera = fnl_camera_default();                                                                                      \
        camera.field = value;                                                                                               \
        SAYS("fnl_scene_add_camera", words, fnl_scene_add_camera(w.scene, "c", &camera));                                   \
        camera = fnl_camera_default();                                                                                      \
    } while (0)

static void test_other_arguments(void **state) {
    UNUSED(state);
    const float broken[9] = {0, 0, 0, 0, NAN};
    MESH(vertex_count, 0, "vertex_count is 0, must be 1 .. 4294967294");
    MESH(vertex_count, 2, "vertex_count (without indices) is 2, must be a multiple of 3");
    MESH(index_count, 3, "indices is NULL, but index_count is 3; both or neither must be there");
    MESH(positions, NULL, "positions is NULL");
    MESH(positions, broken, "positions[4] is NaN, must be finite");
    MESH(uv, broken, "uv[4] is NaN, must be finite");
    CAMERA(position.x, NAN, "position.x is NaN, must be finite");
    CAMERA(target.z, 5, "target is the position, must be another point");
    CAMERA(up.y, 0, "up is 0, 0, 0, must have a length");
    CAMERA(near_distance, 0, "near_distance is 0, must be above 0 metres and finite");
    CAMERA(vertical_fov, 4, "vertical_fov is 4, must be above 0 and below pi radians");
    CAMERA(shift.y, INFINITY, "shift.y is infinity, must be finite");

    fnl_mat4 bad = matrix;
    bad.m[15] = 2;
    SAYS("fnl_scene_set_instance_transforms", "the last row of transform is 0, 0, 0, 2, must be 0, 0, 0, 1",
         fnl_scene_set_instance_transform(w.scene, w.instance, &bad));
    bad.m[15] = NAN;
    SAYS("fnl_scene_add_instance", "transform.m[15] is NaN, must be finite",
         fnl_scene_add_instance(w.scene, w.mesh, &bad, &instance_id));
    SAYS("fnl_scene_remove_light", "light is the empty id, must be that of a light of the scene",
         fnl_scene_remove_light(w.scene, (fnl_light_id){0}));
    SAYS("fnl_scene_remove_instance", "instance (index 0, generation 99) must be the id of an instance that is in the scene",
         fnl_scene_remove_instance(w.scene, (fnl_instance_id){0, 99}));
    SAYS("fnl_scene_refresh_shadows", "element 1: light is the empty id, must be that of a light of the scene",
         fnl_scene_refresh_shadows(w.scene, (const fnl_light_id[2]){w.light}, 2));
    SAYS("fnl_scene_set_light_hull", "count is 3, must be 4 .. 64",
         fnl_scene_set_light_hull(w.scene, w.light, (const fnl_vec3[3]){{0}}, 3));
    SAYS("fnl_scene_set_light_cutoff", "min_roughness is 2, must be 0 .. 1", fnl_scene_set_light_cutoff(w.scene, 2, 1));
    SAYS("fnl_scene_set_light_cutoff", "threshold is NaN, must be at least 0 lux and finite",
         fnl_scene_set_light_cutoff(w.scene, 1, NAN));
    SAYS("fnl_scene_set_ambient", "ground.y is -1, must be at least 0 cd/m^2 and finite",
         fnl_scene_set_ambient(w.scene, (fnl_vec3){0}, (fnl_vec3){0, -1, 0}));
    fnl_probe_params placed = fnl_probe_params_default();
    SAYS("fnl_scene_place_probes", "most is 0, must be 1 .. 64", fnl_scene_place_probes(w.scene, &placed, 0, NULL));
    placed.wall = 0;
    SAYS("fnl_scene_place_probes", "wall is 0, must be above 0 m and finite", fnl_scene_place_probes(w.scene, &placed, 4, NULL));
    fnl_environment_params environment = fnl_environment_params_default();
    SAYS("fnl_scene_set_environment", "source and image are both NULL, must be one of them: the scene has no environment to keep", fnl_scene_set_environment(w.scene, &environment));
    environment.source = "builtin:sky";
    environment.intensity = -1;
    SAYS("fnl_scene_set_environment", "intensity is -1, must be 0 .. 1e+06", fnl_scene_set_environment(w.scene, &environment));
    SAYS("fnl_scene_query_environment", "the scene has no environment", fnl_scene_query_environment(w.scene, &environment));
    SAYS("fnl_scene_set_origin", "origin[1] is 2e+12, must be -1e+12 .. 1e+12 m", fnl_scene_set_origin(w.scene, (const double[]){0, 2e12, 0}));
    SAYS("fnl_scene_set_texture_bias", "levels is 17, must be -16 .. 16 levels of detail", fnl_scene_set_texture_bias(w.scene, 17));
    SAYS("fnl_scene_set_anisotropy", "anisotropy is 17, must be 1 .. 16", fnl_scene_set_anisotropy(w.scene, 17));
    SAYS("fnl_scene_set_time", "seconds is nan, must be finite", fnl_scene_set_time(w.scene, 0, (double)NAN));
    SAYS("fnl_scene_set_times", "count is 0, must be 1 .. 1024", fnl_scene_set_times(w.scene, &moment, 0));
    SAYS("fnl_scene_set_times", "seconds is inf, must be finite", fnl_scene_set_times(w.scene, &(fnl_animation_time){0, (double)INFINITY, 1}, 1));
    SAYS("fnl_scene_set_times", "weight is -1, must be 0 .. 1e+06", fnl_scene_set_times(w.scene, &(fnl_animation_time){0, 0, -1}, 1));
    SAYS("fnl_scene_set_times", "element 1: animation is 3, but there are no animations",
         fnl_scene_set_times(w.scene, (const fnl_animation_time[]){{0, 0, 1}, {3, 0, 1}}, 2));
    SAYS("fnl_scene_set_times", "all weights are 0, one must be above", fnl_scene_set_times(w.scene, &(fnl_animation_time){0, 0, 0}, 1));
    SAYS("fnl_scene_set_time", "animation is 1, but there are no animations", fnl_scene_set_time(w.scene, 1, 0));
    SAYS("fnl_scene_select_variant", "variant is 0, but there are no variants", fnl_scene_select_variant(w.scene, 0));
    SAYS("fnl_scene_grow_metal", "texels is 65, must be 0 .. 64", fnl_scene_grow_metal(w.scene, 65));
    scatter.radius_scale = 0;
    SAYS("fnl_scene_scatter_light_shapes", "radius_scale is 0, must be above 0 and finite",
         fnl_scene_scatter_light_shapes(w.scene, &scatter));
    scatter = fnl_scatter_params_default();
    scatter.shares[2] = -1;
    SAYS("fnl_scene_scatter_light_shapes", "shares[2] is -1, must be at least 0 and finite",
         fnl_scene_scatter_light_shapes(w.scene, &scatter));
    scatter = fnl_scatter_params_default();
    SAYS("fnl_image_difference_picture", "gain is -1, must be at least 0 and finite",
         fnl_image_difference_picture(NULL, &picture, &other, -1, &difference_image));
    SAYS("fnl_eye_query_camera", "width is 0, must be 1 .. 16384", fnl_eye_query_camera(NULL, &eye, &head, 0, 1, 1, &camera));
    SAYS("fnl_eye_query_cells", "width is 2, must be 3 .. 16384", fnl_eye_query_cells(NULL, &eye, 2, 9, 1, 1, cells));
    SAYS("fnl_eye_query_cells", "scale is 0, must be above 0 and at most 1", fnl_eye_query_cells(NULL, &eye, 9, 9, 1, 0, cells));
    SAYS("fnl_eye_query_quadrants", "height is 1, must be 2 .. 16384", fnl_eye_query_quadrants(NULL, &eye, 9, 1, corners[0], cells));
    SAYS("fnl_eye_query_quadrants", "strength.x is 2, must be 0 .. 1", fnl_eye_query_quadrants(NULL, &eye, 9, 9, (fnl_vec2){2, 0}, cells));
    SAYS("fnl_eye_query_quadrants", "eye: its axis is outside of its picture, or at the edge: left 0.5, right 1, down -1, up 1",
         fnl_eye_query_quadrants(NULL, &(fnl_eye){{{0, 0, 0}, {0, 0, 0, 1}}, 0.5f, 1, -1, 1}, 9, 9, corners[0], cells));
    SAYS("fnl_eye_query_quadrants", "quadrants would need 7 x 16385 pixels, must be within 16384: eye is too uneven",
         fnl_eye_query_quadrants(NULL, &(fnl_eye){{{0, 0, 0}, {0, 0, 0, 1}}, -1, 1, -0.001f, 20}, 9, 16384, (fnl_vec2){0, 0}, cells));
    SAYS("fnl_eye_query_cells", "eye: edges are 1 .. 1 and -1 .. 1, must ascend and lie within 10000",
         fnl_eye_query_cells(NULL, &(fnl_eye){{{0, 0, 0}, {0, 0, 0, 1}}, 1, 1, -1, 1}, 9, 9, 1, 1, cells));
    SAYS("fnl_eye_join_cells", "cell_count is 0, must be 1 .. 64", fnl_eye_join_cells(NULL, &eye, cells, 0, &picture, &joined));
    SAYS("fnl_eye_join_cells", "cells[0].eye: edges must ascend",
         fnl_eye_join_cells(NULL, &eye, &(fnl_eye_cell){.eye = {.pose.rotation.w = 1, .left = 1, .right = 1, .down = -1, .up = 1}}, 1, &picture, &joined));
    SAYS("fnl_eye_join_cells", "cells[0].eye.pose.rotation is 0, 0, 0, 0, must be a unit quaternion",
         fnl_eye_join_cells(NULL, &eye, &(fnl_eye_cell){.eye = {.left = -1, .right = 1, .down = -1, .up = 1}}, 1, &picture, &joined));
    SAYS("fnl_scene_remove_mesh", "mesh (index 0) is still used by 1 instance", fnl_scene_remove_mesh(w.scene, w.mesh));
    SAYS("fnl_hidden_area_round", "segments is 2, must be 3 .. 1024", fnl_hidden_area_round(NULL, &eye, corners[0], 1, 2, corners, &hidden_area));
    SAYS("fnl_hidden_area_round", "radius is 0, must be above 0 and at most 10000", fnl_hidden_area_round(NULL, &eye, corners[0], 0, 3, corners, &hidden_area));
    SAYS("fnl_exr_save", "width is 0, must be 1 .. 32768", fnl_exr_save(NULL, "x.exr", 0, 1, &channel, 1));
    SAYS("fnl_exr_save", "channels[0].name is NULL",
         fnl_exr_save(NULL, "x.exr", 1, 1, &(fnl_exr_channel){.values = (const float[]){1}, .stride = 1}, 1));
    fnl_device_params params = fnl_device_params_default();
    params.index = -2;
    SAYS("fnl_device_create", "index is -2, must be -1 or the number of a device", fnl_device_create(&params, &made_device));
}

/* ---- frames ---- */

#define FRAME(field, value, words)                                                                                          \
    do {                                                                                                                    \
        frame = small_frame();                                                                                              \
        frame.field = value;                                                                                                \
        SAYS("fnl_renderer_render", words, fnl_renderer_render(w.renderer, &frame));                                        \
        frame = small_frame();                                                                                              \
    } while (0)
#define FRAME_ENUM(field, type, most)                                                                                       \
    do {                                                                                                                    \
        char words_[128];                                                                                                   \
        for (int value_ = -1; value_ <= 1000; value_ += 1001) {                                                             \
            snprintf(words_, sizeof words_, #field " is %d, must be a value of " #type ", 0 .. %d", value_, (int)(most));   \
            FRAME(field, (type)value_, words_);                                                                             \
        }                                                                                                                   \
    } while (0)

static fnl_frame small_frame(void) {
    fnl_frame small = frame_plain();
    small.width = 16;
    small.height = 9;
    small.lists = FNL_LISTS_ALL;
    return small;
}

static void test_fields_of_frames(void **state) {
    UNUSED(state);
    FRAME(width, 0, "width is 0, must be 1 .. 16384");
    FRAME(height, 16385, "height is 16385, must be 1 .. 16384");
    FRAME(camera.position.y, NAN, "camera.position.y is NaN, must be finite");
    camera.vertical_fov = 0;
    FRAME(viewer, &camera, "viewer->vertical_fov is 0, must be above 0 and below pi radians");
    camera = fnl_camera_default();
    const fnl_vec3 nowhere = {0, NAN, 0};
    FRAME(gaze, &nowhere, "gaze[1] is NaN, must be -1e+09 .. 1e+09 metres");
    FRAME(camera.vertical_fov, -1, "camera.vertical_fov is -1, must be above 0 and below pi radians");
    FRAME(camera.near_distance, INFINITY, "camera.near_distance is infinity, must be above 0 metres and finite");
    FRAME_ENUM(shading, fnl_shading, FNL_SHADING_COUNT - 1);
    FRAME_ENUM(lists, fnl_light_lists, FNL_LISTS_COUNT - 1);
    FRAME_ENUM(deferred.msaa_method, fnl_msaa_method, 5);
    FRAME_ENUM(transparency, fnl_transparency, 2);
    FRAME_ENUM(decals, fnl_decals, 2);
    FRAME_ENUM(culling, fnl_culling, 2);
    FRAME_ENUM(geometry, fnl_geometry, 2);
    FRAME_ENUM(aa, fnl_antialiasing, 4);
    FRAME_ENUM(ground, fnl_ground, 2);
    FRAME_ENUM(background, fnl_background, 3);
    FRAME(background_blur, NAN, "background_blur is NaN, must be 0 .. 3.14159 radians");
    FRAME_ENUM(tonemap, fnl_tonemap, 3);
    FRAME_ENUM(exposure, fnl_exposure, 2);
    FRAME_ENUM(gbuffer.layout, fnl_gbuffer, 8);
    FRAME_ENUM(gbuffer.normals, fnl_normal_encoding, 9);
    FRAME_ENUM(deferred.pass, fnl_deferred_pass, 1);
    FRAME_ENUM(texturing.gradients, fnl_gradients, 1);
    FRAME_ENUM(mobile.layout, fnl_mobile_layout, 3);
    FRAME_ENUM(mobile.gamma, fnl_mobile_gamma, 2);
    FRAME_ENUM(mobile.light, fnl_mobile_light, 1);
    FRAME_ENUM(mobile.lights, fnl_mobile_lights, 1);
    FRAME_ENUM(visibility.sort, fnl_visibility_sort, 2);
    FRAME_ENUM(coarse.criterion, fnl_coarse_criterion, 2);
    FRAME_ENUM(coarse.split, fnl_coarse_split, 3);
    FRAME_ENUM(coarse.filter, fnl_coarse_filter, 2);
    FRAME_ENUM(dais.mode, fnl_dais_mode, 1);
    FRAME_ENUM(tiles.bounds, fnl_tile_bounds, 2);
    FRAME_ENUM(list.backface_axis, fnl_backface_axis, 2);
    FRAME_ENUM(clusters.distribution, fnl_slices, 1);
    FRAME_ENUM(raster.path, fnl_raster_path, 2);
    FRAME_ENUM(raster.nodes, fnl_raster_nodes, 2);
    FRAME_ENUM(volume_shape, fnl_volume_shape, 5);
    FRAME_ENUM(light_buffer.kind, fnl_light_buffer, 4);
    FRAME_ENUM(light_indexed.packing, fnl_light_packing, 4);
    FRAME(tiles.size, 12, "tiles.size is 12, must be 8, 16, 32 or 64");
    FRAME(fine.masks, 3, "fine.masks is 3, must be 0 .. 2");
    FRAME(clusters.size, 7, "clusters.size is 7, must be 8 .. 256");
    FRAME(clusters.slices, 0, "clusters.slices is 0, must be 1 .. 1024");
    FRAME(light_indexed.layers, 17, "light_indexed.layers is 17, must be 1 .. 16");
    FRAME(volume_batch, 0, "volume_batch is 0, must be 1 .. 64");
    FRAME(light_buffer.scale, 3, "light_buffer.scale is 3, must be 2 or 4");
    FRAME(clusters.near, NAN, "clusters.near is NaN, must be above 0 metres");
    FRAME(clusters.far, 0, "clusters.far is 0, must be above 0 metres");
    FRAME(msaa, 3, "msaa is 3, must be 1, 2, 4 or 8");
    FRAME(deferred.msaa_groups, 4, "deferred.msaa_groups is 4, must be 2 or 3");
    FRAME(deferred.msaa_tolerance, NAN, "deferred.msaa_tolerance is NaN, must be 0 .. 1");
    FRAME(jitter.y, -9, "jitter.y is -9, must be -8 .. 8 pixels");
    FRAME(outputs, 128, "outputs is 128, must be 0 .. 127");
    FRAME(deferred.class_blocks, 5, "deferred.class_blocks is 5, must be 0, 4 or 8");
    FRAME(light_lod, NAN, "light_lod is NaN, must be at least 0 pixels and finite");
    FRAME(texturing.atlas_size, 300, "texturing.atlas_size is 300, must be a multiple of 256");
    FRAME(texturing.atlas_size, 0, "texturing.atlas_size is 0, must be 256 .. 8192");
    FRAME(shade_cost, 100001, "shade_cost is 100001, must be 0 .. 100000");
    FRAME(mobile.range, 0, "mobile.range is 0, must be above 0 and finite");
    FRAME(coarse.size, 3, "coarse.size is 3, must be 1, 2 or 4");
    FRAME(coarse.depth_factor, -1, "coarse.depth_factor is -1, must be at least 0 and finite");
    FRAME(coarse.normal_degrees, 181, "coarse.normal_degrees is 181, must be 0 .. 180 degrees");
    FRAME(coarse.tolerance, NAN, "coarse.tolerance is NaN, must be 0 .. 1");
    FRAME(coarse.albedo_tolerance, 2, "coarse.albedo_tolerance is 2, must be 0 .. 1");
    FRAME(coarse.ao_radius, INFINITY, "coarse.ao_radius is infinity, must be at least 0 metres and finite");
    FRAME(coarse.fovea, 181, "coarse.fovea is 181, must be 0 .. 180 degrees");
    FRAME(coarse.fovea_far, NAN, "coarse.fovea_far is NaN, must be 0 .. 180 degrees");
    FRAME(dais.cache_buckets, 3, "dais.cache_buckets is 3, must be a power of two");
    FRAME(dais.cache_buckets, 0, "dais.cache_buckets is 0, must be 1 .. 4194304");
    frame.exposure = FNL_EXPOSURE_EV;
    frame.ev = NAN;
    SAYS("fnl_renderer_render", "ev is NaN, must be -64 .. 64 EV100", fnl_renderer_render(w.renderer, &frame));
    frame = small_frame();
    frame.pixel = (fnl_pixel_query){true, 16, 0, 0};
    SAYS("fnl_renderer_render", "pixel.x is 16, must be 0 .. 15", fnl_renderer_render(w.renderer, &frame));
    frame.pixel = (fnl_pixel_query){true, 0, 9, 0};
    SAYS("fnl_renderer_render", "pixel.y is 9, must be 0 .. 8", fnl_renderer_render(w.renderer, &frame));
    frame.pixel = (fnl_pixel_query){true, 0, 0, 1};
    SAYS("fnl_renderer_warm", "pixel.view is 1, must be 0 .. 0", fnl_renderer_warm(w.renderer, &frame, NULL, false, NULL));
    frame = small_frame();
    SAYS("fnl_renderer_query_pixel", "no frame has been rendered", fnl_renderer_query_pixel(w.renderer, &pixel_info));
#define PRINTS(what, text, capacity) (fnl_renderer_print(w.renderer, what, text, capacity) ? FNL_OK : FNL_ERROR_INVALID)
    SAYS("fnl_renderer_print", "what is 3, must be a value of fnl_print, 0 .. 2", PRINTS(FNL_PRINT_COUNT, NULL, 0));
    SAYS("fnl_renderer_print", "what is -1, must be a value of fnl_print, 0 .. 2", PRINTS((fnl_print)-1, NULL, 0));
    SAYS("fnl_renderer_print", "text is NULL, but capacity is 9", PRINTS(FNL_PRINT_TRAFFIC, NULL, 9));
    SAYS("fnl_renderer_print", "text is NULL, but capacity is 9", PRINTS(FNL_PRINT_PLAN_JSON, NULL, 9));
    SAYS("fnl_renderer_read", "output is 3, must be one value of fnl_output",
         fnl_renderer_read(w.renderer, (fnl_output)3, &difference_image));
}

#ifdef FANAL_RAY
static void test_fields_of_traces(void **state) {
    UNUSED(state);
#define TRACE(field, value, words)                                                                                          \
    do {                                                                                                                    \
        fnl_trace_params p = trace_plain();                                                                    \
        p.field = value;                                                                                                    \
        SAYS("fnl_scene_trace", words, fnl_scene_trace(w.scene, &p, &traced));                                              \
    } while (0)
    TRACE(width, 0, "width is 0, must be 1 .. 16384");
    TRACE(height, 16385, "height is 16385, must be 1 .. 16384");
    TRACE(camera.vertical_fov, 4, "camera.vertical_fov is 4, must be above 0 and below pi radians");
    TRACE(samples, 0, "samples is 0, must be 1 .. 1048576");
    TRACE(bounces, 1025, "bounces is 1025, must be 0 .. 1024");
    TRACE(light_radius, NAN, "light_radius is NaN, must be at least 0 metres and finite");
    TRACE(sun_angle, 2, "sun_angle is 2, must be 0 .. 1 radians");
    TRACE(ground, (fnl_ground)3, "ground is 3, must be a value of fnl_ground, 0 .. 2");
    TRACE(background, (fnl_background)4, "background is 4, must be a value of fnl_background, 0 .. 3");
    TRACE(background_blur, -1, "background_blur is -1, must be 0 .. 3.14159 radians");
    TRACE(tonemap, (fnl_tonemap)9, "tonemap is 9, must be a value of fnl_tonemap, 0 .. 3");
    TRACE(exposure, (fnl_exposure)3, "exposure is 3, must be a value of fnl_exposure, 0 .. 2");
    TRACE(ev, 65, "ev is 65, must be -64 .. 64 EV100");
}
#endif

/* What is valid by itself, but not together or not on this device, is told of in the same way. */
static void test_unsupported_frames(void **state) {
    UNUSED(state);
#define UNSUPPORTED(words, ...)                                                                                             \
    do {                                                                                                                    \
        frame = small_frame();                                                                                              \
        __VA_ARGS__;                                                                                                        \
        SAYS_OF(FNL_ERROR_UNSUPPORTED, "fnl_renderer_render", words, fnl_renderer_render(w.renderer, &frame));              \
        frame = small_frame();                                                                                              \
    } while (0)
    UNSUPPORTED("mesh lists do not work with deferred shading", frame.lists = FNL_LISTS_MESH);
    UNSUPPORTED("mobile shading has no MSAA; use another path, or 1 sample", frame.shading = FNL_SHADING_MOBILE, frame.msaa = 4);
    UNSUPPORTED("deferred.pass=fragment needs deferred.class-blocks=0 and 1 sample per pixel", frame.deferred.pass = FNL_DEFERRED_FRAGMENT,
                frame.deferred.class_blocks = 8);
    UNSUPPORTED("the debug view dais-addresses needs dais shading, not deferred", frame.debug = FNL_DEBUG_DAIS_ADDRESSES);
    UNSUPPORTED("motion vectors and temporal antialiasing need 1 sample per pixel, not 4", frame.aa = FNL_ANTIALIASING_TAA,
                frame.msaa = 4);
}

/* ---- the whole ---- */

static bool make_swapchain(void) {
    fnl_vulkan_handles handles_of;
    if (fnl_device_query_vulkan(w.device, &handles_of) != FNL_OK) return false;
    PFN_vkCreateHeadlessSurfaceEXT create =
        (PFN_vkCreateHeadlessSurfaceEXT)handles_of.get_instance_proc_addr(handles_of.instance, "vkCreateHeadlessSurfaceEXT");
    const VkHeadlessSurfaceCreateInfoEXT headless = {.sType = VK_STRUCTURE_TYPE_HEADLESS_SURFACE_CREATE_INFO_EXT};
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    return create && create(handles_of.instance, &headless, NULL, &surface) == VK_SUCCESS && fnl_swapchain_create(w.device, surface, NULL, &w.swapchain) == FNL_OK;
}

static int set_up(void **state) {
    UNUSED(state);
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static uint8_t pixels[2][4];
    w.kept = tmpfile();
    host = fnl_host_default();
    picture = other = (fnl_image){1, 1, FNL_PIXEL_FORMAT_RGBA8, pixels[0]};
    other.pixels = pixels[1];
    channel = (fnl_exr_channel){"R", triangle, 1};
    material = fnl_material_params_default();
    mesh = (fnl_mesh_params){.vertex_count = 3, .positions = triangle};
    light = fnl_light_params_default();
    decal = fnl_decal_params_default();
    probe = fnl_probe_params_default();
    camera = fnl_camera_default();
    scatter = fnl_scatter_params_default();
    matrix = mat4_identity();
    frame = small_frame();
    fnl_device_params params = fnl_device_params_default();
    params.cache_folder = "";
    params.presentation = true;
    bool good = w.kept && fnl_scene_create(NULL, &w.scene) == FNL_OK && fnl_scene_add_mesh(w.scene, &mesh, &w.mesh) == FNL_OK &&
                fnl_scene_add_material(w.scene, &material, &w.material) == FNL_OK &&
                fnl_scene_add_instance(w.scene, w.mesh, &matrix, &w.instance) == FNL_OK &&
                fnl_scene_add_light(w.scene, &light, &w.light) == FNL_OK &&
                fnl_scene_add_decal(w.scene, &decal, &w.decal) == FNL_OK && fnl_scene_add_probe(w.scene, &probe, &w.probe) == FNL_OK &&
                fnl_device_create(&params, &w.device) == FNL_OK &&
                fnl_renderer_create(w.device, w.scene, &w.renderer) == FNL_OK && fnl_compositor_create(w.device, NULL, &w.compositor) == FNL_OK && make_swapchain();
    return good ? 0 : -1;
}

static int tear_down(void **state) {
    UNUSED(state);
    fnl_compositor_destroy(&w.compositor);
    fnl_renderer_destroy(&w.renderer);
    fnl_swapchain_destroy(&w.swapchain);
    fnl_device_destroy(&w.device);
    fnl_scene_destroy(&w.scene);
    fclose(w.kept);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fields_of_lights),   cmocka_unit_test(test_fields_of_materials),
        cmocka_unit_test(test_fields_of_decals),   cmocka_unit_test(test_other_arguments),
        cmocka_unit_test(test_fields_of_frames),   cmocka_unit_test(test_unsupported_frames),
#ifdef FANAL_RAY
        cmocka_unit_test(test_fields_of_traces),
#endif
        cmocka_unit_test(test_null_is_named_by_every_export),
    };
    return cmocka_run_group_tests_name("misuse", tests, set_up, tear_down);
}
