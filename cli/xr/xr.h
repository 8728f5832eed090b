/* SPDX-License-Identifier: MIT */
/** `fanal xr`: a scene in a headset, by OpenXR. What its files share. */
#ifndef FNL_CLI_XR_H
#define FNL_CLI_XR_H

#include "world.h"
#include "xr/xr_maths.h"

#include "fanal/vulkan.h"

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

enum { XR_VIEWS = 4, XR_IMAGES = 8, XR_HANDS = 2, XR_PAST = 8, XR_STATES = 64, XR_TIMES = 4096 };

struct xr_options {
    struct world_options world;
    fnl_frame frame; /* but for its size and cameras */
    bool own_shadows;
    uint32_t frame_count; /* 0: until the user leaves */
    const char *stats;
    bool stereo_only, no_depth, forward_depth, no_mask, no_input, no_gaze, validate, no_cache, quiet;
    XrReferenceSpaceType space; /* VIEW: the best */
    float scale;                /* of the recommended size; 0: by frame time */
    float world_scale;          /* scene units per meter of the room */
    double budget;              /* milliseconds; 0: the headset's */
};

/** How a connection to the runtime goes. */
enum xr_end {
    XR_RUNS,
    XR_DONE,  /* the session ended as it should */
    XR_LOST,  /* session or instance: it may be made again */
    XR_FAILED /* told already */
};

/** What of a view is never seen, as triangles on the plane z = -1 of the view (visibility mask). */
struct xr_mask {
    XrVector2f *vertices;
    uint32_t *indices;
    uint32_t vertex_count, index_count;
    fnl_vec2 *corners; /* index_count of them: the same, as frames take it */
    uint32_t version; /* 0: never read */
};

/** Views of one size, which are rendered by one call into the layers of one image. */
struct xr_group {
    uint32_t first, count;
    uint32_t width, height; /* of the images */
    XrSwapchain color, depth; /* depth: XR_NULL_HANDLE where none is handed over */
    XrSwapchainImageVulkan2KHR colors[XR_IMAGES], depths[XR_IMAGES];
    fnl_renderer *renderer;
    uint32_t drawn_width, drawn_height; /* of the last frame */
    bool has_stats;
};

struct xr_hand {
    XrPath path;
    XrSpace aim;
    bool active, teleport, grab; /* as in the last frame */
    fnl_rigid_pose pose;         /* in the world */
    bool holds;
    fnl_light_id light;
    fnl_light_params held;      /* as it was taken */
    fnl_rigid_pose held_by;     /* the hand then */
};

/** The rays that are seen; they stay in the scene when a session is lost. */
struct xr_beams {
    fnl_material_id material;
    fnl_mesh_id mesh; /* generation 0: not made yet */
    fnl_instance_id instances[XR_HANDS];
    bool shown[XR_HANDS];
    float ev; /* that the material is made for */
};

/** A frame that was shown a while ago, to compare what was predicted with what came. */
struct xr_past {
    XrTime display;
    fnl_rigid_pose simulated, rendered; /* the head in the space of play */
};

/** Numbers over all connections. */
struct xr_numbers {
    uint32_t connections, losses, waited, rendered, discarded, missed, over_budget, recenters;
    uint32_t states[XR_STATES], state_count;
    double period;
    double cpu[XR_TIMES], gpu[XR_TIMES]; /* milliseconds, of the last frames */
    uint32_t time_count;                 /* of all */
    float least_scale;
    uint32_t scale_changes;
    uint32_t mask_reads, mask_changes, mask_frames;
    uint32_t teleports, grabs, light_moves;
    uint32_t gaze_frames; /* that were rendered with a gaze */
    bool gaze_last;       /* the last one was */
    fnl_vec3 last_gaze;
    uint32_t predictions;
    double simulated_metres, rendered_metres, simulated_radians, rendered_radians; /* sums of errors */
    XrTime last_display;
    uint32_t last_count, last_width[XR_VIEWS], last_height[XR_VIEWS];
    fnl_camera last_cameras[XR_VIEWS];
    fnl_rigid_pose last_rig;
    double last_hidden[XR_VIEWS]; /* part of the view that the mask covers */
    fnl_vec3 last_light;          /* where the light that was moved last is now */
};

