/* SPDX-License-Identifier: MIT */
/**
 * An OpenXR runtime for tests: deterministic, without a headset. It has a clock of its own, poses from a script, and checks each call: arguments, order,
 * layers, whether a pose that comes back was given. README.md has the words of scripts and of the log.
 *
 * Used by one thread, as the programs do that it tests.
 */
#ifndef FNL_TESTS_XR_RUNTIME_H
#define FNL_TESTS_XR_RUNTIME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <vulkan/vulkan_core.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

enum { VIEWS = 4, HANDS = 2, IMAGES = 3, LAYERS = 8, MASK_VERTICES = 64, FORMATS = 16, OBJECTS = 512, EVENTS = 64, ROWS = 256, PATHS = 128 };

/* ---- the script ---- */

struct fault {
    char function[64];
    uint32_t call; /* 1: the first; 0: every */
    XrResult result;
};
struct moment { /* something that happens when frame `frame` is waited for, counted from 1 over all sessions */
    uint32_t frame;
    char what[32];
    double numbers[4];
    bool done;
};
struct hand_row { /* the state of a hand from a frame on */
    uint32_t frame, hand;
    XrPosef pose;
    bool tracked, select, squeeze;
};
struct gaze_row { /* the eyes from a frame on */
    uint32_t frame;
    XrPosef pose; /* seen from the head */
    bool active, valid, tracked;
};
struct cost {
    char function[64];
    double milliseconds;
};
struct mask {
    uint32_t vertex_count, index_count;
    XrVector2f vertices[MASK_VERTICES];
    uint32_t indices[MASK_VERTICES * 3];
};

struct script {
    uint32_t view_count, width[VIEWS], height[VIEWS];
    XrFovf fov[VIEWS];
    XrPosef eye[VIEWS];
    int64_t formats[FORMATS];
    uint32_t format_count;
    char without[16][64];
    uint32_t without_count;
    bool no_stage, no_local, no_system;
    double period; /* milliseconds */
    struct {
        double sway, sway_seconds, turn, turn_seconds; /* metres to either side, radians to either side, seconds for one swing */
        double x, y, z, yaw;
    } head;
    struct mask masks[VIEWS];
    struct fault faults[ROWS];
    struct moment moments[ROWS];
    struct hand_row hands[ROWS];
    struct cost costs[ROWS];
    struct gaze_row gazes[ROWS];
    uint32_t fault_count, moment_count, hand_count, cost_count, gaze_count; /* without gazes the headset has no eye tracker */
    char save[512];
    uint32_t save_first, save_count; /* which frames are saved */
    bool opaque_only;
};

/* ---- objects ---- */

enum kind { KIND_INSTANCE = 1, KIND_SESSION, KIND_SPACE, KIND_SWAPCHAIN, KIND_ACTION_SET, KIND_ACTION };
struct swapchain {
    XrSwapchainCreateInfo info;
    VkImage images[IMAGES];
    VkDeviceMemory memory[IMAGES];
    int acquired, waited, released; /* index or -1; `released`: the last one */
    uint32_t next;
    bool is_depth;
};
struct object {
    enum kind kind; /* 0 when destroyed */
    struct object *parent;
    union {
        struct {
            XrReferenceSpaceType reference; /* 0: of an action */
            struct object *action;
            uint32_t hand;
            XrPosef pose;
        } space;
        struct swapchain swapchain;
        struct {
            XrActionType type;
            bool is_gaze;
            char name[XR_MAX_ACTION_NAME_SIZE];
        } action;
    };
};

struct runtime {
    struct script script;
    FILE *log;
    uint32_t errors;
    struct object objects[OBJECTS];
    uint32_t object_count;

    bool ext_depth, ext_mask, ext_quad, ext_gaze;
    PFN_vkGetInstanceProcAddr get_proc;
    VkInstance vulkan;
    VkPhysicalDevice physical;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    bool asked_requirements, asked_device;

