/* SPDX-License-Identifier: MIT */
/** The options that say what is seen and from where, which render and trace share. */
#ifndef FNL_CLI_WORLD_H
#define FNL_CLI_WORLD_H

#include "loading.h"

enum { WORLD_PROBES = 32, WORLD_PROBES_AUTO = 16, WORLD_ANIMATIONS = 16 };

struct world_options {
    const char *scene, *camera, *animation, *variant;
    const char *ies; /* NULL: lights as the scene has them */
    bool has_eye, has_look_at, has_background, has_ambient, has_anisotropy, has_range_roughness;
    double eye[3], look_at[3]; /* places (origin.h) */
    fnl_vec3 background, ambient;
    float anisotropy, range_roughness;
    float fov; /* radians; 0: the camera's */
    float near; /* metres; 0: the camera's */
    fnl_vec3 up; /* all 0: the camera's */
    const char *environment; /* NULL: the scene's own, or one where it has no light */
    fnl_environment_params environment_params; /* but for its source */
    int64_t lights;             /* of --lights; below 0: as the scene has them */
    bool scatters;              /* in a built-in scene too, as an option says how */
    fnl_scatter_params scatter; /* but for their count */
    uint32_t grow_metal; /* texels */
    fnl_load_params loading;
    double time; /* of the animation, seconds */
    fnl_probe_params probes[WORLD_PROBES]; /* all except their centers */
    double probe_centres[WORLD_PROBES][3]; /* their centers, as places */
    uint32_t probe_count;
    bool probe_auto, probe_reflections;
    bool has_ground, has_studio, no_studio;
    fnl_ground ground;
    fnl_background backdrop; /* auto: nobody said */
    float blur; /* radians */
};

/* Behind those of loading, below the commands' own. */
enum {
    WORLD_CAMERA = 128,
    WORLD_EYE,
    WORLD_LOOK_AT,
    WORLD_FOV,
    WORLD_NEAR,
    WORLD_UP,
    WORLD_BACKGROUND,
    WORLD_GROUND,
    WORLD_STUDIO,
    WORLD_AMBIENT,
    WORLD_ENVIRONMENT,
    WORLD_ENVIRONMENT_ROTATION,
    WORLD_ENVIRONMENT_INTENSITY,
    WORLD_ENVIRONMENT_HIDDEN,
    WORLD_ENVIRONMENT_COMPRESSED,
    WORLD_ANISOTROPY,
    WORLD_LIGHTS,
    WORLD_LIGHT_SEED,
    WORLD_LIGHT_SHAPES,
    WORLD_LIGHT_SCALE,
    WORLD_IES,
    WORLD_RANGE_ROUGHNESS,
    WORLD_GROW_METAL,
    WORLD_TIME,
    WORLD_ANIMATION,
    WORLD_PROBE,
    WORLD_PROBE_REFLECTIONS,
    WORLD_VARIANT,
    WORLD_END
};

/** Rows for a table of getopt_long, those of loading with them. */
#define WORLD_OPTIONS                                                                                                       \
    {"camera", required_argument, NULL, WORLD_CAMERA}, {"eye", required_argument, NULL, WORLD_EYE},                         \
        {"look-at", required_argument, NULL, WORLD_LOOK_AT}, {"fov", required_argument, NULL, WORLD_FOV},                   \
        {"near", required_argument, NULL, WORLD_NEAR}, {"up", required_argument, NULL, WORLD_UP},                           \
        {"background", required_argument, NULL, WORLD_BACKGROUND}, {"ground", required_argument, NULL, WORLD_GROUND}, {"studio", required_argument, NULL, WORLD_STUDIO}, {"ambient", required_argument, NULL, WORLD_AMBIENT},     \
        {"environment", required_argument, NULL, WORLD_ENVIRONMENT},                                                        \
        {"environment-rotation", required_argument, NULL, WORLD_ENVIRONMENT_ROTATION},                                      \
        {"environment-intensity", required_argument, NULL, WORLD_ENVIRONMENT_INTENSITY},                                    \
        {"environment-hidden", no_argument, NULL, WORLD_ENVIRONMENT_HIDDEN},                                                \
        {"environment-compressed", no_argument, NULL, WORLD_ENVIRONMENT_COMPRESSED}, \
        {"anisotropy", required_argument, NULL, WORLD_ANISOTROPY}, {"lights", required_argument, NULL, WORLD_LIGHTS},       \
        {"light-seed", required_argument, NULL, WORLD_LIGHT_SEED},                                                          \
        {"light-shapes", required_argument, NULL, WORLD_LIGHT_SHAPES},                                                      \
        {"light-scale", required_argument, NULL, WORLD_LIGHT_SCALE}, {"ies", required_argument, NULL, WORLD_IES},           \
        {"range-roughness", required_argument, NULL, WORLD_RANGE_ROUGHNESS},                                                \
        {"grow-metal", required_argument, NULL, WORLD_GROW_METAL}, {"time", required_argument, NULL, WORLD_TIME},           \
        {"animation", required_argument, NULL, WORLD_ANIMATION}, {"probe", required_argument, NULL, WORLD_PROBE}, \
        {"probe-reflections", no_argument, NULL, WORLD_PROBE_REFLECTIONS}, \
        {"variant", required_argument, NULL, WORLD_VARIANT}, LOADING_OPTIONS

