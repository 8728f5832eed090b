/* SPDX-License-Identifier: MIT */
/** fanal view: a scene in a window. What its parts share. */
#ifndef FNL_CLI_VIEW_H
#define FNL_CLI_VIEW_H

#include "trace_file.h"
#include "view/ui.h"
#include "view/view_compare.h"
#include "view/view_select.h"
#include "world.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

/* ---- events: from the window, or from a file that replays them ---- */

enum view_event_kind {
    VIEW_MOVE,      /* the mouse is at x, y: pixels of the picture */
    VIEW_BUTTON,    /* code: 0 left, 1 right, 2 middle */
    VIEW_WHEEL,     /* x, y: steps */
    VIEW_KEY,       /* code: GLFW's number */
    VIEW_CHARACTER, /* code: of Unicode */
    VIEW_SIZE,      /* the picture has x times y pixels */
    VIEW_DROP,      /* text: a file */
    VIEW_SCALE,     /* x: of letters and gaps, as the screen has it */
    VIEW_PAD,       /* of a gamepad; code: axis of GLFW, x: -1 .. 1 */
    VIEW_PAD_BUTTON, /* code: GLFW's number */
    VIEW_CLOSE,
    /* Of a file alone. */
    VIEW_FRAMES,  /* draws `code` frames, a sixtieth of a second each */
    VIEW_SETTLE,  /* draws until nothing changes any more */
    VIEW_SET,     /* text: KEY=VALUE, an option of the frame */
    VIEW_CLICK,   /* text: the label of a widget, which is clicked */
    VIEW_SAVE,    /* text: the picture as `fanal render` makes it */
    VIEW_CAPTURE, /* text: the picture with what is drawn over it */
    VIEW_COMMAND, /* text: writes the command line that renders this picture */
    VIEW_COMPARE, /* text: off, split, side or difference */
    VIEW_SET_B,   /* text: KEY=VALUE, an option of what is compared */
    VIEW_SLIDER,  /* x: where that begins, 0 .. 1 of the width */
    VIEW_REPORT,  /* text: writes what all tables say */
    VIEW_TRACE,   /* text: writes what the last frames did and when */
    VIEW_SAVE_SCENE, /* text: the scene as .glb */
    VIEW_TURNTABLE,  /* writes `code` pictures once round the scene */
    VIEW_PANEL,      /* text: the panel that is opened */
    VIEW_POLL,       /* looks at once whether files have changed */
    VIEW_EVENT_COUNT
};
enum { VIEW_SHIFT = 1, VIEW_CONTROL = 2, VIEW_ALT = 4 }; /* modifiers */

struct view_event {
    enum view_event_kind kind;
    float x, y;
    int code;
    bool down;
    uint32_t modifiers;
    char text[1024];
};

enum { VIEW_QUEUE = 256 };
struct view_queue {
    struct view_event events[VIEW_QUEUE];
    uint32_t first, count;
};
/** When it is full the oldest movement goes; false: there was no room at all. */
bool view_queue_add(struct view_queue *queue, const struct view_event *event);
bool view_queue_take(struct view_queue *queue, struct view_event *out);

enum { VIEW_LINE = 1200 }; /* bytes of a line of a recording */
/** Reads a line of a recording and parses it. False at the end of the file, or (with a message, *bad set) for a line that is no event or too long. */
bool view_event_read(const char *path, uint32_t line, FILE *file, struct view_event *out, bool *bad);
/** A line of a recording; false (with a message) for one that is none. Empty lines and those that begin with # are skipped: *out_kind VIEW_EVENT_COUNT. */
bool view_event_parse(const char *path, uint32_t line, const char *text, struct view_event *out);
void view_event_write(FILE *file, const struct view_event *event);

/* ---- the window (window.c); NULL handle: without one ---- */