    struct object *session;
    XrSessionState state;
    bool running, exit_requested, attached, session_lost, instance_lost;
    uint32_t pause_polls; /* until READY after a pause */
    bool pausing, has_resumed;
    uint32_t hidden_frames, bad_until;
    XrViewConfigurationType configuration;
    XrEventDataBuffer events[EVENTS];
    uint32_t event_count;

    /* Frames. Nanoseconds of the virtual clock. */
    int64_t now, wake, display;
    uint32_t frame; /* how often xrWaitFrame was called, over all sessions */
    uint32_t ended; /* frames ended in this session */
    bool waited, begun;
    int64_t begun_display, waited_display;
    XrView given[VIEWS];           /* by the last xrLocateViews for the frame's display time */
    XrPosef given_head[8];         /* the head as each xrLocateViews of this frame predicted it, in LOCAL without recentering */
    uint32_t given_count;
    struct object *given_space;
    bool has_given;
    XrPosef local_origin;          /* of LOCAL, in STAGE */
    int64_t recenter_time;         /* -1: none is coming */
    XrPosef recentered;

    uint64_t paths_count;
    char paths[PATHS][XR_MAX_PATH_LENGTH];
    uint32_t bound_profiles;
    double saved_seconds;
};
extern struct runtime rt;

/* script.c */
bool script_read(const char *path);
XrResult script_result(const char *name);
const char *result_name(XrResult result);

/* runtime.c */
/** Counts the call and lets the clock run; XR_SUCCESS, or what the script says that it returns. */
XrResult enter(const char *function);
/** A mistake of the program: goes to the log. */
__attribute__((format(printf, 2, 3))) XrResult mistake(XrResult result, const char *format, ...);
__attribute__((format(printf, 1, 2))) void note(const char *format, ...);
struct object *new_object(enum kind kind, struct object *parent);
struct object *find_object(const void *handle, enum kind kind);
void destroy_object(struct object *object);
void push_event(const void *event, size_t size);
void set_state(XrSessionState state);
bool is_lost(XrResult *out);

/* poses.c */
XrPosef pose_mul(const XrPosef *a, const XrPosef *b);
XrPosef pose_inverse(const XrPosef *a);
XrPosef true_head(int64_t time);
/** What a tracker says at `now` about `time`: the truth of the past; of the future it goes on straight. */
XrPosef predicted_head(int64_t now, int64_t time);
XrPosef space_in_stage(const struct object *space, int64_t time);
double pose_distance(const XrPosef *a, const XrPosef *b);
double pose_angle(const XrPosef *a, const XrPosef *b);
const struct hand_row *hand_now(uint32_t hand);
const struct gaze_row *gaze_now(void);

/* images.c */
XrResult images_make(struct swapchain *chain);
void images_free(struct swapchain *chain);
bool image_save(const struct swapchain *chain, uint32_t layer, const XrRect2Di *rect, const char *path);
void vulkan_forget(void);

/* frame.c, input.c, vulkan.c: the functions by name; NULL: not there */
PFN_xrVoidFunction frame_function(const char *name);
PFN_xrVoidFunction input_function(const char *name);
PFN_xrVoidFunction vulkan_function(const char *name);

#define ENTER()                                                                                                             \
    do {                                                                                                                    \
        XrResult entered = enter(__func__ + 4); /* "call" is dropped: callEndFrame is xrEndFrame */                         \
        if (entered != XR_SUCCESS) return entered;                                                                          \
    } while (0)
#define FUNCTION(name, list)                                                                                                \
    if (strcmp(list, "xr" #name) == 0) return (PFN_xrVoidFunction)call##name;
#define CHECK_TYPE(structure, wanted)                                                                                       \
    do {                                                                                                                    \
        if (!(structure)) return mistake(XR_ERROR_VALIDATION_FAILURE, #structure " is NULL");                               \
        if ((structure)->type != (wanted)) return mistake(XR_ERROR_VALIDATION_FAILURE, #structure "->type is %d, must be " #wanted, (structure)->type); \
    } while (0)

#endif