/** What the runtime gives poses of. */
enum xr_pose_of { XR_POSE_VIEW, XR_POSE_GAZE, XR_POSE_HAND, XR_POSE_HEAD, XR_POSES };

struct xr {
    const struct xr_options *options;
    XrFovf fields[XR_VIEWS]; /* of view of the last frame */
    bool has_fields, told_of_fields, told_of_eyes, told_of_scale, told_of_poses[XR_POSES];
    enum xr_end end;
    struct xr_numbers numbers;

    fnl_host host;
    fnl_scene *scene;
    fnl_scene_info scene_info;
    fnl_camera home; /* where the scene is seen from at first */
    fnl_frame frame;

    XrInstance instance;
    XrSystemId system;
    char runtime_name[XR_MAX_RUNTIME_NAME_SIZE], system_name[XR_MAX_SYSTEM_NAME_SIZE];
    bool has_depth, has_mask, has_quad;
    bool has_gaze; /* the headset follows the eyes, and the frame asks for it */
    XrViewConfigurationType configuration;
    XrEnvironmentBlendMode blend;
    uint32_t view_count;
    XrViewConfigurationView configured[XR_VIEWS];

    void *vulkan_library;
    PFN_vkGetInstanceProcAddr get_proc;
    VkInstance vulkan;
    VkPhysicalDevice physical;
    VkDevice vk_device;
    VkQueue queue;
    uint32_t family;
    fnl_device *device;
    fnl_device_info device_info;

    XrSession session;
    XrSessionState state;
    bool running, asked_exit;
    XrReferenceSpaceType space_type;
    XrSpace space, head_space;
    int64_t color_format, depth_format; /* depth: 0: none */
    struct xr_group groups[XR_VIEWS];
    uint32_t group_count;
    struct xr_mask masks[XR_VIEWS];
    fnl_hidden_area hidden[XR_VIEWS]; /* of `masks` */
    PFN_xrGetVisibilityMaskKHR get_mask;

    /* Where the space of play stands in the world. */
    fnl_rigid_pose rig;
    bool placed;      /* false: the next frame puts the head where `home` is */
    bool keeps_place; /* then only turns it as `home` looks, and leaves it where it is */
    fnl_vec3 head_in_world;
    XrTime replace_at; /* of a coming change of the space; 0: none */

    XrActionSet actions;
    XrAction aim_action, teleport_action, grab_action;
    struct xr_hand hands[XR_HANDS];
    bool has_input;
    XrActionSet gaze_actions;
    XrAction gaze_action;
    XrSpace gaze_space;
    bool gaze_known; /* in this frame */
    fnl_vec3 gaze;   /* where, in the world */
    struct xr_beams beams;
    float ev; /* of the last frame */

    XrTime first_display, past_display;
    struct xr_past past[XR_PAST];
    uint32_t past_count;
    float scale;
    uint32_t calm; /* frames well below the budget, in a row */
    uint32_t frames_of_scale;
    double recent[8];
};

/* ---- xr_connect.c ---- */

/** Whether a call that the session cannot go without has worked; if not, it is told, and `end` is LOST or FAILED. */
bool xr_good(struct xr *x, const char *function, XrResult result);
/** The same for what can be done without: where it fails, a warning says what is left out. */
bool xr_may(struct xr *x, const char *function, XrResult result, const char *left_out);
/** Whether the end of something has worked: otherwise only a warning, as it is over anyway. */
void xr_note_end(const struct xr *x, const char *function, XrResult result);
const char *xr_result_text(XrResult result);
/** Instance, system, device, session, space. */
bool xr_connect(struct xr *x);
void xr_disconnect(struct xr *x);
/** Takes all events; the session begins and ends here. */
void xr_take_events(struct xr *x);