struct fnl_swapchain;
struct view_window;
/* As fnl_present and fnl_color_space, which stand in a header of Vulkan. */
enum { VIEW_PRESENT_COUNT = 3, VIEW_COLOR_COUNT = 3 };
extern const char *const view_present_names[VIEW_PRESENT_COUNT], *const view_color_names[VIEW_COLOR_COUNT];
bool view_window_create(uint32_t width, uint32_t height, const char *title, struct view_queue *queue, struct view_window **out);
void view_window_destroy(struct view_window **window);
/** Pictures for the window; `present` and `color` as fnl_swapchain_params has them. False with a message. */
bool view_window_open_swapchain(struct view_window *window, fnl_device *device, uint32_t present, uint32_t color, struct fnl_swapchain **out);
/** The mouse belongs to the window, is not seen, and can be moved without end. */
void view_window_capture_mouse(struct view_window *window, bool captured);
/** Takes events; waits up to so many seconds for one. */
void view_window_poll(struct view_window *window, double seconds);
void view_window_query_size(const struct view_window *window, uint32_t *width, uint32_t *height);
float view_window_scale(const struct view_window *window);
void view_window_set_title(struct view_window *window, const char *title);
void view_window_set_clipboard(struct view_window *window, const char *text);
bool view_window_has_gamepad(const struct view_window *window);

/* ---- the camera (view_camera.c) ---- */

struct view_camera {
    fnl_camera now;
    float size; /* of what is looked at, metres: how fast it moves */
};
void view_camera_orbit(struct view_camera *camera, float right, float down); /* radians, about the target */
void view_camera_look(struct view_camera *camera, float right, float down);  /* radians, about itself */
void view_camera_pan(struct view_camera *camera, float right, float down);   /* parts of the picture's height */
void view_camera_dolly(struct view_camera *camera, float steps);             /* towards the target */
void view_camera_fly(struct view_camera *camera, fnl_vec3 metres);           /* right, up, forward */
void view_camera_walk(struct view_camera *camera, fnl_vec3 metres);          /* the same on level ground */

/* ---- a scene (view_scene.c) ---- */


struct view_scene {
    char *source; /* malloc */
    fnl_scene *scene;
    fnl_renderer *renderer;
    fnl_scene_info info;
    fnl_camera camera;
    bool changed; /* in the window: the file does not say it */
};
void view_scene_free(struct view_scene *scene);

/** Who calls the device or its renderers holds the mutex, which is recursive. */
struct view_device {
    pthread_mutex_t mutex;
    fnl_device_params params;
    fnl_device *device;
    fnl_device_info info;
};

/**
 * The window's pictures by a device of their own, so that panels answer while the scene's device works on a slow frame: the scene's last
 * picture with the panels over it (view_screen.c).
 */
struct view_screen {
    fnl_device *device; /* NULL: the scene is drawn straight into the window */
    fnl_scene *scene;   /* with nothing in it: all is overlay */
    fnl_renderer *renderer;
    fnl_image picture; /* of the scene */
    uint64_t version;  /* of the picture */
    bool is_drawing;   /* the scene's device works on a frame */
    double begun;      /* when it began */
    fnl_frame sent;    /* that frame, or the last, */
    fnl_pixel_query pixel; /* and what it was asked for */
    bool failed;       /* it could not be made: is not tried again */
    uint32_t slow;     /* frames in a row that took so long that panels would stutter */
    uint64_t shown;    /* pictures of the window so far, without those during loading */
};