/** Lines for help texts. */
#define WORLD_CAMERA_HELP                                                                                                   \
    "  --camera NAME|INDEX        a camera of the scene (the first; without any, one that frames the scene)\n"
#define WORLD_EYE_HELP                                                                                                      \
    "  --eye X,Y,Z --look-at X,Y,Z --fov DEGREES    a camera of your own\n"                                                 \
    "  --up X,Y,Z --near METRES   what is up in its picture (0,1,0), and from where on it sees (0.05)\n"
#define WORLD_SURROUNDINGS_HELP                                                                                             \
    "  --background KIND          what is shown behind the scene: scene (its environment), gradient, blur:DEGREES (the\n"    \
    "                             environment, blurred), or R,G,B in cd/m^2 (gradient in the studio, otherwise scene)\n"    \
    "  --ground on|off|auto       a floor that catches shadows (auto: in the studio, under models without a floor)\n"      \
    "  --studio on|off            lights scenes without light, adds fill to scenes with lights only (on)\n"                    \
    "  --ambient R,G,B            constant ambient light, cd/m^2\n"                                                         \
    "  --environment FILE         environment light: a panorama (.hdr, .exr …), builtin:studio, builtin:overcast or\n"        \
    "                             builtin:sky, optionally with ?elevation=DEGREES&azimuth=DEGREES&turbidity=T\n"         \
    "  --environment-rotation D   turns it, or the file's, about the vertical axis, degrees (0)\n"                      \
    "  --environment-intensity X  multiplies its light, or the file's (1), or auto\n"                            \
    "  --environment-hidden       uses the environment as light only, not as background\n"                            \
    "  --environment-compressed   keeps it as BC6H: an eighth of the memory, 1.4 to 2.9 % off\n" \
    "  --anisotropy N             maximum anisotropy of texture filtering, 1 to 16 (8)\n"
#define WORLD_SCENE_HELP                                                                                                    \
    "  --lights N                 lights in total in a built-in scene; a file gets N more, at random positions\n" \
    "  --light-seed S             random seed for these positions (1)\n"                                                   \
    "  --light-shapes LIST        their kinds: point,spot,capsule,wedge,box,rectangle, each with =SHARE "                    \
    "or equal (point=3,spot=1)\n"                                                                                                    \
    "  --light-scale X            multiplies their radius (1). With one of these three options the N lights of a built-in scene\n" \
    "                             stand at random places too\n"                                                            \
    "  --ies FILE                 points and spots shine as the luminaire of a photometric file (.ies) does\n"              \
    "  --range-roughness R        end lights without a range at 0.05 lx, keep highlights down to roughness R (off)\n"         \
    "  --grow-metal N             grows metallic areas of textures by N texels, against halos at their edges (0)\n"         \
    "  --time SECONDS             time of the animation (0)\n"                                                              \
    "  --animation NAME|INDEX     which animation (0); or several with their weights: 0:0.3,run:0.7\n"                                                                  \
    "  --probe X,Y,Z,HX,HY,HZ[,SOFTNESS]    adds a probe: the middle of a room and half its size, metres; may be repeated\n" \
    "  --probe auto               adds one for each room, 16 at most, or else for the scene's bounds\n"                \
    "  --probe-reflections        the probes of --probe, else those of the scene, are reflection probes\n" LOADING_VARIANT_HELP LOADING_HELP

struct world_options world_options_default(void);
/** Whether an option that getopt_long gave is one of them. */
bool world_has(int option);
/** Takes its value; false (printed) when that is bad. */
bool world_parse(int option, const char *value, struct world_options *out);
/** What of them does not go together; NULL: all does. */
const char *world_problem(const struct world_options *options);

/** Poses the scene at a time of --animation, which may be several. False with a message. */
bool world_set_time(const struct world_options *options, fnl_scene *scene, double time);
/** Loads, poses and lights the scene, and chooses the camera for a picture of this size. False with a message. `quiet`: nothing else is printed. */
bool world_load(const struct world_options *options, const fnl_host *host, uint32_t width, uint32_t height, bool quiet, fnl_scene **scene,
                fnl_camera *camera);

/** Sets what of the options belongs to the frame, or to what is traced: studio, ground and background. */
void world_set_frame(const struct world_options *options, fnl_frame *frame);
void world_set_trace(const struct world_options *options, fnl_trace_params *params);

/**
 * What --shadows is where nobody says it: maps. Where maps cannot be: none (unless `quiet`, with a warning), as rays would find all
 * shadows, but take far longer than anybody expects who did not ask for them.
 */
fnl_shadows world_usual_shadows(const fnl_scene_info *scene, const fnl_device_info *device, bool quiet);

#endif
