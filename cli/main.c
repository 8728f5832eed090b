/* SPDX-License-Identifier: MIT */
#include "commands.h"
#include "loading.h"
#include "output.h"
#include "print.h"

#include "fanal/base.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static const struct command {
    const char *name, *summary;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"render", "render a scene and write the picture and the numbers", command_render},
#ifdef FANAL_VIEW
    {"view", "show a scene in a window", command_view},
#endif
#ifdef FANAL_XR
    {"xr", "show a scene in a headset, by OpenXR", command_xr},
#endif
    {"cave", "render what is seen through the walls of a CAVE, on several devices and machines", command_cave},
    {"trace", "trace a scene with rays on the CPU: the truth to compare pictures with", command_trace},
    {"bench", "measure light lists and shading paths side by side", command_bench},
    {"info", "print what a scene consists of", command_info},
    {"devices", "list the Vulkan devices and what each offers", command_devices},
    {"compare", "measure how far two pictures are apart", command_compare},
    {"compress", "compress pictures of high dynamic range as BC6H, and decode them", command_compress},
};

enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void print_help(FILE *out) {
    fputs("Fanal renders scenes with thousands of lights on Vulkan.\n\nUsage: fanal COMMAND [OPTIONS] …\n       fanal SCENE\n\n", out);
    for (int i = 0; i < COMMAND_COUNT; i++) fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].summary);
    fputs("\n'fanal SCENE', a .gltf or .glb file or builtin:NAME, opens the viewer. 'fanal help COMMAND' describes a command and its\n"
          "options; 'fanal version' prints the version.\n\n"
          "Example:\n  fanal render \"builtin:city?lights=4096\" --size 1280x720 -o city.png\n",
          out);
}

static bool has_extension(const char *path, const char *extension) {
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}

/* A scene in place of a command: by its name, or as there is a file or folder of this name. */
static bool is_scene(const char *word) {
    return loading_is_builtin(word) || has_extension(word, "gltf") || has_extension(word, "glb") || access(word, F_OK) == 0;
}

/* fanal SCENE [OPTIONS]: as fanal view SCENE [OPTIONS], where there is a screen. */
static int show(int argc, char **argv) {
    const char *problem = "this build of Fanal has no viewer";
#ifdef FANAL_VIEW
    const char *x11 = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    if ((x11 && *x11) || (wayland && *wayland)) {
        static char name[] = "view";
        argv[0] = name;
        return command_view(argc, argv);
    }
    problem = "there is no display for the viewer";
#else
    (void)argc;
#endif
    char *scene = print_shell_word(argv[1]);
    fprintf(stderr, "fanal: error: %s. To render a picture: fanal render %s -o picture.png\n", problem, scene ? scene : "SCENE");
    free(scene);
    return 2;
}

static const struct command *find_command(const char *name) {
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(name, commands[i].name) == 0) return &commands[i];
    return NULL;
}

static int run(int argc, char **argv) {
    static char help[] = "--help";
    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    const bool helps = strcmp(argv[1], "help") == 0;
    if ((helps && argc == 2) || strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_help(stdout);
        return 0;
    }
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "version") == 0) {
        printf("fanal %s\n", fnl_version());
        return 0;
    }
    const char *name = argv[helps ? 2 : 1];
    const struct command *command = find_command(name);
    if (command && helps) return command->run(2, (char *[]){argv[2], help, NULL});
    if (command) return command->run(argc - 1, argv + 1);
    if (!helps && is_scene(name)) return show(argc, argv);
    fprintf(stderr, "fanal: error: there is no command '%s'; see 'fanal help'\n", name);
    return 2;
}

/* Options, files and reports have decimal points, whatever locale a library that is loaded sets for the process: a headset's runtime, a layer of Vulkan. */
static void fix_numbers(void) {
    locale_t base = duplocale(LC_GLOBAL_LOCALE), fixed = base ? newlocale(LC_NUMERIC_MASK, "C", base) : base;
    if (fixed) uselocale(fixed);
}

int main(int argc, char **argv) {
    output_guard_streams();
    fix_numbers();
    int status = run(argc, argv);
    return output_flush() ? status : 2;
}