enum view_phase { VIEW_READING, VIEW_SENDING, VIEW_COMPILING };
/** Loads on a thread of its own. */
struct view_loader {
    /* Set before it starts. */
    struct view_device *device;
    struct world_options world;
    fnl_host host;
    fnl_frame frame; /* that the first one will be like */
    float width, height; /* of the part of it that is seen */
    bool own_shadows;
    uint32_t format; /* VkFormat of the window's pictures; 0: without a window */
    /* Its own. */
    pthread_t thread;
    bool running, good;
    atomic_bool done, cancelled;
    atomic_uint progress; /* of 1000 */
    atomic_uint phase;    /* enum view_phase */
    struct view_scene scene;
};
/** Nothing is being loaded. `source` is copied. */
bool view_loader_start(struct view_loader *loader, const char *source);
/** Whether a load has ended; then `out` has the scene, or nothing when it failed (the host's log says why). `wait`: until then. */
bool view_loader_take(struct view_loader *loader, bool wait, struct view_scene *out);
/** "Loading model.glb: reading, 40 %" */
void view_loader_describe(struct view_loader *loader, char *text, size_t capacity);
void view_loader_stop(struct view_loader *loader);

/* ---- the window's own device (view_screen.c); false: no picture can be shown any more ---- */

struct view;
/** After frames, and when colours change: begins or ends it as the scene's device needs. */
bool view_screen_adapt(struct view *view);
bool view_screen_begin(struct view *view);
bool view_screen_end(struct view *view);
/** At the end; returns how many validation messages there were. */
uint64_t view_screen_finish(struct view *view);
/** The frame of the scene that the window would like to show now. */
fnl_frame view_screen_frame(const struct view *view);
/** Whether that is another than the last. */
bool view_screen_has_changed(const struct view *view);
/** Shows another picture of the scene from now on; it becomes the window's. */
void view_screen_take(struct view *view, fnl_image *picture);
/** Draws it, between ui_begin and ui_end. */
void view_screen_back(struct view *view);
fnl_result view_screen_show(struct view *view, const fnl_overlay *overlay);
/** Of a scene with nothing in it, for pictures that are all overlay. */
fnl_frame view_bare_frame(void);

/* ---- what is remembered from one window to the next (view_settings.c) ---- */

/** What the left mouse button and the keys that move do. */
enum view_navigation {
    VIEW_ORBIT, /* turns about what is looked at */
    VIEW_FLY,   /* looks around, and flies where it looks */
    VIEW_WALK,  /* looks around, and stays at its height */
    VIEW_NAVIGATION_COUNT
};

enum { VIEW_RECENT = 8 };
struct view_settings {
    uint32_t width, height; /* of the window, in the screen's units */
    float scale;            /* 0: the screen's */
    bool dark, panels;
    uint32_t present, color; /* fnl_present, fnl_color_space */
    uint32_t navigation;     /* enum view_navigation */
    char recent[VIEW_RECENT][1024]; /* scenes, the last one first */
    uint32_t recent_count;
};
struct view_settings view_settings_default(void);
/** From the user's folder of settings; lines that make no sense are left out with a warning. */
void view_settings_load(struct view_settings *settings);
/** False with a message. */
bool view_settings_save(const struct view_settings *settings);
void view_settings_note_scene(struct view_settings *settings, const char *source);

/* ---- all of it ---- */

enum { VIEW_MARKED = 64, VIEW_OFF = 256 };
enum { VIEW_MESSAGES = 64, VIEW_HISTORY = 240, VIEW_PASSES = 512 };

struct view_messages {
    pthread_mutex_t mutex;
    struct {
        fnl_log_level level;
        char text[400];
    } lines[VIEW_MESSAGES];
    uint32_t count; /* of all so far */
    uint32_t seen;  /* of these the user has seen */
};

/* Where the time goes (view_timeline.c, panel_timeline.c, panel_graph.c). */
struct view_graph;
struct view_timeline {
    enum view_wide { VIEW_NOTHING_WIDE, VIEW_TIMELINE, VIEW_GRAPH } shown;
    struct trace_history *history;
    double called;             /* when the call began that rendered this frame, seconds; 0: none has */
    bool is_frozen;            /* a frame of the past is shown, not the last */
    struct trace_frame frozen;
    uint32_t frozen_generation; /* of the names in it: trace_generation */
    char pass[256];            /* whose history is shown; "": none */
    float zoom;
    char trace_path[256];
    struct view_graph *graph;  /* NULL: was never shown */
};