/* ---- xr_vulkan.c ---- */

bool xr_open_device(struct xr *x);
void xr_close_device(struct xr *x);

/* ---- xr_images.c ---- */

bool xr_make_images(struct xr *x);
void xr_free_images(struct xr *x);
/** Takes the next images of a group, which may be written then. */
bool xr_take_images(struct xr *x, const struct xr_group *group, VkImage *color, VkImage *depth);
bool xr_release_images(struct xr *x, const struct xr_group *group);
/** The part of a group's images that a frame fills. */
void xr_scaled_size(const struct xr *x, const struct xr_group *group, uint32_t *width, uint32_t *height);

/* ---- xr_frame.c ---- */

/** Compiles what the frames need, which may take seconds: before the session begins, while the runtime shows what it likes. */
bool xr_warm(struct xr *x);
/** Waits for a frame, renders it and hands it over. */
void xr_run_frame(struct xr *x);

/* ---- xr_input.c ---- */

/** Suggests bindings and attaches them; without them the session goes on. */
void xr_start_input(struct xr *x);
void xr_take_input(struct xr *x, XrTime time);
/** How long a hand's ray is: to the floor where it meets that nearby, else a few metres. */
float xr_ray_length(const struct xr *x, const struct xr_hand *hand);

/* ---- xr_gaze.c ---- */

/** Whether anything goes by where the user looks: `coarse.fovea`. If not, the headset is not asked. */
bool xr_wants_gaze(const struct xr *x);
/** Makes the action; false: goes on without. */
bool xr_start_gaze(struct xr *x);
/** Finds where the user will look at `time`, for fnl_frame.gaze. Nothing is known while the eyes are closed, or the program has not the focus. */
void xr_find_gaze(struct xr *x, XrTime time);

/* ---- xr_beams.c ---- */

void xr_show_beams(struct xr *x);

/**
 * Whether a pose that the runtime calls valid is one: finite, with a unit quaternion. The first bad one of each kind gets a warning; like what is not
 * tracked it is not used.
 */
bool xr_is_pose(struct xr *x, enum xr_pose_of of, const XrPosef *pose);

/* ---- xr_mask.c ---- */

void xr_read_mask(struct xr *x, uint32_t view);
void xr_free_masks(struct xr *x);
/** Hands the hidden triangles of all views to the frame that is about to be rendered. */
void xr_use_masks(struct xr *x, const struct xr_group *group, fnl_frame *frame);
/** How much of the view the triangles cover, 0 .. 1. */
double xr_mask_area(const struct xr_mask *mask, const XrFovf *fov);

/* ---- xr_pacing.c ---- */

/** A frame begins: counts what was missed since the last one. */
void xr_pace(struct xr *x, const XrFrameState *state);
/** The times of a frame that is over; the next one may be smaller or larger. */
void xr_note_times(struct xr *x, double cpu, double gpu);
/** Compares predictions of earlier frames with what the runtime says now of that time, and keeps those of this one. */
void xr_note_prediction(struct xr *x, XrTime display, const fnl_rigid_pose *simulated, const fnl_rigid_pose *rendered);

/* ---- xr_report.c ---- */

void xr_print(const struct xr *x);
bool xr_save_stats(const struct xr *x);

/** Converts an OpenXR pose to a pose with its position in scene units. */
static inline fnl_rigid_pose xr_pose(const struct xr *x, const XrPosef *pose) {
    const float scale = x->options->world_scale;
    return (fnl_rigid_pose){{pose->position.x * scale, pose->position.y * scale, pose->position.z * scale},
                            {pose->orientation.x, pose->orientation.y, pose->orientation.z, pose->orientation.w}};
}

#endif