/* ---- files: what is saved, watched, browsed and recorded (view_reload.c, view_sequence.c, panel_files.c) ---- */

enum { VIEW_PATH = 1024, VIEW_ARGUMENTS = 16384 }; /* bytes */

struct view_entry {
    char name[256];
    uint64_t size;
    bool folder;
};

struct view_point {
    double seconds;
    double eye[3], target[3]; /* places (origin.h) */
};

struct view_files {
    uint32_t save_width, save_height; /* of pictures; 0: the window's */
    char scene_path[VIEW_PATH];
    /* What is on disk. */
    uint64_t stamp; /* of all files of the scene */
    uint32_t quiet; /* looks since it changed */
    bool changed, again; /* again: what is being loaded is the shown scene */
    double next_look;
    int64_t load_begun; /* when loading began, in nanoseconds of the clock of file times */
    /* The browser. */
    bool browses, browser_saves;
    bool begins; /* the field for a name gets the keys */
    char folder[VIEW_PATH], typed[VIEW_PATH], overwrites[VIEW_PATH]; /* overwrites: what is there and waits for one more click */
    struct view_entry *entries;
    uint32_t entry_count;
    /* Sequences. */
    char pattern[256], flight_path[256], sequence[VIEW_ARGUMENTS]; /* sequence: options of the command that made the last */
    uint32_t turntable_count;
    struct view_flight {
        bool records;
        struct view_point *points;
        uint32_t count, capacity;
        double seconds;
    } flight;
    /* A second animation. */
    uint32_t blend_with; /* from the count on: none */
    float blend_part;    /* its weight; the other's is the rest */
};

/* ---- pictures of environments, in a menu (view_thumbnails.c) ---- */

enum { VIEW_ENVIRONMENTS = 3, VIEW_THUMBNAIL_WIDTH = 80, VIEW_THUMBNAIL_HEIGHT = 48 };
enum { VIEW_THUMBNAIL_IMAGE = 2 }; /* of the overlay; 1 is the difference of two methods */
extern const char *const view_environments[VIEW_ENVIRONMENTS];
struct view_thumbnails {
    fnl_image image;
    uint32_t count; /* of those in it */
};

/** Panels, in the order of their tabs: first those that dock at the left. */
enum view_panel {
    VIEW_PANEL_SCENE,
    VIEW_PANEL_LIGHTS,
    VIEW_PANEL_OPTIONS,
    VIEW_PANEL_INSPECT,
    VIEW_PANEL_STATISTICS,
    VIEW_PANEL_MESSAGES,
    VIEW_PANEL_COUNT
};

struct view {
    struct world_options world;
    fnl_host host;
    struct view_device device;
    struct fnl_swapchain *swapchain; /* NULL: headless */
    struct view_screen screen;
    struct view_window *window;
    struct view_queue queue;
    struct view_loader loader;
    struct view_messages messages;

    struct view_scene shown;
    fnl_frame frame, usual, good; /* as the user wants it; as it began; of the last frame that could be drawn */
    bool own_shadows;             /* the user chose them; else they are those that the scene should have */
    struct view_compare compare;
    struct view_camera camera;
    uint32_t width, height;

    /* How often and how finely. */
    uint32_t wanted;      /* pictures of the window to be drawn although nothing happens */
    uint32_t due;         /* of these, frames of the scene */
    bool replays;         /* no frame is left out */
    bool moving;          /* the picture changes: it may be coarser */
    double opened;        /* when the scene was asked for */
    uint32_t arriving;    /* 2: its first picture is still to come; 1: its last image */
    uint64_t pending;     /* images of the scene that are still being decoded */
    float part;           /* of the picture's width that is rendered while it moves */
    double frame_seconds; /* of the last frame, measured from end to end */
    uint64_t frames_drawn, frames_loading; /* of them while a scene was being loaded */

    /* The mouse and the keys. */
    float mouse_x, mouse_y, pressed_x, pressed_y;
    int drag;   /* button, or -1 */
    bool stale; /* the mouse has moved since the last frame: widgets do not know yet where it is */
    uint32_t modifiers;
    bool keys[512];
    float pad[6];  /* the gamepad's axes */
    bool captured; /* the mouse looks around without a button */
    bool quit;

    struct view_settings settings;
    bool remembers; /* settings are read and written */

    /* What the command line said of the scene: goes into the command that renders the picture. */
    char arguments[VIEW_ARGUMENTS], light_arguments[VIEW_ARGUMENTS], environment_arguments[VIEW_ARGUMENTS];
    char asked_for[VIEW_PATH]; /* the scene */
    struct view_surroundings {
        bool changed; /* in the window */
        bool none;
        char source[1024];
        fnl_environment_params params; /* but for its source */
    } surroundings;
    char variant[96]; /* chosen in the window; "": none was */

    /* The animation. */
    bool plays;
    uint32_t animation;
    double time, speed;

    /* What the panels show. */
    bool hides_panels, shows_help;
    bool panels[VIEW_PANEL_COUNT];  /* open */
    uint32_t front;                 /* enum view_panel, which the next frame shows before other tabs; VIEW_PANEL_COUNT: none */
    struct ui_rectangle area;       /* what toolbar and panels leave of the window, pixels */
    fnl_camera framed;              /* the camera that framing gave for `framed_aspect`; 0: another was chosen */
    float framed_aspect;
    float scale, wanted_scale; /* 0: as it is */
    char filter[64], save_path[256];
    fnl_frame_stats stats;
    float history[VIEW_HISTORY];
    uint32_t history_at;
    struct {
        char name[64];
        double milliseconds;
    } passes[VIEW_PASSES];
    uint32_t pass_count;
    uint32_t light; /* that is edited */
    struct view_marked {
        struct view_id ids[VIEW_MARKED]; /* lights that change together with the one that is edited, if that is among them */
        uint32_t count;
        struct view_id off[VIEW_OFF]; /* lights that were switched off, and how bright they were */
        float intensity[VIEW_OFF];
        uint32_t off_count;
    } marked;
    struct view_thumbnails thumbnails;
    struct view_timeline timeline;
    struct view_files files;
    struct view_pick {
        bool clicked;      /* what object is there is still to be found out */
        bool asked, known; /* the next frame tells; one did */
        uint32_t x, y; /* of the window's picture */
        fnl_pixel_info info;
        fnl_pixel_light lights[FNL_PIXEL_LIGHTS];
    } pick;
    struct view_select select;
};

/** The toolbar and the panels of a frame (panels.c), between ui_begin and ui_end; sets view.area. */
void view_panels(struct view *view);
/** The toolbar and its menus (toolbar.c); returns its height, pixels at scale 1. */
float view_toolbar(struct view *view);
/** Draws one of the pictures that are still missing. */
void view_thumbnails_update(struct view *view);
/** Opens a panel, in front of the other tabs of its dock. */
void view_open_panel(struct view *view, enum view_panel panel);
/** By its title, as in "lights"; false with a message. */
bool view_open_panel_named(struct view *view, const char *name);
/** The part of the window that shows the scene, pixels: all of it while panels are hidden. */
struct ui_rectangle view_area(const struct view *view);
/** `camera` for a picture of width x height pixels, of which `area` shows what the camera sees. */
fnl_camera view_fitted_camera(const fnl_camera *camera, struct ui_rectangle area, float width, float height);
/** Their contents, each in a file of its name. */
void view_panel_scene(struct view *view);
void view_panel_lights(struct view *view);
/** Parts of menus and panels. */
void view_show_cameras(struct view *view);
void view_show_variants(struct view *view);
void view_show_animation(struct view *view);
void view_show_surroundings(struct view *view);
void view_show_exposure(struct view *view);
void view_show_choices(struct view *view, const char *key); /* the values of an option; nothing if there is no such option */
void view_show_light(struct view *view, uint32_t index);
void view_panel_options(struct view *view);
void view_panel_statistics(struct view *view);
void view_panel_inspect(struct view *view);
void view_panel_pixel(const struct view *view); /* a part of it */
/** The wide panel below. */
void view_panel_wide(struct view *view, struct ui_rectangle at);
void view_panel_timeline(struct view *view);
void view_panel_graph(struct view *view);
/** What a pass is for, as a color; and what these colors mean. */
uint32_t view_role_color(uint32_t role);
void view_show_roles(void);
/** Opens the wide panel with this in it; closes it where it shows it. */
void view_show_wide(struct view *view, enum view_wide what);
void view_timeline_finish(struct view *view);
/** The frame that the timeline shows; NULL: none yet. */
const struct trace_frame *view_timeline_frame(const struct view *view);
/** Lines of the report. */
void view_report_timeline(const struct view *view, FILE *file);
void view_report_graph(const struct view *view, FILE *file);
void view_graph_free(struct view_graph **graph);
/** What the last frames did and when, to a file; false with a message. */
bool view_save_trace(struct view *view, const char *path);
/** Of the debug view, in a corner of the picture. */
void view_show_legend(struct view *view);
/** While there is no scene: what can be opened. */
void view_panel_start(struct view *view);
/** Asks the frame for the pixel that was clicked on; and keeps its answer, before any other call on the renderer. */
void view_pixel_ask(const struct view *view, fnl_frame *frame);
void view_pixel_take(struct view *view, const fnl_frame *frame);
/** Their lines of the report. */
void view_report_frame(const struct view *view, FILE *file);
void view_report_pixel(const struct view *view, FILE *file);
/** What the panels say, as text; false when it could not be written. */
bool view_write_report(const struct view *view, const char *path);
/** A row of three number fields labeled `name`, which also identifies the widgets. Returns whether a number changed. */
bool view_show_vector(const char *name, fnl_vec3 *value, const char *format);
/** A list that switches the eight bits of a mask. Returns whether a bit changed. */
bool view_show_mask(const char *label, uint32_t *mask);
/** The command line that renders what is shown. */
void view_print_command(const struct view *view, FILE *file);
/** The same into the clipboard, and to the terminal. */
void view_copy_command(const struct view *view);

/* ---- view_frame.c ---- */

/** For fnl_host.log; `user` is the view_messages. */
void view_take_message(void *user, fnl_log_level level, const char *line);
void view_say(struct view *view, fnl_log_level level, const char *text);
/** The new scene takes the place of the old one; where it cannot, the old one stays. */
void view_show(struct view *view, struct view_scene *scene);
bool view_ends_with(const char *text, const char *end); /* in capitals or not */
double view_now(void);                                  /* seconds */
/** A frame of the window; false when the device is lost. */
bool view_draw_frame(struct view *view, double seconds);
/** Takes the scene's picture if the device has finished it meanwhile; false when the device is lost. */
bool view_collect(struct view *view);
/** The frame of the user's options, at the window's size. */
fnl_frame view_whole_frame(const struct view *view);
/** The picture with the panels. */
bool view_save_capture(struct view *view, const char *path);

/* ---- view_input.c ---- */

/** Hands an event on; `out_wants_frame`: one must be drawn before the next event. */
bool view_feed(struct view *view, const struct view_event *event, bool *out_wants_frame);
/** What goes on by itself: keys that are held down, the animation, what is being loaded. */
void view_advance(struct view *view, double seconds);

/** Sizes, colours and the swapchain follow the settings. */
void view_apply_settings(struct view *view);
/** The environment as the widgets have it goes to the scene. */
void view_apply_surroundings(struct view *view);

/** Of view_files; the defaults, and what is freed. */
static inline void view_files_init(struct view_files *f) {
    snprintf(f->scene_path, sizeof f->scene_path, "scene.glb");
    snprintf(f->pattern, sizeof f->pattern, "picture-%%04d.png");
    snprintf(f->flight_path, sizeof f->flight_path, "path.txt");
    f->turntable_count = 90;
    f->blend_with = UINT32_MAX;
    f->blend_part = 0.5f;
}
void view_files_finish(struct view *view);
/** The shown scene's files are watched from here on. */
void view_watch_begin(struct view *view);
/** A scene begins to load. */
void view_watch_loading(struct view *view);
/** The scene is now shown: watches its files. Those modified since loading began count as changed. */
void view_watch_loaded(struct view *view);
/** Looks twice a second whether files have changed, and once they are quiet loads the scene again. */
void view_watch(struct view *view);
void view_watch_at_once(struct view *view);
/** Shows what has been loaded; false: nothing has yet. `wait`: until it has. */
bool view_take_loaded(struct view *view, bool wait);
/** Each false with a message. The pictures are those of `fanal render --camera-path`; the call returns when all are written. */
bool view_save_scene(struct view *view, const char *path);
bool view_save_sequence(struct view *view, const char *camera_path, const char *pattern);
bool view_turntable(struct view *view, uint32_t count);
/** Begins a recording of the camera's way, or ends it and writes it. */
void view_toggle_flight(struct view *view);
void view_record_flight(struct view *view, double seconds);
void view_browse(struct view *view, bool saves);
void view_panel_browser(struct view *view);
bool view_exists(const char *path);
/** Puts a number into the name if there is such a file. */
void view_free_name(char *path, size_t capacity);
/** Saves the picture under a name that is not taken. */
void view_save_next_picture(struct view *view);
void view_panel_files(struct view *view); /* a menu */
void view_panel_blend(struct view *view); /* a part of the animations' */
/** Whether two animations are shown. */
static inline bool view_blends(const struct view *v) { return v->files.blend_with < v->shown.info.animation_count && v->files.blend_with != v->animation; }
/** The value of --animation. */
void view_animation_text(const struct view *view, char *out, size_t capacity);
void view_save_size(const struct view *view, uint32_t *width, uint32_t *height);
/** Whether this is the scene of the command line: its options that add lights count for that one alone. */
bool view_is_asked_for(const struct view *view, const char *source);
/** Begins to load; what is on its way is given up. */
bool view_load(struct view *view, const char *source);
/** Until all images of the scene are on the device. */
bool view_wait_for_images(struct view *view, const fnl_frame *frame);

/** Replays a file (view_replay.c); ends after so many frames, if not 0. */
bool view_replay(struct view *view, const char *path, uint32_t exit_after);

/** "light" of 1, "lights" of others. */
static inline const char *view_plural(uint64_t count, const char *one, const char *many) { return count == 1 ? one : many; }
/** Draws soon. */
static inline void view_want_panels(struct view *view, uint32_t frames) { view->wanted = view->wanted > frames ? view->wanted : frames; }
static inline void view_want(struct view *view, uint32_t frames) {
    view_want_panels(view, frames);
    view->due = view->due > frames ? view->due : frames;
}
/** As `fanal render` would make it; false with a message. */
bool view_save_picture(struct view *view, const char *path);
void view_open(struct view *view, const char *source);
void view_choose_shadows(struct view *view);
void view_frame_all(struct view *view);
/** The camera that the scene was opened with. */
void view_reset_camera(struct view *view);
/** Moves the scene's origin along with the camera, except during a drag. */
void view_follow_origin(struct view *view);
/** Keeps what framing has found in sight when the area gets other proportions. */
void view_frame_again(struct view *view);
void view_set_time(struct view *view, double time);

#endif
